"""Offsets at any azimuth and zenith distance from a table, and how far they can be trusted."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import DEG, Array
from pyport.errors import BadInput
from pyport.pointing import kernel
from pyport.steering.ascii import read_ascii
from pyport.steering.binary import MAGIC, read_binary
from pyport.steering.grid import Table
from pyport.steering.tabulate import OffsetsDeg, zenith_refraction

#: Edges of the zenith-distance bands that interpolation errors are stated for [deg].
BANDS_DEG = (-5, -1, 1, 2, 5, 10, 30, 60, 80, 89)

#: Look-ups of a block: what stands between place and offset stays in the processor's cache.
BLOCK = 8192

#: Neighbours in a table whose zenith-distance offsets differ by more have a step between them;
#: smooth terms of the size of pointing errors differ by a hundredth of this.
STEP_DEG = 0.01


def read_table(path: str | Path) -> Table:
    """Read a table, binary or ASCII, whichever the file is."""
    with Path(path).open("rb") as file:
        binary = file.read(len(MAGIC)) == MAGIC
    return read_binary(path) if binary else read_ascii(path)


def offsets_at(table: Table, az_deg: ArrayLike, zd_deg: ArrayLike) -> tuple[Array, Array]:
    """Return azimuth and zenith-distance offset [deg], interpolated linearly in both.

    Parameters
    ----------
    table
        The table.
    az_deg, zd_deg
        Where, in the table's own azimuth, unwrapped: Az and Az + 360 are different
        rows. Any shapes that broadcast.

    Raises
    ------
    BadInput
        The table does not reach so far.
    """
    az_deg, zd_deg = np.broadcast_arrays(
        np.asarray(az_deg, dtype=float), np.asarray(zd_deg, dtype=float)
    )
    nodes = table.grid.az_deg, table.grid.zd_deg
    # One piece of memory: two are given back to the system, which fills them anew each time.
    both = np.empty((2, *az_deg.shape))
    d_az_deg, d_zd_deg = both[0, ...], both[1, ...]
    az, zd, *out = (one.reshape(-1) for one in (az_deg, zd_deg, d_az_deg, d_zd_deg))
    if kernel.look_up(nodes, table.side_by_side, (az, zd), out):
        return d_az_deg[()], d_zd_deg[()]
    _within("azimuth", az_deg, nodes[0])
    _within("zenith distance", zd_deg, nodes[1])
    of = [np.ascontiguousarray(one).reshape(-1) for one in (table.d_az_deg, table.d_zd_deg)]
    for low in range(0, len(az), BLOCK):
        some = slice(low, low + BLOCK)
        corners = _corners(_place(az[some], nodes[0]), _place(zd[some], nodes[1]), len(nodes[1]))
        for offsets, answer in zip(of, out, strict=True):
            total = answer[some]
            for n, (cell, share) in enumerate(corners):
                part = offsets.take(cell, mode="clip")
                if n == 0:
                    np.multiply(part, share, out=total)
                else:
                    part *= share
                    total += part
    return d_az_deg[()], d_zd_deg[()]


def beside_zenith(table: Table) -> tuple[float, float]:
    """Return between which zenith distances [deg] cells touch the zenith; 0 and 0 where none does.

    Azimuth offsets grow as 1 / sin z and turn over there: linearly interpolated they are off by
    tens of degrees.
    """
    nodes = table.grid.zd_deg
    if nodes[0] > 0 or nodes[-1] < 0:
        return 0.0, 0.0
    return float(max(nodes[nodes < 0], default=0)), float(min(nodes[nodes > 0], default=0))


def _within(what: str, wanted: Array, nodes: Array) -> None:
    """Refuse places beyond the table, and those that are no numbers."""
    if wanted.size == 0 or (wanted.min() >= nodes[0] and wanted.max() <= nodes[-1]):
        return
    outside = ~((wanted >= nodes[0]) & (wanted <= nodes[-1]))
    raise BadInput(
        f"{what} {wanted[outside].flat[0]:g} deg is outside the table, "
        f"which reaches from {nodes[0]:g} to {nodes[-1]:g}"
    )


def _place(wanted: Array, nodes: Array) -> tuple[NDArray[np.int32], Array]:
    """Return the node at or before each value, and how far on it lies, 0 to 1."""
    along = wanted - nodes[0]
    along *= (len(nodes) - 1) / (nodes[-1] - nodes[0])
    i = along.astype(np.int32)
    np.minimum(i, len(nodes) - 2, out=i)
    along -= i
    return i, along


def _corners(
    az: tuple[NDArray[np.int32], Array], zd: tuple[NDArray[np.int32], Array], row: int
) -> list[tuple[NDArray[np.intp], Array]]:
    """Return the four corners of each cell, as places in a table of rows, and their shares."""
    (i, u), (j, v) = az, zd
    first = (i * row + j).astype(np.intp)
    both = u * v
    east, north = u - both, v - both
    shares = (1 - u) - north, north, east, both
    return [(first + step, share) for step, share in zip((0, 1, row, row + 1), shares, strict=True)]


def answers(table: Table, lines: Iterable[str], file: str) -> Iterator[str]:
    """Yield azimuth, zenith distance and their offsets for each line of azimuth, zenith distance.

    One answer a line, as soon as the line is there: for a steering program at the other
    end of a pipe. Blank lines are passed over.
    """
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            az_deg, zd_deg = (float(word) for word in line.split())
        except ValueError:
            raise BadInput(
                f"expected azimuth and zenith distance [deg], found {line.strip()[:40]!r}",
                file,
                number,
            ) from None
        try:
            d_az_deg, d_zd_deg = offsets_at(table, az_deg, zd_deg)
        except BadInput as outside:
            raise BadInput(outside.message, file, number) from None
        # A blank stands before each, however wide: near the zenith azimuth is off by 100 deg.
        yield f"{az_deg:12.7f} {zd_deg:11.7f} {d_az_deg:11.7f} {d_zd_deg:11.7f}"


@dataclass(frozen=True)
class BandError:
    """How far interpolation strays in one band of zenith distance, the middles of its cells.

    Azimuth errors are on the sky, times sin z. `steps` cells are crossed by a step of the
    model, and are not in the other numbers; `step_deg` is their largest error.
    """

    zd_from_deg: float
    zd_to_deg: float
    az_rms_deg: float
    az_max_deg: float
    zd_rms_deg: float
    zd_max_deg: float
    steps: int
    step_deg: float


def interpolation_errors(table: Table, truth: OffsetsDeg) -> list[BandError]:
    """Compare interpolated offsets with the model's in the middle of every cell of the table.

    `table`: the table.
    `truth`: the model behind it.
    """
    az_nodes, zd_nodes = table.grid.az_deg, table.grid.zd_deg
    az_deg, zd_deg = np.meshgrid(
        (az_nodes[1:] + az_nodes[:-1]) / 2, (zd_nodes[1:] + zd_nodes[:-1]) / 2, indexing="ij"
    )
    true_az, true_zd = truth(az_deg, zd_deg)
    ours_az, ours_zd = offsets_at(table, az_deg, zd_deg)
    error_az = np.abs((ours_az - true_az) * np.sin(zd_deg * DEG))
    error_zd = np.abs(ours_zd - true_zd)
    crossed = _crossed(table)
    bands = []
    for low, high in itertools.pairwise(BANDS_DEG):
        band = (zd_deg > low) & (zd_deg < high)
        plain, steps = band & ~crossed, band & crossed
        if not plain.any():
            continue
        bands.append(
            BandError(
                low,
                high,
                float(np.sqrt(np.mean(error_az[plain] ** 2))),
                float(np.max(error_az[plain])),
                float(np.sqrt(np.mean(error_zd[plain] ** 2))),
                float(np.max(error_zd[plain])),
                int(np.sum(steps)),
                float(np.max(error_zd[steps], initial=0)),
            )
        )
    return bands


def _crossed(table: Table) -> NDArray[np.bool_]:
    """Tell the cells whose corners differ as if a step of the model ran between them.

    Refraction makes the corners differ too, and is taken out first.
    """
    uneven = table.d_zd_deg + zenith_refraction(table.refraction, table.grid.zd_deg)
    corners = np.stack([uneven[:-1, :-1], uneven[1:, :-1], uneven[:-1, 1:], uneven[1:, 1:]])
    return np.ptp(corners, axis=0) > STEP_DEG
