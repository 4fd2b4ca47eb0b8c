"""The 3model table's digest, a number a column, kept beside the program: `make golden` renews it.

A digest that changed names the azimuth; the bytes of the whole table are held by a SHA-256.
"""

from __future__ import annotations

import hashlib
import zlib
from pathlib import Path

from pyport.files import write_file
from pyport.steering.ascii import rows
from pyport.steering.grid import Table
from pyport.steering.tabulate import tabulate

#: In a checkout; what is installed does not need it.
FILE = Path(__file__).parents[2] / "golden_tables" / "steering" / "3model.digests"


def digests(table: Table) -> list[str]:
    """Return the table's digest as lines: SHA-256 of all, then azimuth and CRC-32 of its rows."""
    text = [line + "\n" for line in rows(table)]
    lines = [f"sha256 {hashlib.sha256(''.join(text).encode()).hexdigest()}"]
    height = len(table.grid.zd_deg)
    for i, az in enumerate(table.grid.az_deg):
        column = "".join(text[i * height : (i + 1) * height])
        lines.append(f"{az:.0f} {zlib.crc32(column.encode()):08x}")
    return lines


if __name__ == "__main__":
    new = "\n".join(digests(tabulate())) + "\n"
    if not FILE.is_file() or FILE.read_text(encoding="ascii") != new:
        write_file(FILE, new)
