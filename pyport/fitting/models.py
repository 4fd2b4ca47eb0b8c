"""Pointing models: lists of effects, each with its own coefficients for all rows or per label."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import RADIANS_PER, Array
from pyport.effects import CATALOGUE, Circumstances, Coefficient, Effect
from pyport.errors import BadInput
from pyport.files import is_file
from pyport.recordings.formats.csv import read_text

#: Labels that split the coefficients of a classical model: each antenna has its own mount.
PER_ANTENNA = ("antenna",)
PER_ANTENNA_DAY = ("antenna", "session")


@dataclass(frozen=True)
class Term:
    """An effect in a model, with one set of coefficients for every value of the labels `per`.

    `values` hold before anything is fitted; a fixed term keeps them.
    """

    effect: Effect
    per: tuple[str, ...] = PER_ANTENNA
    values: tuple[float, ...] | None = None
    fixed: bool = False


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
    """

    name: str
    terms: tuple[Term, ...]
    given: Callable[[Circumstances], tuple[Array, Array]] | None = field(default=None)

    def fitted(self, refit: Collection[str] | None = None) -> list[Term]:
        """Return the terms to fit: all that are not fixed, or those of them whose id is named."""
        return [
            term
            for term in self.terms
            if not term.fixed and (refit is None or term.effect.id in refit)
        ]

    def offsets(self, at: Circumstances) -> tuple[Array, Array]:
        """Return the offsets that the model predicts before any fit [rad]."""
        x, y = np.zeros(len(at)), np.zeros(len(at))
        if self.given is not None and at.fine is None:
            x, y = self.given(at)
        elif self.given is not None and at.fine is not None:
            x, y = at.fine.mean(np.stack(self.given(at.fine.at), axis=1)).T
        for term in self.terms:
            if term.values is not None:
                columns_x, columns_y = term.effect.columns(at)
                x, y = x + columns_x @ np.array(term.values), y + columns_y @ np.array(term.values)
        return x, y


def _linear(name: str, ids: str, per: tuple[str, ...]) -> Model:
    return Model(name, tuple(Term(CATALOGUE[one], per) for one in ids.split()))


ALTAZ = "azimuth_zero elevation_zero collimation skew tilt sag_cosine"


def _rt32(name: str, *, exact: bool) -> Model:
    """Return the RT32's model about its published parameters, each of the twelve a term."""
    from pyport.pointing import Rt32Model, printed, recovered

    p = recovered() if name == "rt32-3model" else printed()
    terms = tuple(Term(_rt32_parameter(number)) for number in range(1, 13))
    return Model(name, terms, Rt32Model(p, exact=exact).offsets)


def _rt32_parameter(number: int) -> Effect:
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
    )


BUILT_IN: dict[str, Callable[[], Model]] = {
    "altaz": lambda: _linear("altaz", ALTAZ, PER_ANTENNA),
    "gmrt-paper": lambda: _linear("gmrt-paper", "elevation_zero hour_angle_wave", PER_ANTENNA_DAY),
    "none": lambda: Model("none", ()),
    "rt32-3model": lambda: _rt32("rt32-3model", exact=True),
    "rt32-exact": lambda: _rt32("rt32-exact", exact=True),
    "rt32-approximate": lambda: _rt32("rt32-approximate", exact=False),
}


def load(name: str) -> Model:
    """Return a built-in model, or read one from a file.

    TOML here; TPOINT's .mod, the Field System's .ctl and .err, katpoint's descriptions, SKA-Mid's
    .json and DISCOS's .xml by `pyport.formats`.

    Raises
    ------
    BadInput
        There is no such model or file, or the file does not describe a model.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]()
    from pyport.formats import models

    if (foreign := models.load(name)) is not None:
        return foreign
    path = Path(name)
    if not is_file(path):
        known = ", ".join(sorted(BUILT_IN))
        raise BadInput(f"no model and no file is called {name!r}; built in are {known}")
    return _from_toml(path)


def _from_toml(path: Path) -> Model:
    """Read `[[term]]` tables: an effect, `per`, and value_UNIT for its coefficients."""
    try:
        text = tomllib.loads(read_text(path))
    except BadInput:
        raise
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not a TOML file: {error}", path) from None
    rows = text.get("term")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise BadInput("no [[term]] table: a model lists its effects, one table each", path)
    return Model(str(text.get("name", path.stem)), tuple(_term(row, path) for row in rows))


def _term(row: dict[str, Any], path: Path) -> Term:
    effect = CATALOGUE.get(str(row.get("effect")))
    if effect is None:
        raise BadInput(f"no effect is called {row.get('effect')!r}", path)
    per = row.get("per", PER_ANTENNA)
    if not isinstance(per, list | tuple) or not all(isinstance(one, str) for one in per):
        raise BadInput(f"{effect.id} has per = {per!r}, expected a list of labels", path)
    given = {key: value for key, value in row.items() if key.startswith("value")}
    if len(given) > 1:
        raise BadInput(f"{effect.id} has more than one value: {', '.join(given)}", path)
    values = None
    for key, value in given.items():
        unit = key.removeprefix("value_")
        numbers = value if isinstance(value, list) else [value]
        fits = len(numbers) == len(effect.coefficients) and all(map(_is_number, numbers))
        if unit not in RADIANS_PER or not fits:
            raise BadInput(
                f"{effect.id} expects value_UNIT with {len(effect.coefficients)} number(s)"
                f" and one of the units {', '.join(RADIANS_PER)}",
                path,
            )
        values = tuple(float(number) * RADIANS_PER[unit] for number in numbers)
    return Term(effect, tuple(per), values)


def _is_number(value: object) -> bool:
    """Tell whether a value of a TOML file is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e99
