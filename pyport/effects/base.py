"""What an effect is, and the circumstances that it acts in.

Signs and axes, everywhere inside the program: azimuth A from north through
east, elevation E, cross-elevation offset x = dAz cos E, elevation offset
y = dEl, both encoder minus true, radians. On a mount with other axes x and y
are along those: x the first axis' offset times the cosine of the second angle.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.effects.circumstances import (
    OVER,
    PIER_SIDE,
    Circumstances,
    MissingColumn,
    Site,
    SubPointings,
)
from pyport.mounts import ALTAZ

__all__ = [
    "AXES",
    "HELD",
    "LASTING",
    "OVER",
    "PIER_SIDE",
    "SKY",
    "STEP",
    "THE_HOUR",
    "ZERO",
    "Basis",
    "Circumstances",
    "Coefficient",
    "Effect",
    "MissingColumn",
    "Site",
    "SubPointings",
    "stack",
]

#: Where an effect acts: in the axes of the mount, or in azimuth and elevation on whatever mount.
AXES, SKY = "axes", "sky"
#: The driver of effects that go with the time of the day: the Sun, the hour, time itself.
THE_HOUR = "the hour"
#: What `Effect.in_arrays` may be.
ZERO, LASTING, STEP, HELD = "zero", "lasting", "step", "held"

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
    until
        For what was displaced for a while: when it came back, in the unit of its `parameter`.
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
    consists_of
        The ids, on an alt-azimuth mount, of the changes that this one makes together: it is looked
        for where one of them stands.
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
    looks_back
        Whether its offset in a row depends on what was recorded before: rows then belong together.
    belongs_to
        The label of what is wrong, such as `source`, where that is not the telescope: it must
        come back with the label from one night to another.
    wants
        What would have to be recorded for the name to stand alone; "" where nothing is lacking.
    reversed
        What it is where its coefficient is below zero, which its cause does not explain.
    prior
        How far each coefficient may be from where it starts, as one sigma of a normal, in
        internal units: what is known of it before any recordings. Empty where nothing is.
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
    until: float = np.inf
    edge: Callable[[Array], Array] | None = None
    driver: str | None = None
    changes_with: str = ""
    change_of: str = ""
    consists_of: tuple[str, ...] = ()
    member: Mapping[str, Any] = field(default_factory=dict, compare=False)
    make: Callable[..., Effect] | None = field(default=None, compare=False)
    pattern: str = ""
    means: Mapping[str, str] = field(default_factory=dict)
    belongs_to: str = ""
    looks_back: bool = False
    wants: str = ""
    reversed: str = ""
    prior: tuple[float, ...] = field(default=(), compare=False)
    in_arrays: str = ""
    acts_in: str = ""
    mounts: tuple[str, ...] = ()
    of: str = ""

    @property
    def on_altaz(self) -> str:
        """Return its id on an alt-azimuth mount, which is its own unless it is another's there."""
        return self.of or self.id

    @property
    def is_change(self) -> bool:
        """Tell whether it is a change from one state of the telescope to another."""
        return self.changes_with in ("session", "order")

    @property
    def came_back(self) -> bool:
        """Tell whether it displaced something for a while."""
        return self.until < np.inf

    @property
    def is_over(self) -> bool:
        """Tell whether it is known from its own stretch of time alone, not what it is after."""
        return self.came_back or self.changes_with == "stretch"

    @property
    def begins_anew(self) -> bool:
        """Tell whether a term changes with the time since each session began, as by a drift."""
        return self.looks_back and self.driver == THE_HOUR and self.change_of != ""

    @property
    def precision(self) -> Array:
        """Return what is known of each coefficient beforehand, 1 / variance or zero, shape (k,)."""
        if not self.prior:
            return np.zeros(len(self.coefficients))
        return np.asarray(self.prior, float) ** -2.0

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
