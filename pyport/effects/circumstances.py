"""The circumstances that effects act in: where the telescope pointed, when, under which weather.

Signs and axes are those of `base`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.columns import SPELLED
from pyport.mounts import ALTAZ, Mount

Index = NDArray[np.intp] | NDArray[np.bool_] | slice

#: The column that says on which side of its pier a telescope is, and the side on which it has
#: turned over.
PIER_SIDE, OVER = "pier_side", "west"


#: A gap between measurements that separates two nights [s]: longer than any break within one,
#: shorter than a summer's day.
NIGHT_GAP_S = 6 * 3600.0
DAY_S = 86400.0


def nights_of(time: Array) -> Codes:
    """Return the number of the night of each moment [s], shape (n,), in the order of time."""
    order, night = np.argsort(time, kind="stable"), np.zeros(len(time), np.intp)
    night[order[1:]] = np.cumsum(np.diff(time[order]) > NIGHT_GAP_S)
    return night


def utc(time: float) -> str:
    """Return a moment [s, UTC since 1970] as ISO 8601, to the second."""
    return f"{np.datetime64(round(time), 's')}Z"


def mostly_known(values: Array) -> bool:
    """Tell whether at least half of some numbers are known: of what fewer tell nothing is said."""
    known = np.isfinite(values)
    return bool(known.any()) and 2 * int(known.sum()) >= len(values)


class MissingColumn(LookupError):  # noqa: N818 - reported, not raised to the user
    """An effect needs something that these recordings do not tell."""

    def __init__(self, column: str):
        self.column = column
        super().__init__(f"needs {column}")


@dataclass(frozen=True)
class Site:
    """A geodetic position: latitude and longitude (east positive) [rad], height [m]."""

    latitude: float
    longitude: float | None = None
    height_m: float = 0.0


@dataclass(frozen=True)
class Circumstances:
    """Where the telescope pointed, when, and in which conditions; n pointings.

    `az` (from north through east, unwrapped as the cable is) and `el` are
    true positions [rad], shape (n,). `columns` holds whatever else is known,
    shape (n,) each, under the contract's names without a unit: `time` [s, UTC
    since 1970], `hour_angle` (positive west), `ra`, `dec` [rad],
    `scan_direction` (+1, -1, 0 for unknown), `scan_rate` [rad/s, positive],
    `temperature_c`, ... and the labels `antenna`, `session`, `scan_axis`,
    `source`, ... as strings. Numbers that are not known are NaN, labels "".
    Where the pointings are means over many, `fine` tells of what. The axes of the `mount`, which
    is of azimuth and elevation where nothing else is said, are those of the offsets.
    """

    az: Array
    el: Array
    site: Site | None = None
    columns: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    fine: SubPointings | None = None
    mount: Mount = ALTAZ
    sky: Circumstances | None = None

    def __len__(self) -> int:
        """Return n, the number of pointings."""
        return len(self.el)

    def __contains__(self, name: str) -> bool:
        """Tell whether a column is there."""
        return name in self.columns

    def column(self, name: str) -> NDArray[Any]:
        """Return a column, or raise `MissingColumn` under the contract's name."""
        try:
            return self.columns[name]
        except KeyError:
            raise MissingColumn(SPELLED.get(name, name)) from None

    def numbers(self, name: str) -> Array:
        """Return a column of numbers, NaN where unknown; half of them must be known.

        A pointing whose circumstances are unknown shows nothing of an effect;
        were that most of them, a verdict on the effect would mean nothing.
        """
        values = np.asarray(self.column(name), float)
        if not mostly_known(values):
            where = " in half of the rows" if np.isfinite(values).any() else ""
            raise MissingColumn(SPELLED.get(name, name) + where)
        return values

    @property
    def times(self) -> Array | None:
        """Return the moments [s, UTC since 1970], shape (n,); None where any is not known."""
        if "time" not in self:
            return None
        time = np.asarray(self.column("time"), float)
        return time if np.isfinite(time).all() else None

    def latitude(self) -> float:
        """Return the site's latitude [rad], or raise `MissingColumn`."""
        if self.site is None:
            raise MissingColumn("latitude_deg")
        return self.site.latitude

    def longitude(self) -> float:
        """Return the site's longitude [rad, east positive], or raise `MissingColumn`."""
        if self.site is None or self.site.longitude is None:
            raise MissingColumn("longitude_deg")
        return self.site.longitude

    @cached_property
    def side(self) -> Array | float:
        """Return -1 where the mount has turned over, +1 elsewhere, shape (n,)."""
        if not self.mount.turns_over:
            return 1.0
        return np.where(self.column(PIER_SIDE) == OVER, -1.0, 1.0)

    @cached_property
    def axes(self) -> Circumstances:
        """Return the same with the angles of the mount's axes for `az` and `el`.

        `sky` is where it really points: these circumstances; None where they are one.
        """
        if self.mount is ALTAZ:
            return self
        over = np.equal(self.side, -1.0) if self.mount.turns_over else None
        first, second = self.mount.angles(self.az, self.el, self.frame, over)
        return replace(self, az=first, el=second, fine=None, mount=ALTAZ, sky=self)

    @property
    def onto_sky(self) -> Array:
        """Return what brings offsets of the mount's first axis onto the sky, cos E, shape (n,).

        Below zero past the zenith.
        """
        return np.asarray(np.cos(self.axes.el) * self.side)

    @property
    def frame(self) -> float:
        """Return the latitude [rad] that the mount's axes depend on; 0 where they do not."""
        return self.latitude() if self.mount.needs_latitude else 0.0

    def along_axes(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return offsets across and along elevation, shape (n, ...), as the mount's axes show them.

        Both ways of pointing at a direction show them alike: see `side`.
        """
        if self.turn is None:
            return x, y
        both = np.einsum("abn,bn...->an...", self.turn, np.stack(np.broadcast_arrays(x, y)))
        return both[0], both[1]

    def along_sky(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return offsets along the mount's axes, shape (n,), as those across and along elevation.

        The inverse of `along_axes`.
        """
        if self.turn is None:
            return x, y
        across, along = np.einsum("abn,an->bn", self.turn, np.stack([x, y]))
        return across, along

    @cached_property
    def turn(self) -> Array | None:
        """Return what turns offsets across and along elevation into those along the axes.

        Shape (2, 2, n), see `Mount.turn`; None where they are the same.
        """
        if self.mount is ALTAZ:
            return None
        return self.mount.turn(self.az, self.el, self.frame)

    def take(self, index: Index) -> Circumstances:
        """Return the pointings that a mask, slice or list of rows selects."""
        columns = {name: values[index] for name, values in self.columns.items()}
        fine = None if self.fine is None else self.fine.take(np.arange(len(self))[index])
        return replace(self, az=self.az[index], el=self.el[index], columns=columns, fine=fine)


@dataclass(frozen=True)
class SubPointings:
    """What mean pointings are the means of: an effect's mean is not its value at the mean place.

    Attributes
    ----------
    at
        N places, each with its circumstances.
    pointing
        Which of the mean pointings each belongs to, ascending, shape (N,); each has one or more.
    share
        How much of it each makes up, shape (N,).
    """

    at: Circumstances
    pointing: NDArray[np.intp]
    share: Array

    def mean(self, values: Array) -> Array:
        """Return the means of values (N, k) over each pointing, shape (n, k)."""
        first = np.flatnonzero(np.diff(self.pointing, prepend=-1))
        return np.asarray(np.add.reduceat(values * self.share[:, None], first, axis=0))

    def take(self, rows: NDArray[np.intp]) -> SubPointings:
        """Return what some of the pointings, in their new order, are the means of."""
        starts = np.searchsorted(self.pointing, rows)
        counts = np.searchsorted(self.pointing, rows, side="right") - starts
        number = np.repeat(np.arange(len(rows)), counts)
        kept = np.arange(counts.sum()) + np.repeat(starts - np.cumsum(counts) + counts, counts)
        return SubPointings(self.at.take(kept), number, self.share[kept])
