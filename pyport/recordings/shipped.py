"""The GMRT's elevation offsets of 2003 (Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II).

`printed/` holds the tables as printed, `data/` the recordings made of them by
`python -m pyport.recordings.shipped`; README.md tells how.
"""

from __future__ import annotations

from pathlib import Path

DATA = Path(__file__).parent / "data"

#: Name on the command line -> the sessions in that file.
NAMES: dict[str, tuple[str, ...]] = {
    "gmrt-2003-03-31": ("2003-03-31",),
    "gmrt-2003-05-31": ("2003-05-31",),
    "gmrt-2003-06-01": ("2003-06-01",),
    "gmrt-2003-06-02": ("2003-06-02",),
    "gmrt-2003-06-05": ("2003-06-05",),
    "gmrt-cyg-a": ("2003-06-01", "2003-06-02", "2003-06-05"),
}


def path(name: str) -> Path:
    """Return the CSV file of a shipped set: `gmrt-2003-06-01`, `2003-06-01`, `cyg-a`, ..."""
    full = name if name.startswith("gmrt-") else f"gmrt-{name}"
    if full not in NAMES:
        raise KeyError(name)
    return DATA / f"{full}.csv"
