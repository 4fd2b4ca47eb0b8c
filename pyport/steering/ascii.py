"""The ASCII table, in the layout that was published: one row a point, azimuth slowest."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.pointing import compiled, kernel
from pyport.steering.grid import Grid, Table


def rows(table: Table) -> Iterator[str]:
    """Yield the table's rows without line ends: Fortran's (I4,I3,2F12.7).

    A grid that is not in whole degrees has wider columns: (F10.4,F9.4,2F13.7).
    """
    yield from text(table).decode("ascii").splitlines()


def text(table: Table) -> bytes:
    """Return the table's rows, each with its line end."""
    az_deg, zd_deg = table.grid.az_deg, table.grid.zd_deg
    az_text, zd_text, width = compiled.places(az_deg.tolist(), zd_deg.tolist())
    if kernel.KERNEL is not None:
        offsets = map(np.ascontiguousarray, (table.d_az_deg, table.d_zd_deg))
        return compiled.rows(kernel.KERNEL, az_text, zd_text, width, *offsets)
    az, zd = (
        np.array([list(one.encode()) for one in places], np.uint8) for places in (az_text, zd_text)
    )
    shape = len(az), len(zd)
    d_az, d_zd = (decimals(units, width) for units in table.units())
    columns = [
        np.broadcast_to(az[:, None], (*shape, az.shape[1])),
        np.broadcast_to(zd, (*shape, zd.shape[1])),
        d_az,
        d_zd,
        np.full((*shape, 1), ord("\n"), np.uint8),
    ]
    return np.concatenate(columns, axis=2).tobytes()


def decimals(units: NDArray[np.int64], width: int) -> NDArray[np.uint8]:
    """Return whole units of 1e-7 as text, F`width`.7, one more axis of `width` characters."""
    # what is no number has become the least of them, of which there is no absolute value
    if not np.all((units < compiled.MOST_UNITS) & (units > -compiled.MOST_UNITS)):
        raise BadInput(compiled.WIDER.format(width))
    rest = np.abs(units).astype(np.int32)
    out = np.full((*units.shape, width), ord(" "), np.uint8)
    zero = ord("0")
    for place in range(width - 1, -1, -1):
        if place == width - 8:
            out[..., place] = ord(".")
            continue
        tens = rest // 10
        rest, digit = tens, (rest - 10 * tens).astype(np.uint8)
        # one digit stands before the point, others only where there is something to say
        there = slice(None) if place >= width - 9 else (rest > 0) | (digit > 0)
        out[..., place][there] = digit[there] + zero
    negative = np.nonzero(units < 0)
    first = np.argmax(out[negative] != ord(" "), axis=-1)
    out[(*negative, first - 1)] = ord("-")
    return out


def _words(line: str) -> list[str]:
    """Return the four numbers of a row: by blanks, or where large ones leave none by columns."""
    words = line.split()
    return words if len(words) == 4 else [line[:4], line[4:7], line[7:19], line[19:]]


def write_ascii(table: Table, path: str | Path) -> None:
    """Write the table; the same table always gives the same bytes."""
    with write_whole(path, "wb") as file:
        file.write(text(table))


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
    numbers = np.full((len(lines), 4), np.nan)
    for i, line in enumerate(lines):
        with contextlib.suppress(ValueError):
            numbers[i] = [float(word) for word in _words(line)]
        if not np.isfinite(numbers[i]).all():
            raise BadInput(
                "expected azimuth, zenith distance and their two offsets [deg], four numbers, "
                f"found {line[:40]!r}",
                path,
                i + 1,
            )
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
    grid.check(path)
    shape = az_deg.shape
    d_az_deg, d_zd_deg = numbers[:, 2].reshape(shape), numbers[:, 3].reshape(shape)
    return Table(grid, d_az_deg, d_zd_deg)
