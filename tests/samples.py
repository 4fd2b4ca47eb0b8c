"""Where real recordings stand, and the skip on a machine that has none."""

import os
from pathlib import Path

import pytest


def sample(name):
    """Return a real file, or skip with the reason."""
    path = Path(os.environ.get("PYPORT_SHARED_DATA", "../shared/data")) / name
    if not path.is_file():
        pytest.skip(f"no real recordings at {path}")
    return path
