"""The ASCII table, in the layout that was published: one row a point, azimuth slowest."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.steering.grid import UNITS_PER_DEG, Grid, Table


def rows(table: Table) -> Iterator[str]:
    """Yield the table's rows without line ends: Fortran's (I4,I3,2F12.7).

    A grid that is not in whole degrees has wider columns: (F10.4,F9.4,2F13.7).
    """
    az_deg, zd_deg = table.grid.az_deg, table.grid.zd_deg
    whole = np.all(az_deg == np.rint(az_deg)) and np.all(zd_deg == np.rint(zd_deg))
    place, width = ("{:4.0f}{:3.0f}", 12) if whole else ("{:10.4f}{:9.4f}", 13)
    d_az, d_zd = table.units() / UNITS_PER_DEG
    for i, az in enumerate(az_deg):
        for j, zd in enumerate(zd_deg):
            yield f"{place.format(az, zd)}{d_az[i, j]:{width}.7f}{d_zd[i, j]:{width}.7f}"


def _words(line: str) -> list[str]:
    """Return the four numbers of a row: by blanks, or where large ones leave none by columns."""
    words = line.split()
    return words if len(words) == 4 else [line[:4], line[4:7], line[7:19], line[19:]]


def write_ascii(table: Table, path: str | Path) -> None:
    """Write the table; the same table always gives the same bytes."""
    with write_whole(path) as file:
        for row in rows(table):
            file.write(row + "\n")


def read_ascii(path: str | Path) -> Table:
    """Read a table in the published layout.

    Raises
    ------
    BadInput
        A row does not hold four numbers, or the rows are no full grid.
    """
    try:
        lines = Path(path).read_text(encoding="ascii").splitlines()
    except UnicodeDecodeError:
        raise BadInput("is no text; an ASCII steering table was expected", path) from None
    numbers = np.empty((len(lines), 4))
    for i, line in enumerate(lines):
        try:
            numbers[i] = [float(word) for word in _words(line)]
        except ValueError:
            raise BadInput(
                "expected azimuth, zenith distance and their two offsets [deg], four numbers, "
                f"found {line[:40]!r}",
                path,
                i + 1,
            ) from None
    grid = Grid(np.unique(numbers[:, 0]), np.unique(numbers[:, 1]))
    az_deg, zd_deg = grid.points_deg()
    expected = np.stack([az_deg.ravel(), zd_deg.ravel()], axis=1)
    if len(numbers) == 0 or expected.shape != numbers[:, :2].shape:
        raise BadInput(
            f"has {len(lines)} rows, a full grid of its azimuths and zenith distances "
            f"has {len(expected)}",
            path,
            max(len(lines), 1),
        )
    wrong = np.flatnonzero((numbers[:, :2] != expected).any(axis=1))
    if len(wrong):
        az, zd = expected[wrong[0]]
        raise BadInput(
            f"expected the row of azimuth {az:g} and zenith distance {zd:g}", path, wrong[0] + 1
        )
    shape = az_deg.shape
    d_az_deg, d_zd_deg = numbers[:, 2].reshape(shape), numbers[:, 3].reshape(shape)
    return Table(grid, d_az_deg, d_zd_deg)
