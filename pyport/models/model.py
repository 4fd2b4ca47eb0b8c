"""Pointing models: lists of effects, each with its own coefficients for all rows or per label."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.columns import LABELS, SPELLED
from pyport.effects import Circumstances, Coefficient, Effect, MissingColumn, Site, catalogue
from pyport.errors import BadInput
from pyport.models.labels import first_unknown, refuse_unknown
from pyport.mounts import ALTAZ, BY_MODEL, Mount

if TYPE_CHECKING:
    from pyport.models.conditions import Completed
    from pyport.recordings.schema import Recordings

#: Labels that split the coefficients of a classical model: each antenna has its own mount.
PER_ANTENNA = ("antenna",)
PER_ANTENNA_DAY = ("antenna", "session")

#: What columns are called inside the program, by their names in recordings.
INSIDE = {spelled: own for own, spelled in SPELLED.items()}
#: No effect needs more columns than this.
MOST_NEEDS = 6


@dataclass(frozen=True)
class Term:
    """An effect in a model, with one set of coefficients for every value of the labels `per`.

    `values` hold before anything is fitted, those of `by` where they differ between the
    labels; a fixed term keeps them. `finding` is the number of the finding, from 1, that the
    term was added for.
    """

    effect: Effect
    per: tuple[str, ...] = PER_ANTENNA
    values: tuple[float, ...] | None = None
    fixed: bool = False
    by: Mapping[tuple[str, ...], tuple[float, ...]] = field(default_factory=dict)
    finding: int | None = None

    def given(self, labels: tuple[str, ...]) -> tuple[float, ...]:
        """Return the values before any fit for one set of labels, zeros where there are none."""
        nothing = self.values or (0.0,) * len(self.effect.coefficients)
        return self.by.get(labels, nothing)

    @property
    def of_session(self) -> bool:
        """Tell whether every session has coefficients of its own."""
        return "session" in self.per

    @property
    def has_values(self) -> bool:
        """Tell whether the term gives anything before it is fitted."""
        return self.values is not None or bool(self.by)

    def offsets(self, at: Circumstances) -> tuple[Array, Array]:
        """Return what the term adds before any fit [rad].

        Raises
        ------
        BadInput
            It needs a column, or coefficients for a label, that are not there.
        """
        try:
            x, y = self.effect.columns(at)
        except MissingColumn as lack:
            said = f"the model's term {self.effect.id} {lack}, which is not there"
            raise BadInput(said) from None
        refuse_unknown(self.effect, at.columns)
        if not self.by:
            values = np.array(self.values)
            return x @ values, y @ values
        nobody = np.full(len(at), "")
        labels = {name: np.asarray(at.columns.get(name, nobody)) for name in self.per}
        codes, values = self._by_labels(labels)
        return (x * values[codes]).sum(axis=1), (y * values[codes]).sum(axis=1)

    def values_of(self, labels: Mapping[str, NDArray[Any]]) -> Array:
        """Return the values before any fit for one value of each label, shape (k,).

        Raises
        ------
        BadInput
            The term has none for it.
        """
        return np.array(self.values) if not self.by else self._by_labels(labels)[1][0]

    def first_unknown(self, columns: Mapping[str, NDArray[Any]]) -> tuple[int, str] | None:
        """Return the first row whose labels it has no coefficients for, and why; None for none."""
        if self.by and columns.keys() >= set(self.per):
            rows = zip(*(columns[name].astype(str).tolist() for name in self.per), strict=True)
            for row, one in enumerate(rows):
                if one not in self.by:
                    return row, self._lacks(one)
        return first_unknown(self.effect, columns)

    def _lacks(self, labels: tuple[str, ...]) -> str:
        what = " and ".join(f"{n} {v!r}" for n, v in zip(self.per, labels, strict=True))
        known = ", ".join(" ".join(each) for each in list(self.by)[:12])
        return (
            f"the model's term {self.effect.id} has no coefficients for {what}: "
            f"it has them for {known}"
        )

    def _by_labels(self, of_row: Mapping[str, NDArray[Any]]) -> tuple[NDArray[np.intp], Array]:
        """Return which values each row has by its labels, (n,), and those, (groups, k)."""
        labels = [of_row[name].astype(str) for name in self.per]
        there, which = np.unique(np.stack(labels), axis=1, return_inverse=True)
        found = []
        for one in map(tuple, there.T.tolist()):
            if one not in self.by:
                raise BadInput(self._lacks(one))
            found.append(self.by[one])
        return which.ravel(), np.array(found)


@dataclass(frozen=True)
class Model:
    """A pointing model.

    Attributes
    ----------
    name
        As the user gave it.
    terms
        What is fitted, linear in the coefficients.
    given
        Offsets (x, y) that hold before anything is fitted [rad]; None for zero.
    base
        The built-in model that `given` is of, "" without one.
    site
        Where the telescope stands, if the model tells; what is recorded elsewhere tells its own.
    completed
        What is known of a model that a fit or a diagnosis completed.
    details
        What another program's file says beside the terms: of its own fit `stars` and
        `sky_rms_arcsec`; `title`, `comments`, `number_and_date`; `phi_deg`, the elevation of the
        first axis where that is not 90.
    mount
        Whose axes it is of.
    """

    name: str
    terms: tuple[Term, ...]
    given: Callable[[Circumstances], tuple[Array, Array]] | None = field(default=None)
    base: str = ""
    site: Site | None = None
    completed: Completed | None = field(default=None, compare=False, repr=False)
    details: Mapping[str, Any] = field(default_factory=dict, compare=False, repr=False)
    mount: Mount = ALTAZ

    @property
    def leans(self) -> bool:
        """Tell whether its first axis leans while nobody has said of which mount it is."""
        return self.mount is ALTAZ and "phi_deg" in self.details

    def fitted(self, refit: Collection[str] | None = None) -> list[Term]:
        """Return the terms to fit: all that are not fixed, or those of them whose id is named.

        What is known of beforehand, as a field without a name is, is fitted where it is named.
        """
        return [
            term
            for term in self.terms
            if not term.fixed
            and (not term.effect.prior if refit is None else term.effect.id in refit)
        ]

    def needs(self) -> list[str]:
        """Return what the terms need beside a direction, as recordings spell it, labels apart."""
        found: dict[str, None] = {}
        for term in self.terms:
            if term.has_values:
                found |= dict.fromkeys(_missing(term.effect, self.site))
        return list(found)

    def on(self, mount: Mount) -> Model:
        """Return the model in the words of a mount: the classical terms are those of its axes.

        Raises
        ------
        BadInput
            It is of another mount.
        """
        if mount is ALTAZ and self.mount is ALTAZ:
            return self
        from pyport.effects.mounts import concerns, on

        for term in self.terms:
            if self.given is not None or not concerns(term.effect, mount):
                wrong = f"the model's term {term.effect.id} is none of {mount.sentence}"
                raise BadInput(f"{wrong}: expected a model such as {mount.model}")
        terms = tuple(replace(term, effect=on(term.effect, mount)) for term in self.terms)
        name = mount.model if self.name in BY_MODEL else self.name
        return replace(self, name=name, terms=terms, mount=mount)

    def added_to(self, recordings: Recordings) -> Recordings:
        """Return recordings with what the model took off while it was in use added back.

        Raises `BadInput` as `offsets` does.
        """
        x, y = self.on(recordings.at.mount).offsets(recordings.at)
        return replace(recordings, x=recordings.x + x, y=recordings.y + y)

    def offsets(self, at: Circumstances) -> tuple[Array, Array]:
        """Return the offsets that the model predicts before any fit [rad].

        Raises
        ------
        BadInput
            A term needs a column, or coefficients for a label, that are not there.
        """
        at = self._placed(at)
        x, y = np.zeros(len(at)), np.zeros(len(at))
        if self.given is not None and at.fine is None:
            x, y = self.given(at)
        elif self.given is not None and at.fine is not None:
            x, y = at.fine.mean(np.stack(self.given(at.fine.at), axis=1)).T
        for term in self.terms:
            if term.has_values:
                more_x, more_y = term.offsets(at)
                x, y = x + more_x, y + more_y
        return x, y

    def offsets_on_sky(self, at: Circumstances) -> tuple[Array, Array]:
        """Return `offsets` across and along elevation [rad], on whatever mount.

        Raises
        ------
        BadInput
            As `offsets`; or the mount's axes depend on a latitude that is not there.
        """
        at = self._placed(at)
        x, y = self.offsets(at)
        try:
            return at.along_sky(x, y)
        except MissingColumn as lack:
            said = f"the model's mount, {at.mount.sentence}, {lack}, which is not there"
            raise BadInput(said) from None

    def _placed(self, at: Circumstances) -> Circumstances:
        """Return circumstances at the model's site and on its mount, where they tell none."""
        if at.site is None and self.site is not None:
            at = replace(at, site=self.site)
        if at.mount is ALTAZ and self.mount is not ALTAZ:
            at = replace(at, mount=self.mount)
        return at


