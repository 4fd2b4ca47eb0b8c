"""The same answer as before: python tests/reliability/same.py COMMIT.

Ten fixed inputs are diagnosed by this program and as an earlier commit would. Who moves code
promises that nothing else changes: keys may be added, and sentences may have other words; keys
that are gone and values that differ are listed, and end it with status 1.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from pathlib import Path

from machines import Machine, diagnosed, leaves, written

from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.history import History

#: What is shipped, and what is drawn beside it.
SHIPPED = ("gmrt-2003-03-31", "gmrt-2003-06-01", "gmrt-2003-06-05")
DRAWN = (
    Spec("one", "one", "refraction", 0.5, 300),
    Spec("oscillation", "one", "oscillation", 1.0, 600),
    Spec("moment", "one", "epoch_tilt", 1.0, 600),
    Spec("curve", "one", "subreflector_jump", 1.0, 600),
    Spec("mounts", "one", "sag_sine", 1.0, 300, mount="fork"),
    Spec("array", "array", rho=0.7, rows=600),
    Spec("unknown", "unknown", "notch_azimuth", 1.0, 600),
)
#: What a program is, beside the package.
PROGRAM = ("pyport", "golden_tables", "legacy_fortran")
#: Numbers that differ by less are equal: other loops, other rounding.
ROUNDING = 1e-6


def checked_out(commit: str, folder: Path) -> Path:
    """Write the program as it stood in a commit into a folder.

    Raises `BadInput`: this repository has no such commit.
    """
    for part in PROGRAM:
        History.of(Path(__file__)).unpack(commit, part, folder)
    return folder


def alike(one: object, other: object) -> bool:
    """Tell whether two values are equal to rounding, or both sentences."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=ROUNDING, abs_tol=ROUNDING)
    if isinstance(one, str) and isinstance(other, str):
        return one == other or (" " in one and " " in other)
    return bool(one == other)


def main() -> int:
    """Compare; return 1 where something is gone or other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", help="the earlier commit")
    parser.add_argument("program", nargs="?", help="another commit in place of this checkout")
    asked = parser.parse_args()
    equal = True
    with tempfile.TemporaryDirectory(prefix="same-") as name:
        folder = Path(name)
        ways = [Machine("before", program=checked_out(asked.base, folder / "before"))]
        if asked.program:
            ways.append(Machine("now", program=checked_out(asked.program, folder / "now")))
        else:
            ways.append(Machine("now"))
        given = [*((one,) for one in SHIPPED), *written(DRAWN, folder)]
        before, now = (diagnosed(one, given, folder / f"out-{one.name}") for one in ways)
        for case, report in before.items():
            old, new = dict(leaves(report)), dict(leaves(now[case]))
            gone = [place for place in old if place not in new]
            other = [place for place in old if place in new and not alike(old[place], new[place])]
            counts = f"{len(gone)} gone, {len(other)} other"
            print(f"{case}: {len(old)} values, {len(new)} now; {counts}", flush=True)
            for place in [*gone, *other][:8]:
                print(f"    {place}: {old[place]} -> {new.get(place, 'gone')}")
            equal &= not gone and not other
    return int(not equal)


if __name__ == "__main__":
    sys.exit(main())
