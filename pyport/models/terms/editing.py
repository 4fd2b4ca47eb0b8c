"""Models changed by the names of terms: TPOINT's, the Field System's, effects, coefficients.

x is the offset across the sky and y the one in elevation, encoder minus true; A and E are azimuth
from north through east and elevation, Z is zenith distance. A product has sines and cosines of
multiples of them, and powers of E and Z in radians.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from pyport.angles import RADIANS_PER
from pyport.columns import LABELS
from pyport.effects import Effect, catalogue, known
from pyport.errors import BadInput
from pyport.models.members import apart
from pyport.models.model import Model, Term
from pyport.models.terms import field_system, tpoint
from pyport.models.terms.shapes import Shape, Wave, product, ratio, seen
from pyport.models.terms.tpoint import upward
from pyport.models.terms.words import Word
from pyport.mounts import KINDS

_PART = re.compile(r"([xy])\s*=\s*([-+]?)\s*(.+)")
_FACTOR = re.compile(
    r"(sin|cos)\s*([1-9]?)\s*([AEZ])(?![A-Za-z^])|([EZ])(?:\^([1-9]))?(?![A-Za-z])"
)
_SEPARATED = re.compile(r"\s*\*?\s*")
_AXIS = {"x": "xel", "y": "el"}
_ZEROS = {"x": Shape("collimation"), "y": Shape("elevation_zero")}


def formula_word(name: str, formula: str) -> Word:
    """Return the word that a formula makes of a name, its coefficient in arcseconds.

    Raises `BadInput`: it is no such formula.
    """
    parts = [_part(name, text.strip()) for text in formula.split(",")]
    return Word(name, tuple(parts), "arcsec")


def _part(name: str, text: str) -> tuple[Shape, float]:
    match = _PART.fullmatch(text)
    if match is None:
        raise _wrong(name, text)
    axis, minus, rest = match.groups()
    sign = -1.0 if minus == "-" else 1.0
    if rest == "1":
        return _ZEROS[axis], sign
    waves: list[Wave] = []
    place = 0
    while place < len(rest):
        factor = _FACTOR.match(rest, place)
        if factor is None:
            raise _wrong(name, text)
        wave, turn = upward(_wave(factor))
        waves.append(wave)
        sign *= turn
        separated = _SEPARATED.match(rest, factor.end())
        place = factor.end() if separated is None else separated.end()
    return _shape(_AXIS[axis], waves), sign


def _wave(factor: re.Match[str]) -> Wave:
    function, k, angle, power_of, power = factor.groups()
    if function is None:
        return Wave("P", power_of, int(power or 1))
    return Wave(function[0].upper(), angle, int(k or 1))


def _shape(axis: str, waves: list[Wave]) -> Shape:
    """Return the shape of a product; across the sky, cos E and more are an azimuth's."""
    level = Wave("C", "E")
    if axis == "xel" and len(waves) > 1 and level in waves:
        waves.remove(level)
        return product("az", *waves)
    return product(axis, *waves)


def _wrong(name: str, text: str) -> BadInput:
    wanted = "expected such as 'x = sin 3A sin E' or 'y = -cos 2A', commas between them"
    return BadInput(f"{name[:20]} is {text[:60]!r}, {wanted}")


_VALUE = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)")


def edited(
    model: Model,
    *,
    fix: Sequence[str] = (),
    add: Sequence[str] = (),
    drop: Sequence[str] = (),
    per: Sequence[str] | None = None,
) -> Model:
    """Return a model with terms dropped, added and fixed, in this order.

    `model`: what to start from.
    `fix`: NAME=VALUE with the name's own unit (arcsec; deg for P1..P30) or one of its own behind
      the number; NAME alone holds what the model gives.
    `add`, `drop`: names: TPOINT's, P1..P30, an effect's id or one of its coefficients; to add also
      a user's term, `NAME: x = sin 3A sin E`.
    `per`: labels each value of which has coefficients of its own; None leaves that to the model.
    Raises `BadInput`: a name is none, or is (or is not) in the model already.
    """
    if not (fix or add or drop):
        return _split(model, per)
    terms = [one for term in model.terms for one in _apart(term)]
    for name in drop:
        found = _places(terms, name)
        if not found:
            raise BadInput(f"--drop {name}: the model has no such term, it has {_known(terms)}")
        terms = [term for n, term in enumerate(terms) if n not in found]
    for name in add:
        for term in named(name):
            twin = _twin(terms, term.effect)
            if twin is not None:
                has = terms[twin].effect.coefficients[0].name
                raise BadInput(f"--add {name}: the model has it already, as {has}")
            terms.append(term)
    for assignment in fix:
        name, equals, value = assignment.partition("=")
        _fix(terms, name.strip(), value.strip() if equals else None)
    return _split(replace(model, terms=tuple(terms), completed=None), per)