def _linear(name: str, ids: str, per: tuple[str, ...]) -> Model:
    effects = catalogue(ALTAZ)
    return Model(name, tuple(Term(effects[one], per) for one in ids.split()))


CLASSICAL_TERMS = "azimuth_zero elevation_zero collimation skew tilt sag_cosine"


def _classical(name: str) -> Model:
    return _linear(name, CLASSICAL_TERMS, PER_ANTENNA).on(BY_MODEL[name])


def _rt32(name: str, *, exact: bool) -> Model:
    """Return the RT32's model about its published parameters, each of the twelve a term."""
    from pyport.pointing import Rt32Model

    p = np.array(list(rt32_values(name).values()))
    terms = tuple(Term(rt32_parameter(number)) for number in range(1, 13))
    return Model(name, terms, Rt32Model(p, exact=exact).offsets, name)


def rt32_values(base: str) -> dict[int, float]:
    """Return the parameters 1 to 12 of a model of the RT32 [rad], none for any other name."""
    if not base.startswith("rt32"):
        return {}
    from pyport.pointing import printed, recovered

    p = recovered() if base == "rt32-3model" else printed()
    return {number: float(value) for number, value in enumerate(p, 1)}


def rt32_parameter(number: int) -> Effect:
    """Return the effect that a correction to p1..p12 stands for, with the RT32's sign."""
    from pyport.pointing import PARAMETERS, approximate_columns

    parameter = PARAMETERS[number - 1]

    def basis(at: Circumstances) -> tuple[Array, Array]:
        x, y = approximate_columns(at)
        return x[:, number - 1 : number], y[:, number - 1 : number]

    return Effect(
        parameter.effect,
        f"parameter {number} of the RT32's model: {parameter.name}",
        "Borkowski, RT32 Pointing Model (2004), eq. 18 and 19",
        (Coefficient(f"p{number}"),),
        basis,
        member={"rt32": number},
    )


