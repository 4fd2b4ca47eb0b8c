"""What tests of several folders read: real recordings, or the skip without them; a term."""

import os
from pathlib import Path

import pytest

#: The term of a model file in which receiver X is off by 60 and 30 arcsec from K.
OF_RECEIVERS = """
[[term]]
effect = "receiver_offset"
per = []
variant = "by receiver"
member = { by = "receiver", values = ["K", "X"], starts_mhz = [] }
coefficients = [
  { name = "offset_xel[X]", value = -60.0, unit = "arcsec" },
  { name = "offset_el[X]", value = 30.0, unit = "arcsec" },
]
"""


def sample(name):
    """Return a real file, or skip with the reason."""
    path = Path(os.environ.get("PYPORT_SHARED_DATA", "../shared/data")) / name
    if not path.is_file():
        pytest.skip(f"no real recordings at {path}")
    return path
