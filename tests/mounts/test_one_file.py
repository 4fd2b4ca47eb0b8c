"""Another mount is one file: beside the others it is read, fitted, named and diagnosed."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import pyport

NEW = '''
"""An alt-alt mount: its first axis lies east and west, the second angle is zero in the meridian."""

import numpy as np

from pyport.angles import DEG
from pyport.mounts.base import Axis, Mount

MOUNTS = (
    Mount(
        id="alt-alt",
        sentence="an alt-alt mount",
        first=Axis("U", "U", "u", "d_u", -90 * DEG, 90 * DEG),
        second=Axis("V", "V", "v", "d_v", -80 * DEG, 80 * DEG),
        across="cross-V",
        across_column="d_xu",
        frame=lambda _: np.array([[0.0, 0, 1], [-1.0, 0, 0], [0, 1.0, 0]]),
        model="alt-alt",
        words={"azimuth": "U", "elevations": "V", "elevation": "V", "tilt": "u axis tilt"},
    ),
)
'''


@pytest.mark.slow
def test_one_file_is_a_mount(tmp_path):
    """With the file alone `fit` knows columns, mount, terms and words."""
    package = tmp_path / "pyport"
    package.mkdir()
    for part in Path(pyport.__file__).parent.iterdir():
        if part.name != "mounts":
            (package / part.name).symlink_to(part)
    (package / "mounts").mkdir()
    for part in (Path(pyport.__file__).parent / "mounts").glob("*.py"):
        (package / "mounts" / part.name).symlink_to(part)
    (package / "mounts" / "altalt.py").write_text(NEW)
    rng = np.random.default_rng(1)
    u, v = np.degrees(rng.uniform(-1, 1, (2, 60)))
    x = 50 * np.cos(np.radians(v)) - 20 + rng.normal(0, 1, 60)
    rows = np.stack([u, v, x, 30 + rng.normal(0, 1, 60)], axis=1)
    night = tmp_path / "night.csv"
    lines = [",".join(f"{one:.6f}" for one in row) for row in rows]
    night.write_text("\n".join(["u_deg,v_deg,d_xu_arcsec,d_v_arcsec", *lines, ""]))
    done = subprocess.run(
        [sys.executable, "-m", "pyport", "fit", night, "--mount", "alt-alt", "--model", "alt-alt"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stderr
    found = {line.split()[0]: line.split()[1] for line in done.stdout.splitlines() if line}
    assert abs(float(found["u_zero"]) - 50) < 3
    assert abs(float(found["v_zero"]) - 30) < 3
    assert abs(float(found["collimation"]) + 20) < 3
    assert "cross-V: rms" in done.stdout