def _split(model: Model, per: Sequence[str] | None) -> Model:
    """Return a model whose fitted terms have coefficients for each value of some labels.

    Raises `BadInput`: a name is no label.
    """
    if per is None:
        return model
    for name in per:
        if name not in LABELS:
            raise BadInput(f"--per {name}: expected labels among {', '.join(sorted(LABELS))}")
    terms = [one if one.fixed or one.by else replace(one, per=tuple(per)) for one in model.terms]
    return replace(model, terms=tuple(terms))


def _fix(terms: list[Term], name: str, value: str | None) -> None:
    """Hold a term at a value, or at the model's own; one that the model lacks comes in."""
    if value is None:
        places = _places(terms, name)
        if not places:
            raise BadInput(f"--fix {name}: the model has no such term, it has {_known(terms)}")
        for place in places:
            held = terms[place]
            terms[place] = replace(held, values=held.values or (0.0,), fixed=True)
        return
    wanted = named(name)
    if len(wanted) > 1:
        names = ", ".join(term.effect.coefficients[0].name for term in wanted)
        raise BadInput(f"--fix {name}: it has several coefficients, fix {names} one by one")
    (term,) = wanted
    twin = _twin(terms, term.effect)
    per = term.per if twin is None else terms[twin].per
    held = replace(term, per=per, values=(_internal(term.effect, name, value),), fixed=True)
    if twin is None:
        terms.append(held)
    else:
        terms[twin] = held


def _internal(effect: Effect, name: str, text: str) -> float:
    """Return a value in internal units: in the coefficient's unit, or in one that it names."""
    match = _VALUE.fullmatch(text)
    unit = match[2] if match else ""
    if match is None or (unit and unit not in RADIANS_PER):
        wanted = f"a number, with one of {', '.join(RADIANS_PER)} behind it or nothing"
        raise BadInput(f"--fix {name}: the value is {text[:40]!r}, expected {wanted}")
    scale = RADIANS_PER[unit] if unit else effect.coefficients[0].scale
    return float(match[1]) * scale


def named(name: str) -> list[Term]:
    """Return the terms, of one coefficient each, that a name stands for.

    Raises `BadInput`: no vocabulary has this name.
    """
    own, colon, meant = name.partition(":")
    if colon:
        return [Term(formula_word(own.strip(), meant.strip()).effect())]
    word = word_of(name)
    if word is not None:
        return [Term(word.effect())]
    if (effect := known(name)) is not None:
        if not effect.coefficients:
            raise BadInput(f"{name} has coefficients of which only recordings tell the number")
        return _apart(Term(effect))
    for effect in (one for mount in KINDS.values() for one in catalogue(mount).values()):
        names = [coefficient.name for coefficient in effect.coefficients]
        if name in names:
            return [_apart(Term(effect))[names.index(name)]]
    known_are = "TPOINT's, P1..P30, `pyport dev effects`, or your own as 'NAME: x = sin 3A sin E'"
    raise BadInput(f"no term is called {name[:40]!r}: {known_are}")


def word_of(name: str) -> Word | None:
    """Return TPOINT's or the Field System's word, None for any other name.

    Raises `BadInput`: the Field System reserves the name and does nothing with it.
    """
    word = field_system.word(name) or tpoint.word(name) or tpoint.polar_word(name)
    if word is not None and not word.parts:
        raise BadInput(f"{name} does nothing on an alt-azimuth mount")
    return word


def _apart(term: Term) -> list[Term]:
    return [
        replace(
            term,
            effect=effect,
            values=None if term.values is None else (term.values[n],),
            by={labels: (values[n],) for labels, values in term.by.items()},
        )
        for n, effect in enumerate(apart(term.effect))
    ]


def _places(terms: Sequence[Term], name: str) -> list[int]:
    """Return where a model has what a name stands for: by its own name, its effect or its shape."""
    own = [
        n
        for n, term in enumerate(terms)
        if name in {term.effect.id, *(one.name for one in term.effect.coefficients)}
    ]
    if own:
        return own
    twins = [_twin(terms, term.effect) for term in named(name)]
    return [place for place in twins if place is not None]


def _twin(terms: Sequence[Term], effect: Effect) -> int | None:
    """Return where a model has a term that no recording can tell from an effect."""
    shape = seen(effect)
    for n, term in enumerate(terms):
        other = seen(term.effect)
        if ratio(shape, other):
            return n
        hidden = shape is None and other is None
        if hidden and (term.effect.id, term.effect.coefficients) == (
            effect.id,
            effect.coefficients,
        ):
            return n
    return None


def _known(terms: Sequence[Term]) -> str:
    return ", ".join(term.effect.coefficients[0].name for term in terms) or "none"
