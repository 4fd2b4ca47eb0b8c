"""What an effect is, and the circumstances that it acts in.

Signs and axes, everywhere inside the program: azimuth A from north through
east, elevation E, cross-elevation offset x = dAz cos E, elevation offset
y = dEl, both encoder minus true, radians. On a mount with other axes x and y
are along those: x the first axis' offset times the cosine of the second angle.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.columns import SPELLED
from pyport.mounts import ALTAZ, Mount

Index = NDArray[np.intp] | NDArray[np.bool_] | slice

#: Where an effect acts: in the axes of the mount, or in azimuth and elevation on whatever mount.
AXES, SKY = "axes", "sky"
#: The column that says on which side of its pier a telescope is, and the side on which it has
#: turned over.
PIER_SIDE, OVER = "pier_side", "west"

#: The driver of effects that go with the time of the day: the Sun, the hour, time itself.
THE_HOUR = "the hour"
#: What `Effect.in_arrays` may be.
ZERO, LASTING, STEP, HELD = "zero", "lasting", "step", "held"


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
        known = np.isfinite(values)
        if not known.any():
            raise MissingColumn(SPELLED.get(name, name))
        if 2 * known.sum() < len(values):
            raise MissingColumn(f"{SPELLED.get(name, name)} in half of the rows")
        return values

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
        first, second = self.mount.angles(self.az, self.el, self._frame, over)
        return replace(self, az=first, el=second, fine=None, mount=ALTAZ, sky=self)

    @property
    def _frame(self) -> float:
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

    @cached_property
    def turn(self) -> Array | None:
        """Return what turns offsets across and along elevation into those along the axes.

        Shape (2, 2, n), see `Mount.turn`; None where they are the same.
        """
        if self.mount is ALTAZ:
            return None
        return self.mount.turn(self.az, self.el, self._frame)

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


#: Circumstances -> the offset across and along elevation for one of each coefficient, (n, k) each.
Basis = Callable[[Circumstances], tuple[Array, Array]]


@dataclass(frozen=True)
class Coefficient:
    """A number that a fit gives: its name, the unit it is reported in, its known value if any.

    `scale` is the value in internal units (radians, seconds, ...) of one `unit`.
    """

    name: str
    unit: str = "arcsec"
    scale: float = np.pi / 648000
    expected: float | None = None


@dataclass(frozen=True)
class Effect:
    """One physical cause that adds to every recorded offset, linear in its coefficients.

    Attributes
    ----------
    id
        The stable name, as reports and models spell it.
    sentence
        What it is, in words that an observer would use, on whatever mount.
    citation
        Where the formula comes from.
    coefficients
        One for each column of the basis.
    basis
        Circumstances -> (x, y), each of shape (n, k): the offset across and
        along elevation [rad] for a coefficient of one internal unit.
    common
        "array" when all antennas of an array share the coefficients (the sky,
        the clock), "session" when they do within a session (a time tag),
        "antenna" when each antenna has its own (its mechanics).
    physical
        False for a term that describes a shape and names no cause; such a
        term can be part of a model, never the answer of a diagnosis.
    variant
        Which member of a family this is ("k = 3"), "" where there is no choice.
    profile
        For a family with a nonlinear parameter (a harmonic's number, the time of
        a step): circumstances -> the members worth trying there.
    needs
        What the recordings must tell, in the contract's names, beside the
        position; "A or B" where either will do.
    formula
        The offset across and along elevation as text, for a reader.
    parameter
        The nonlinear parameter of a member, in internal units: k, seconds, radians.
    edge
        For a step across a curve in the sky: azimuth -> the curve's elevation [rad].
    driver
        The recorded condition that the effect follows, as `Circumstances` names its column, or
        `THE_HOUR` for what goes with the time of the day or with time itself.
    changes_with
        "session" for a change from one session or epoch to another, "order" for one between rows
        whose times are not known, "time" for a slow one, "stretch" for one that is free in every
        stretch of time, "" for what does not depend on when it was recorded.
    change_of
        The id of the effect whose coefficients change, on an alt-azimuth mount: such a change is
        one of a term that the model has, and no second name for that term.
    member
        What distinguishes this member of its family, as numbers, texts and lists of them, so
        that a file can hold it; empty where there is no choice.
    make
        For a family: `make(**member)` -> the member. What depends on the recordings that a
        family was tried on (a mean, a span of time, names of labels) is part of `member`.
    pattern
        What the recordings show of it, before any cause: "twice per turn of azimuth, in both axes".
    means
        What it is on some kinds of mounts, by the words of `mounts.MOUNTS`; `sentence` claims
        nothing that only some mounts have.
    acts_in
        `AXES`: the basis is given the angles of the mount's axes for azimuth and elevation, and
        its offsets are along them. `SKY`: both are of azimuth and elevation on any mount. "" for
        one that finds its way itself: it is given azimuth and elevation, its offsets are along
        the mount's axes.
    mounts
        The models (`Mount.model`) of the mounts that have it; empty for all.
    of
        For an effect in the words of another mount its id on an alt-azimuth mount.
    in_arrays
        How the antennas of an array are compared: `ZERO` is free in every session, for encoders
        are set anew; `LASTING` stays in a mount from day to day; a `STEP` parts the zeros; what is
        `HELD` these three take up as well. "" for what all share, which is taken out first.
    belongs_to
        The label of what is wrong, such as `source`, where that is not the telescope: it must
        come back with the label from one night to another.
    """

    id: str
    sentence: str
    citation: str
    coefficients: tuple[Coefficient, ...]
    basis: Basis
    common: str = "antenna"
    physical: bool = True
    variant: str = ""
    profile: Callable[[Circumstances], tuple[Effect, ...]] | None = None
    needs: tuple[str, ...] = ()
    formula: tuple[str, str] = ("", "")
    parameter: float | None = None
    edge: Callable[[Array], Array] | None = None
    driver: str | None = None
    changes_with: str = ""
    change_of: str = ""
    member: Mapping[str, Any] = field(default_factory=dict, compare=False)
    make: Callable[..., Effect] | None = field(default=None, compare=False)
    pattern: str = ""
    means: Mapping[str, str] = field(default_factory=dict)
    belongs_to: str = ""
    in_arrays: str = ""
    acts_in: str = ""
    mounts: tuple[str, ...] = ()
    of: str = ""

    @property
    def is_change(self) -> bool:
        """Tell whether it is a change from one state of the telescope to another."""
        return self.changes_with in ("session", "order")

    def variants(self, at: Circumstances) -> tuple[Effect, ...]:
        """Return the members of the family to try in these circumstances, itself if it is none."""
        if self.profile is None:
            return (self,)
        return self.profile(at.axes if self.acts_in == AXES else at)

    def columns(self, at: Circumstances) -> tuple[Array, Array]:
        """Return the basis (x, y), each (n, k), for these circumstances.

        Raises
        ------
        MissingColumn
            The recordings lack something that the effect needs.
        """
        if at.fine is None:
            return self._on_mount(at)
        x, y = self._on_mount(at.fine.at)
        return at.fine.mean(x), at.fine.mean(y)

    def _on_mount(self, at: Circumstances) -> tuple[Array, Array]:
        """Return the basis along the axes of the mount."""
        if self.acts_in == SKY:
            return at.along_axes(*self.basis(at))
        if self.acts_in != AXES or at.mount is ALTAZ:
            return self.basis(at)
        x, y = self.basis(at.axes)
        side = np.reshape(at.side, (-1, 1))
        return x * side, y * side

    def missing(self, at: Circumstances) -> str | None:
        """Name the first column that these recordings lack for this effect, if any."""
        try:
            for one in self.variants(at):
                one.columns(at)
        except MissingColumn as lack:
            return lack.column
        return None


def stack(at: Circumstances, *columns: tuple[Any, Any]) -> tuple[Array, Array]:
    """Return a basis from one (x, y) pair for each coefficient.

    Scalars are spread over the n pointings; what is unknown (NaN) counts as zero.
    """
    out = np.zeros((2, len(at), len(columns)))
    for k, pair in enumerate(columns):
        for axis in (0, 1):
            out[axis, :, k] = pair[axis]
    out[np.isnan(out)] = 0.0
    return out[0], out[1]