BUILT_IN: dict[str, Callable[[], Model]] = {
    **{name: partial(_classical, name) for name in BY_MODEL},
    "gmrt-paper": lambda: _linear("gmrt-paper", "elevation_zero hour_angle_wave", PER_ANTENNA_DAY),
    "none": lambda: Model("none", ()),
    "rt32-3model": lambda: _rt32("rt32-3model", exact=True),
    "rt32-exact": lambda: _rt32("rt32-exact", exact=True),
    "rt32-approximate": lambda: _rt32("rt32-approximate", exact=False),
}


def _missing(effect: Effect, site: Site | None) -> list[str]:
    """Return all that an effect lacks where only a direction is known."""
    found: list[str] = []
    columns: dict[str, NDArray[Any]] = {}
    while len(found) <= MOST_NEEDS:
        at = Circumstances(np.array([1.0]), np.array([math.pi / 4]), site, columns)
        try:
            effect.columns(at)
        except MissingColumn as lack:
            found.append(lack.column)
            inside = INSIDE.get(lack.column, lack.column)
            if inside in columns or not inside.isidentifier() or inside == "latitude_deg":
                break  # a site, or one of several: nothing more can be said
            columns[inside] = np.array([""] if inside in LABELS else [1.0])
        else:
            break
    return found
