"""The compiled kernel, and the table that it writes: neither numpy nor click is imported for them.

It is a distribution of its own, `pyport-pointing-kernel`, that `make wheel` builds from
`kernel_src`. PYPORT_KERNEL=off leaves it out, PYPORT_KERNEL=required insists on it, and the name
of an instruction set, such as AVX2, lets it use no newer one.
"""

from __future__ import annotations

import os
import sys
from array import array
from collections.abc import Sequence
from types import ModuleType

from pyport.errors import BadInput
from pyport.files import write_file

#: What `module.c` must offer; raised with it, so that an older kernel is left out.
INTERFACE = 7


def _installed() -> ModuleType | None:
    """Return the kernel, None where it is not installed or not wanted."""
    wish = os.environ.get("PYPORT_KERNEL", "")
    if wish == "off":
        return None
    try:
        import pyport_kernel as found
    except ImportError:
        if wish == "required":
            raise
        return None
    if getattr(found, "INTERFACE", 1) == INTERFACE:
        if wish in found.levels():
            found.choose(wish)
        return found
    if wish == "required":
        raise ImportError("pyport-pointing-kernel is of another version")
    return None


#: The kernel, None where numpy does the work.
KERNEL = _installed()

#: p1..p12 [deg] of the 3model table to nine decimals, inside the rounding of the printed six:
#: the table's program, given these, writes every printed digit. Others near by do too; within
#: which bounds, `tests/steering/feasible.py` tells.
RECOVERED_DEG = (
    -0.049282183,
    -0.059631502,
    0.009452264,
    -0.013254868,
    0.001393287,
    -0.000304149,
    0.031273499,
    0.011457918,
    -0.011750501,
    0.004538503,
    0.004290860,
    -0.020392426,
)

#: What the RT32's steering reads: 541 x 95 points, one degree apart.
AZ_DEG, ZD_DEG = range(-270, 271), range(-5, 90)
#: Offsets are whole multiples of 1e-7 deg, and fewer than these.
MOST_UNITS = 2**31
WIDER = "an offset does not fit into {} columns"


def places(az_deg: Sequence[float], zd_deg: Sequence[float]) -> tuple[list[str], list[str], int]:
    """Return the axes of a table [deg] as text, and the characters that an offset has beside them.

    Fortran's (I4,I3,2F12.7); a grid that is not in whole degrees has (F10.4,F9.4,2F13.7).
    Raises `BadInput`: a direction does not fit.
    """
    whole = all(one == round(one) for axis in (az_deg, zd_deg) for one in axis)
    sizes, digits, width = ((4, 3), 0, 12) if whole else ((10, 9), 4, 13)
    az, zd = (
        [f"{one:{size}.{digits}f}" for one in axis]
        for size, axis in zip(sizes, (az_deg, zd_deg), strict=True)
    )
    for size, axis in zip(sizes, (az, zd), strict=True):
        for one in axis:
            if len(one) > size:
                raise BadInput(f"a direction of {one} deg does not fit into {size} columns")
    return az, zd, width


def rows(
    kernel: ModuleType, az: Sequence[str], zd: Sequence[str], width: int, d_az: object, d_zd: object
) -> bytes:
    """Return a table's text: `places`, and buffers of offsets [deg].

    Raises
    ------
    BadInput
        An offset does not fit, or is no number.
    """
    columns = [part for axis in (az, zd) for part in ("".join(axis).encode(), len(axis[0]))]
    try:
        text: bytes = kernel.table_rows(*columns, width, d_az, d_zd)
    except OverflowError:
        raise BadInput(WIDER.format(width)) from None
    return text


def answered(words: Sequence[str]) -> bool:
    """Do what `pyport table -o FILE` does; tell whether `words` ask for that and it was done.

    What goes wrong is left to the command itself, which says so.
    """
    if KERNEL is None or len(words) != 3 or words[:2] != ["table", "-o"]:
        return False
    try:
        name = words[2]
        if name.startswith("-") or not name.encode():
            return False
        write_file(name, _text(KERNEL))
        said = f"{len(AZ_DEG) * len(ZD_DEG)} rows, model rt32-3model, refraction rt32-table"
        sys.stdout.write(f"{name}: {said}\n")
        sys.stdout.flush()
    except Exception:  # noqa: BLE001 - the command meets it again, and says it
        return False
    return True


def _text(kernel: ModuleType) -> bytes:
    """Return the text of the published table."""
    az, zd = array("d", AZ_DEG), array("d", ZD_DEG)
    lift = array("d", bytes(8 * len(zd)))
    kernel.table_refraction(zd, lift)
    d_az, d_zd = (array("d", bytes(8 * len(az) * len(zd))) for _ in range(2))
    kernel.table_offsets(array("d", RECOVERED_DEG), az, zd, lift, d_az, d_zd)
    return rows(kernel, *places(AZ_DEG, ZD_DEG), d_az, d_zd)
