"""Complete a model: from what was solved for each term to a model that holds it all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport import __version__, angles
from pyport.angles import ARCSEC, Array
from pyport.effects.circumstances import utc
from pyport.effects.empirical.drivers import unit_in_words
from pyport.effects.empirical.fields import UNKNOWN
from pyport.errors import BadInput
from pyport.files import sha256
from pyport.models.conditions import Completed, Value
from pyport.models.members import frozen
from pyport.models.model import Model, Term, rt32_values
from pyport.recordings.schema import Recordings, Stack

Labels = tuple[str, ...]
#: What a file says beside its terms that a fitted model is written with again.
KEPT = ("comments", "number_and_date")


@dataclass(frozen=True)
class Solved:
    """What was solved for one term and one set of its labels."""

    #: `term`, `labels`: which; a term that a finding added has its number in `finding`.
    term: Term
    labels: Labels
    change: Array  #: what is added to the values that the term has, in internal units, shape (k,)
    sigma: Array  #: one-sigma errors, shape (k,)
    #: Where its coefficients stand in the covariance, shape (k,); -1 for what was not fitted.
    places: Sequence[int]
    known: Sequence[bool]  #: whether the recordings determine each, shape (k,)


@dataclass(frozen=True)
class Left:
    """What a fit leaves of m measured offsets [rad], and which of them count, shape (m,) each."""

    residual: Array
    counted: NDArray[np.bool_]
    stack: Stack

    def sizes(self) -> dict[str, Any]:
        """Return the rms of each axis, and stars and sky rms as TPOINT counts them [arcsec]."""
        found: dict[str, Any] = {}
        for name, axis in (("xel", ~self.stack.is_y), ("el", self.stack.is_y)):
            own = self.residual[axis & self.counted]
            if len(own):
                found[f"rms_{name}_arcsec"] = float(np.sqrt(np.mean(own**2))) / ARCSEC
        stars = len(np.unique(self.stack.row[self.counted]))
        whole = float((self.residual[self.counted] ** 2).sum())
        found["stars"] = stars
        found["sky_rms_arcsec"] = float(np.sqrt(whole / max(stars, 1))) / ARCSEC
        return found


def complete(
    model: Model,
    recordings: Recordings,
    solved: Sequence[Solved],
    covariance: Array,
    *,
    by: str,
    left: Left,
    findings: Sequence[Mapping[str, Any]] = (),
) -> Model:
    """Return a model with what was solved for in its terms.

    `model`: as it was given.
    `recordings`: what it was fitted to.
    `solved`: the model's fitted terms, one for each set of labels, then those of findings.
    `covariance`: of everything that was fitted, in internal units, shape (P, P).
    `by`: what made it: fit or diagnose.
    `left`: what is left of the measured offsets.
    `findings`: as `report.json` spells them.
    """
    terms: list[Term] = []
    values: list[Value] = []
    places: list[int] = []
    scales: list[float] = []
    unsaved: list[str] = []
    about = rt32_values(model.base)
    fitted = {id(one.term) for one in solved}
    held = [term for term in model.terms if id(term) not in fitted]
    for first in {id(term): term for term in [*(one.term for one in solved), *held]}.values():
        own = [one for one in solved if one.term is first] or _held(first)
        try:
            effect = frozen(first.effect, recordings.at)
        except BadInput:
            effect = first.effect
            unsaved.append(effect.id)
        after: dict[Labels, tuple[float, ...]] = {}
        for one in own:
            before = np.array(first.given(one.labels))
            after[one.labels] = tuple((before + one.change).tolist())
            for n, coefficient in enumerate(effect.coefficients):
                zero = about.get(effect.member.get("rt32", 0), 0.0)
                scale, place = coefficient.scale, one.places[n]
                labels = zip(first.per, one.labels, strict=False)
                values.append(
                    Value(
                        name=coefficient.name,
                        effect=effect.id,
                        unit=coefficient.unit,
                        value=(after[one.labels][n] + zero) / scale,
                        sigma=float(one.sigma[n]) / abs(scale) if place >= 0 else None,
                        before=(float(before[n]) + zero) / scale,
                        labels={key: text for key, text in labels if text},
                        finding=first.finding,
                        determined=bool(one.known[n]),
                    )
                )
                places.append(place)
                scales.append(scale)
        terms.append(_with(replace(first, effect=effect), after))
    return replace(
        model,
        terms=tuple(terms),
        site=recordings.at.site or model.site,
        completed=Completed(
            made=_made(model, recordings, by) | left.sizes(),
            values=tuple(values),
            covariance=_picked(covariance, places, scales),
            findings=tuple(findings),
            unsaved=tuple(unsaved),
            offsets=len(left.stack),
        ),
    )


def _held(term: Term) -> list[Solved]:
    """Return a term that was not fitted, with the values that it has."""
    k = len(term.effect.coefficients)
    return [
        Solved(term, labels, np.zeros(k), np.zeros(k), [-1] * k, [True] * k)
        for labels in (term.by or {(): ()})
    ]


def _with(term: Term, after: Mapping[Labels, tuple[float, ...]]) -> Term:
    """Return a term with its new values: one set of them holds for every label."""
    if len(after) == 1:
        return replace(term, values=next(iter(after.values())), by={})
    return replace(term, values=None, by=dict(after))


def _picked(covariance: Array, places: Sequence[int], scales: Sequence[float]) -> Array:
    """Return the covariance of some values in their units, zero for what was not fitted."""
    which = np.array(places, int)
    there = which >= 0
    out = np.zeros((len(which), len(which)))
    rows = np.flatnonzero(there)
    out[np.ix_(rows, rows)] = covariance[np.ix_(which[rows], which[rows])]
    unit = np.array(scales)
    return out / np.outer(unit, unit)


def _made(model: Model, recordings: Recordings, by: str) -> dict[str, Any]:
    file = recordings.file
    return {
        "by": f"pyport {__version__} {by}",
        "recordings": file.name,
        "sha256": sha256(file) if file.is_file() else None,
        "rows": len(recordings),
        "model": model.name,
        "telescope": recordings.meta.get("telescope"),
        **{key: model.details[key] for key in ("title", *KEPT) if key in model.details},
    }


#: How every table calls a coefficient's value, what the file has, and their difference.
ENTER, IN_FILE, CHANGE = (
    "enter this into the control system",
    "in the file",
    "change against the file",
)
GRID = "pyport convert writes it for another program as waves, or with --rest-as grid.csv as a grid"
TIMED = "it follows time: pyport apply takes it off where times are recorded"
PAST = "its phase wanders, and what it will do is not known: there is nothing to enter"
OVER = "it came back: there is nothing to enter"
#: Endings of names of what a coefficient is counted from.
COUNTED = frozenset({"c", "s", "centre", "rad", "h"})
#: More coefficients than this are those of many antennas or sessions: a file holds them.
MOST_LINES = 40


def lines(completed: Completed, terms: Sequence[Term] = ()) -> list[str]:
    """Return the table of a completed model for the terminal, empty for an undetermined one.

    What a coefficient is counted from (a mean temperature, a moment) stands below, as far as
    `terms` tell; a field without a name has numbers that no control system takes, what was free in
    every stretch of time and what stepped back have none that hold after it, and what the
    recordings leave open has one of many.
    """
    if completed.undetermined:
        return []
    fields = {one.finding for one in completed.values if one.effect == UNKNOWN}
    timed = {one.finding for one in terms if "time_utc" in one.effect.needs} & fields
    past = {one.finding: PAST for one in terms if one.effect.is_over}
    past |= {one.finding: OVER for one in terms if one.effect.came_back}
    past.pop(None, None)
    values = [one for one in completed.values if one.effect != UNKNOWN and one.finding not in past]
    open_ = [label(one) for one in values if not one.determined]
    values = [one for one in values if one.determined]
    names = ", ".join(open_) if len(open_) <= MOST_LINES else f"{len(open_)} coefficients"
    lines = [f"nothing to enter, not determined by these recordings: {names}"] * bool(open_)
    lines += [
        f"finding {n}: a field without a name; {TIMED if n in timed else GRID}"
        for n in sorted(fields, key=str)
    ]
    lines += [f"finding {n}: {past[n]}" for n in sorted(past, key=str)]
    counted = [term for term in terms if _counted(term) and term.finding not in past]
    lines += [f"{term.effect.id}: {_counted(term)}" for term in counted]
    if not values:
        return lines
    return _table(values) + lines


def _table(values: Sequence[Value]) -> list[str]:
    if len(values) > MOST_LINES:
        return [
            f"{len(values)} coefficients to {ENTER.removesuffix(' this')}: see completed_model."
        ]
    head = [ENTER, *([IN_FILE, CHANGE] if has_before(values) else [])]
    wide = max(len(label(one)) for one in values)
    found = [f"{'':{wide}s}  {'   '.join(head)}"]
    return found + [_line(one, wide, [len(one) for one in head]) for one in values]


def _counted(term: Term) -> str:
    if {"word", "rt32"} & set(term.effect.member) or term.effect.id == UNKNOWN:
        return ""
    numbers = {
        name: value
        for name, value in term.effect.member.items()
        if name.rpartition("_")[2] in COUNTED and isinstance(value, int | float)
    }
    since = numbers.pop("since_s", 0.0)
    said = [f"{name} = {value:.10g}" for name, value in numbers.items()]
    said += [f"since {utc(since)}"] * bool(since)
    return ", ".join(said)


def has_before(values: Sequence[Value]) -> bool:
    """Tell whether the model that was given had values of its own."""
    return any(one.before for one in values)


def label(one: Value) -> str:
    """Return the name of a coefficient with the labels that it holds for."""
    return one.name + (f"[{' '.join(one.labels.values())}]" if one.labels else "")


def _line(one: Value, wide: int, widths: Sequence[int]) -> str:
    digits = decimals(one)
    numbers = [f"{one.value:.{digits}f}", f"{one.before:.{digits}f}", f"{one.change:+.{digits}f}"]
    cells = [f"{text:>{width}s}" for text, width in zip(numbers, widths, strict=False)]
    known = "held" if one.sigma is None else f"+- {one.sigma:.{digits}f}"
    found = "" if one.finding is None else f"  finding {one.finding}"
    size = f"{'   '.join(cells)} {known} {unit_in_words(one.unit)}"
    return f"{label(one):{wide}s}  {size}{found}".rstrip()


def decimals(one: Value) -> int:
    """Return so many decimals that the error has two digits, as the page has.

    What was held is known to its last digit, and has six.
    """
    size, digits = (one.sigma, 2) if one.sigma else (abs(one.value), 6)
    return angles.decimals(size, 9, digits)
