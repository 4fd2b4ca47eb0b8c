"""A model of pyport into another program's file, and what that cannot hold beside it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from pyport.columns import LABELS
from pyport.effects import Effect
from pyport.effects.empirical.fields import UNKNOWN
from pyport.errors import BadInput
from pyport.formats import models
from pyport.formats.model_file import (
    KEPT,
    MOUNT_OF,
    UPRIGHT_DEG,
    WORDS,
    Entry,
    ModelFile,
    names_of,
    rounded,
    translated,
)
from pyport.formats.rest import Rest, Waves, is_known, rest_of, sky, sky_under, sums, waves
from pyport.models import toml
from pyport.models.labels import split_of
from pyport.models.model import Model, Term
from pyport.models.terms.shapes import shape_of
from pyport.models.terms.words import SCALES
from pyport.mounts import ALTAZ

#: Decimals that a value is written with, by its unit: 0.4 microarcsec in degrees.
_DECIMALS = {"arcsec": 4, "deg": 10, "": 9}
_SIGMA_DECIMALS = {"arcsec": 5, "deg": 10, "": 9}
#: How what has no name is called.
_FIELD = "the field "


def write_model(
    model: Model,
    path: Path,
    *,
    to: str = "",
    rest_as: Path | None = None,
    leave_out: bool = False,
    conditions: Mapping[str, Any] | None = None,
) -> tuple[str, int, Rest]:
    """Write a model by suffix: as pyport has it, or in the vocabulary of another program.

    `model`: with values in its terms.
    `path`: the file.
    `to`: the format, where the suffix does not tell.
    `rest_as`: a CSV file for the corrections by terms that the format has no name for.
    `leave_out`: leave those terms out.
    `conditions`: what the file, or `rest_as`, holds for beside directions, by name: `receiver`,
      `temperature_c`, `time_utc`, ...
    Returns `format`, `number`, `rest`: what was written, how many terms, and what was not.
    Raises `BadInput`: the suffix is none of a model, coefficients differ between antennas or are
      not determined, or a term has no name in that format.
    """
    chosen = models.FORMATS.get(to) if to else models.BY_SUFFIX.get(path.suffix.lower())
    if chosen is None or chosen.write is None:
        raise BadInput(f"suffix is none of a model, expected {', '.join(models.BY_SUFFIX)}", path)
    if chosen.name == "toml":
        if model.completed is None:
            raise BadInput("a model that nothing was fitted to is a file already", path)
        toml.write(model, path)
        return chosen.name, len(model.completed.values), Rest()
    conditions = conditions or {}
    model = _of_labels(model, conditions, path)
    values = _values(model, path)
    if not values and model.given is None:
        raise BadInput(f"the model {model.name} has no values to write: fit it first", path)
    vocabulary = _vocabulary(chosen, model, path)
    each = [_in_vocabulary(one, vocabulary) for one in values]
    found = [entry for entries in each for entry in entries]
    nameless = [one for one, entries in zip(values, each, strict=True) if not entries]
    instead, nameless = _sums(model, nameless, vocabulary, conditions)
    whole = rest_as is None and not leave_out
    about = _waves(model, nameless, vocabulary) if nameless and whole else None
    if about is not None:
        instead, nameless = Waves((*instead.values, *about.values), about.missed_arcsec), []
    found += _entries(instead, vocabulary)
    lost = list(dict.fromkeys(one.called for one in nameless))
    if model.given is not None:
        lost.insert(0, f"the RT32's exact form ({model.base})")
    if lost and whole:
        ways = "keep a .toml and convert it with --rest-as grid.csv (their corrections on a grid)"
        wrong = f"{vocabulary} has no name for {', '.join(lost)}"
        raise BadInput(f"{wrong}: {ways} or --leave-out", path)
    made = dict(model.completed.made) if model.completed else dict(model.details)
    title = str(made.get("title") or made.get("telescope") or model.name)
    field_system = chosen.vocabulary == "field-system"
    details = {key: made[key] for key in KEPT if key in made and field_system}
    phi = _phi_deg(model, path) if field_system else UPRIGHT_DEG
    file = ModelFile(vocabulary, tuple(_summed(found)), title, phi, details)
    if chosen.vocabulary == "tpoint":
        file = replace(file, details={"statistics": _statistics(model)})
    rest = replace(rest_of(model, file, lost, rest_as, conditions), waves=instead)
    chosen.write(file, path)
    return chosen.name, len(file.entries), rest


def _vocabulary(chosen: models.ModelFormat, model: Model, path: Path) -> str:
    if model.mount is ALTAZ:
        return chosen.vocabulary
    # TPOINT tells by its readings that a mount has turned over; the Field System knows no such one
    if chosen.any_mount and (chosen.vocabulary == "tpoint" or not model.mount.turns_over):
        for name, mount in MOUNT_OF.items():
            if mount == model.mount.model and name.startswith(chosen.vocabulary):
                return name
    raise BadInput(f"{chosen.name} has no terms for {model.mount.sentence}: keep a .toml", path)


def _phi_deg(model: Model, path: Path) -> Decimal:
    """Return the elevation of a mount's first axis.

    Raises `BadInput`: it depends on the latitude, which the model does not tell.
    """
    if model.mount.needs_latitude and model.site is None:
        raise BadInput("no latitude, and the first axis of this mount leans by it", path)
    latitude = 0.0 if model.site is None else model.site.latitude
    return rounded(Decimal(repr(float(np.degrees(model.mount.leans(latitude))))), 4)


@dataclass(frozen=True)
class _Value:
    """A coefficient of a model in internal units: sigma None where it was fixed or is not known."""

    name: str
    term: Term
    column: int
    value: float
    sigma: float | None
    fixed: bool

    @property
    def effect(self) -> Effect:
        """Return the effect that it belongs to."""
        return self.term.effect

    @property
    def called(self) -> str:
        """Return the name for a reader: a field without a name has one for all its numbers."""
        variant = self.effect.variant
        if self.effect.id == UNKNOWN:
            return f"{_FIELD}{variant}"
        return f"{self.name} ({variant})" if variant else self.name

    def entry(self, name: str, unit: str, times: float = 1.0) -> Entry:
        """Return it under a name that stands for `times` of it."""
        scale = SCALES[unit] * times
        sigma = None
        if self.sigma is not None:
            sigma = rounded(Decimal(repr(self.sigma / abs(scale))), _SIGMA_DECIMALS[unit])
        return Entry(name, _digits(self.value / times, unit), unit, sigma, fixed=self.fixed)


def _digits(value: float, unit: str) -> Decimal:
    return rounded(Decimal(repr(value / SCALES[unit])), _DECIMALS[unit])


def _of_labels(model: Model, conditions: Mapping[str, Any], path: Path) -> Model:
    """Return a model with the coefficients of the labels among some conditions alone.

    Raises `BadInput`: a term has none for them.
    """
    asked = {name: str(conditions[name]) for name in LABELS if name in conditions}

    def holds(of: Iterable[tuple[str, str]]) -> bool:
        return all(asked.get(name, label) == label for name, label in of)

    terms = []
    for term in model.terms:
        split, those = split_of(term.effect)
        for names, known in ((term.per, [*term.by]), ((split,), [(one,) for one in those])):
            if known and not any(holds(zip(names, each, strict=True)) for each in known):
                wrong = " and ".join(f"{name} {asked[name]!r}" for name in names if name in asked)
                wanted = ", ".join(map(" ".join, known))
                said = f"{term.effect.id} has no coefficients for {wrong}"
                raise BadInput(f"{said}, expected one of {wanted}", path)
        by = {each: of for each, of in term.by.items() if holds(zip(term.per, each, strict=True))}
        terms.append(replace(term, by=by))
    completed = model.completed
    if completed is not None:
        values = tuple(one for one in completed.values if holds(one.labels.items()))
        completed = replace(completed, values=values)
    return replace(model, terms=tuple(terms), completed=completed)


def _values(model: Model, path: Path) -> list[_Value]:
    known = iter(() if model.completed is None else model.completed.values)
    found = []
    for term in model.terms:
        if len(term.by) > 1:
            each = " and ".join(term.per) or "label"
            wrong = f"{term.effect.id} has coefficients for each {each}: a model file holds one set"
            raise BadInput(wrong, path)
        values = term.given(next(iter(term.by), ()))
        for n, (coefficient, value) in enumerate(
            zip(term.effect.coefficients, values, strict=True)
        ):
            row = next(known, None)
            if row is not None and not row.determined:
                raise BadInput(f"{coefficient.name} is not determined: drop or fix it", path)
            sigma = None if row is None or row.sigma is None else row.sigma * abs(coefficient.scale)
            if term.has_values or term.fixed:
                held = term.fixed or (row is not None and row.sigma is None)
                found.append(_Value(coefficient.name, term, n, value, sigma, held))
    return found


def _in_vocabulary(one: _Value, vocabulary: str) -> list[Entry]:
    """Return a coefficient under the name, or names, that a vocabulary has for it, if any."""
    for own, words in WORDS.items():
        word = words(one.name)
        if word is not None and own == "field-system" and vocabulary.startswith(f"{own}-"):
            return [one.entry(one.name, word.unit)]
        same_unit = one.effect.coefficients[one.column].unit == (word.unit if word else None)
        if word is not None and word.parts and same_unit:
            file = ModelFile(own, (one.entry(one.name, word.unit),))
            try:
                return list(translated(file, vocabulary).entries)
            except BadInput:
                return []
    found = shape_of(one.effect, one.column)
    names = [] if found is None else names_of(found[0], vocabulary)
    named = [(WORDS[vocabulary](name), sign) for name, sign in names]
    return [
        one.entry(word.name, word.unit, sign / found[1])
        for word, sign in named
        if found is not None and word is not None
    ]


def _summed(entries: Sequence[Entry]) -> list[Entry]:
    """Return entries with those of one name as one: their values add up."""
    found: dict[str, Entry] = {}
    for one in entries:
        old = found.get(one.name)
        if old is None:
            found[one.name] = one
        else:
            both = [each.sigma for each in (old, one) if each.sigma is not None]
            sigma = sum((each**2 for each in both), Decimal(0)).sqrt() if both else None
            fixed = old.fixed and one.fixed
            found[one.name] = replace(old, value=old.value + one.value, sigma=sigma, fixed=fixed)
    return list(found.values())


def _sums(
    model: Model, nameless: Sequence[_Value], vocabulary: str, conditions: Mapping[str, Any]
) -> tuple[Waves, list[_Value]]:
    """Return the names that hold some coefficients exactly, and the coefficients that none hold.

    All that do not depend on what is open are tried together, then term by term.
    """
    each: dict[int, list[_Value]] = {}
    for one in nameless:
        if one.effect.id != UNKNOWN:
            each.setdefault(id(one.term), []).append(one)
    if not each or model.mount is not ALTAZ:
        return Waves(), list(nameless)
    at = sky_under(model, conditions)[1]
    terms = {place: _of_columns(some) for place, some in each.items()}
    known = {place: term for place, term in terms.items() if is_known(term, at)}
    exact = sums([*known.values()], vocabulary, at)
    if exact is None:
        known = {n: one for n, one in known.items() if sums([one], vocabulary, at) is not None}
        exact = sums([*known.values()], vocabulary, at)
    if exact is None:
        return Waves(), list(nameless)
    return exact, [one for one in nameless if id(one.term) not in known]


def _of_columns(some: Sequence[_Value]) -> Term:
    """Return the term that some coefficients are of, with those alone."""
    term, sizes = some[0].term, {one.column: one.value for one in some}
    values = tuple(sizes.get(n, 0.0) for n in range(len(term.effect.coefficients)))
    return replace(term, values=values, by={})


def _waves(model: Model, lost: Sequence[_Value], vocabulary: str) -> Waves | None:
    """Return waves that hold nearly what is lost, which are fields; None where there are none."""
    if model.mount is not ALTAZ or model.given is not None:
        return None
    fields = list({id(one.term): one.term for one in lost}.values())
    if any(one.effect.id != UNKNOWN for one in fields):
        return None
    made = {} if model.completed is None else model.completed.made
    return waves(fields, vocabulary, made.get("sky_rms_arcsec", 0.0), sky()[1])


def _entries(instead: Waves, vocabulary: str) -> list[Entry]:
    """Return waves as terms of a file, held as the fields are."""
    words = ((WORDS[vocabulary](name), value) for name, value in instead.values)
    return [
        Entry(word.name, _digits(value, word.unit), word.unit, fixed=True)
        for word, value in words
        if word is not None
    ]


def _statistics(model: Model) -> dict[str, Decimal]:
    """Return TPOINT's line: stars, and the rms on the sky."""
    made = {} if model.completed is None else model.completed.made
    return {
        "stars": Decimal(int(made.get("stars", 0))),
        "sky_rms_arcsec": rounded(Decimal(repr(float(made.get("sky_rms_arcsec", 0.0)))), 4),
    }
