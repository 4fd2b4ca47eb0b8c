"""The numbers of the published 3model table, read from the text as it was printed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.files import write_whole

#: The printed texts; `golden_tables/published` in the source tree.
FOLDER = Path(__file__).parent / "published"

#: Heading of each block of the extracts -> (its name here, what is compared, unit [deg]).
_HEADINGS = {
    "Azimuth offsets": ("azimuth offsets", "d_az", 1e-3),
    "Zenith angle offsets": ("zenith-distance offsets", "d_zd", 1e-3),
    "Azimuth differences": ("azimuth, approximate - exact", "d_az_difference", 1e-4),
    "Zenith angle differences": ("zenith distance, approximate - exact", "d_zd_difference", 1e-4),
}


@dataclass(frozen=True)
class Block:
    """Printed numbers of one kind: n cells.

    `name`: what the block is called in a report.
    `quantity`: "d_az", "d_zd", "d_az_difference" or "d_zd_difference".
    `unit_deg`: the unit of the last printed digit [deg].
    `az_deg`, `zd_deg`: where, azimuth from south through west, shape (n,).
    `printed`: the numbers as whole multiples of the unit, shape (n,).
    """

    name: str
    quantity: str
    unit_deg: float
    az_deg: Array
    zd_deg: Array
    printed: NDArray[np.int64]


def _extract(lines: Iterator[str], all_zd_deg: list[float]) -> tuple[Array, Array, list[int]]:
    """Read the rows below a heading; dots stand for rows of zeroes between their neighbours."""
    columns = [float(word) for word in next(lines).split()[1:]]
    cells: dict[float, list[int]] = {}
    for line in takewhile(lambda line: line[:6].strip()[-1:].isdigit() or "zeroes" in line, lines):
        if "zeroes" in line:
            cells |= {zd: [0] * len(columns) for zd in all_zd_deg if zd > max(cells)}
        else:
            width = slice(6, None)  # F6.2, then I5 for each azimuth, without a blank between
            digits = line[width]
            cells[float(line[:6])] = [int(digits[i : i + 5]) for i in range(0, len(digits), 5)]
    az_deg, zd_deg = np.meshgrid(columns, list(cells))
    return az_deg.ravel(), zd_deg.ravel(), [one for row in cells.values() for one in row]


def extracts() -> list[Block]:
    """Return the four blocks of the extracts, in print order."""
    text = (FOLDER / "3model_extracts.txt").read_text(encoding="ascii")
    blocks: list[Block] = []
    for heading, (name, quantity, unit_deg) in _HEADINGS.items():
        lines = iter(text.splitlines())
        while not next(lines).startswith(heading):
            pass
        known = list(np.unique(blocks[0].zd_deg)) if blocks else []
        az_deg, zd_deg, printed = _extract(lines, known)
        blocks.append(Block(name, quantity, unit_deg, az_deg, zd_deg, np.array(printed)))
    return blocks


def full_rows() -> list[Block]:
    """Return the rows that are printed in full: a block of azimuth, one of zenith distance."""
    text = (FOLDER / "3model_rows.txt").read_text(encoding="ascii")
    words = [line.split() for line in text.splitlines() if not line.strip().startswith(".")]
    az_deg, zd_deg, d_az, d_zd = np.array(words, dtype=float).T
    return [
        Block(f"full rows, {name}", quantity, 1e-7, az_deg, zd_deg, np.rint(d * 1e7).astype(int))
        for name, quantity, d in (("azimuth", "d_az", d_az), ("zenith distance", "d_zd", d_zd))
    ]


def write_recordings(path: str | Path) -> None:
    """Write the extracts as recordings, for `pyport diagnose` to find what the routines lack.

    Each cell is a measured offset whose error is that of rounding, a unit of the last
    digit over the root of twelve. Azimuth cells at z = 0.1 deg are left out: there the
    rounding of the parameters is larger than that of the table.
    """
    with write_whole(path) as file:
        file.write("# telescope: RT32, 3model table as printed\n# azimuth_zero: south\n")
        file.write("# highest_el_deg: 95\n")
        file.write("az_deg,el_deg,d_az_deg,d_zd_deg,sigma_xel_deg,sigma_el_deg\n")
        for block in extracts()[:2]:
            sigma_deg = block.unit_deg / np.sqrt(12)
            for az, zd, units in zip(block.az_deg, block.zd_deg, block.printed, strict=True):
                where, offset = f"{az:g},{90 - zd:g}", f"{units * block.unit_deg:.3f}"
                if block.quantity == "d_zd":
                    file.write(f"{where},,{offset},,{sigma_deg:.3g}\n")
                elif zd != 0.1:
                    across_deg = sigma_deg * abs(np.sin(zd * DEG))
                    file.write(f"{where},{offset},,{across_deg:.3g},\n")


def published() -> list[Block]:
    """Return every printed number of the 3model table."""
    return extracts() + full_rows()
