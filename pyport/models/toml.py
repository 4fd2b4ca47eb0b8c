"""Models as TOML: every term with its values, what they were, and all that was found."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import DEG, RADIANS_PER, Array
from pyport.effects import Site, known
from pyport.errors import BadInput
from pyport.files import write_file
from pyport.models.conditions import Completed, Value
from pyport.models.members import effect_of
from pyport.models.model import BUILT_IN, PER_ANTENNA, Model, Term, rt32_values
from pyport.mounts import ALTAZ, KINDS
from pyport.recordings.formats.text import read_text
from pyport.toml_text import toml_spelled

SCHEMA = "pyport.model/1"
#: A covariance of more coefficients is left out: 500 make a triangle of a megabyte.
MOST_IN_COVARIANCE = 500
#: Digits of a covariance: a sigma to a millionth of itself.
_COVARIANCE_DIGITS = 7


def tree(model: Model) -> dict[str, Any]:
    """Return a completed model as tables, for TOML and JSON alike.

    Raises `BadInput`: the model was not completed, or by fewer offsets than coefficients, or has
      terms that no file can hold.
    """
    completed = model.completed
    if completed is None:
        raise BadInput(f"the model {model.name} was not completed by a fit or a diagnosis")
    if wrong := completed.undetermined:
        raise BadInput(wrong, Path(completed.made["recordings"]))
    if completed.unsaved:
        raise BadInput(f"no file can hold the model's terms {', '.join(completed.unsaved)}")
    rows = iter(completed.values)
    whole: dict[str, Any] = {"schema": SCHEMA, "name": model.name}
    if model.base:
        whole["given"] = model.base
    if model.site is not None:
        whole["site"] = _site(model.site)
    if model.mount is not ALTAZ:
        whole["mount"] = model.mount.id
    whole["made"] = {key: value for key, value in completed.made.items() if value is not None}
    whole["term"] = [_term(term, rows) for term in model.terms]
    if completed.findings:
        whole["finding"] = [_without_none(one) for one in completed.findings]
    if len(completed.values) <= MOST_IN_COVARIANCE:
        lower = completed.covariance
        whole["covariance"] = {
            "lower_triangle": [
                [float(f"{one:.{_COVARIANCE_DIGITS}g}") for one in row[: n + 1]]
                for n, row in enumerate(lower.tolist())
            ]
        }
    return whole


def _site(site: Site) -> dict[str, float]:
    found = {"latitude_deg": site.latitude / DEG}
    if site.longitude is not None:
        found["longitude_deg"] = site.longitude / DEG
    return found | {"height_m": site.height_m}


def _term(term: Term, rows: Any) -> dict[str, Any]:  # noqa: ANN401 - an iterator of values
    found: dict[str, Any] = {"effect": term.effect.id, "per": list(term.per)}
    if term.effect.variant:
        found["variant"] = term.effect.variant
    if term.finding is not None:
        found["finding"] = term.finding
    if term.fixed:
        found["fixed"] = True
    if term.effect.member:
        found["member"] = dict(term.effect.member)
    count = len(term.effect.coefficients) * max(1, len(term.by))
    found["coefficients"] = [_coefficient(next(rows)) for _ in range(count)]
    return found


def _coefficient(one: Value) -> dict[str, Any]:
    found: dict[str, Any] = {"name": one.name, "value": one.value}
    if one.sigma is not None:
        found["sigma"] = one.sigma
    found |= {"before": one.before, "unit": one.unit}
    if one.labels:
        found["labels"] = dict(one.labels)
    if not one.determined:
        found["determined"] = False
    return found


def _without_none(value: Any) -> Any:  # noqa: ANN401 - what JSON holds
    """Return tables without what TOML cannot spell: nothing, and what is not finite."""
    if isinstance(value, Mapping):
        return {key: _without_none(one) for key, one in value.items() if _spelled(one)}
    if isinstance(value, list | tuple):
        return [_without_none(one) for one in value if _spelled(one)]
    return value


def _spelled(value: Any) -> bool:  # noqa: ANN401 - what JSON holds
    return value is not None and not (isinstance(value, float) and not np.isfinite(value))


def write(model: Model, path: Path) -> None:
    """Write a completed model, whole or not at all.

    Raises `BadInput`: the model was not completed.
    """
    write_file(path, toml_spelled(tree(model)))


def read(content: Mapping[str, Any], path: Path) -> Model:
    """Return the completed model that the tables of a TOML file hold.

    Raises `BadInput`: they hold none, or one of another schema.
    """
    if content.get("schema") != SCHEMA:
        raise BadInput(f"schema is {content.get('schema')!r:.40}, expected {SCHEMA!r}", path)
    try:
        return _model(content, path)
    except BadInput as error:
        raise BadInput(error.message, path) from None
    except KeyError as error:
        raise BadInput(f"no key {error}, expected a model as pyport writes it", path) from None
    except (TypeError, ValueError, ArithmeticError, AttributeError) as error:
        wrong = f"{type(error).__name__} {error}: not a model as pyport writes it"
        raise BadInput(wrong, path) from None


def _model(content: Mapping[str, Any], path: Path) -> Model:
    base = str(content.get("given", ""))
    if base and (base not in BUILT_IN or BUILT_IN[base]().given is None):
        raise BadInput(f"given is {base[:40]!r}, expected one of the RT32's models")
    given = BUILT_IN[base]().given if base else None
    about = rt32_values(base)
    terms, values = [], []
    for row in content["term"]:
        term, own = _read_term(row, about)
        terms.append(term)
        values += own
    return Model(
        str(content.get("name", path.stem)),
        tuple(terms),
        given,
        base,
        _read_site(content.get("site")),
        Completed(
            dict(content.get("made", {})),
            tuple(values),
            _square(content.get("covariance", {}).get("lower_triangle"), len(values)),
            tuple(content.get("finding", ())),
        ),
        mount=KINDS[content.get("mount", ALTAZ.id)],
    )


def _read_site(table: Mapping[str, Any] | None) -> Site | None:
    if table is None:
        return None
    latitude, longitude, height_m = (
        None if table.get(name) is None else _number(table[name], name)
        for name in ("latitude_deg", "longitude_deg", "height_m")
    )
    if latitude is None or abs(latitude) > 90:
        raise BadInput(f"latitude_deg is {latitude}, expected one from -90 to 90")
    return Site(latitude * DEG, None if longitude is None else longitude * DEG, height_m or 0.0)


def _read_term(row: Mapping[str, Any], about: Mapping[int, float]) -> tuple[Term, list[Value]]:
    effect = effect_of(str(row["effect"]), row.get("member", {}))
    per = tuple(map(str, row["per"]))
    finding = row.get("finding")
    zero = about.get(effect.member.get("rt32", 0), 0.0)
    values = [_read_value(one, effect.id, finding) for one in row["coefficients"]]
    k = len(effect.coefficients)
    if not values or len(values) % k:
        raise BadInput(f"{effect.id} has {len(values)} coefficients, expected {k} a set of labels")
    by: dict[tuple[str, ...], tuple[float, ...]] = {}
    for start in range(0, len(values), k):
        own = values[start : start + k]
        for value, coefficient in zip(own, effect.coefficients, strict=True):
            if value.unit != coefficient.unit:
                expected = f"expected {coefficient.unit!r}"
                raise BadInput(f"{value.name} is in {value.unit!r:.20}, {expected}")
        labels = tuple(own[0].labels.get(label, "") for label in per)
        by[labels] = tuple(
            value.value * one.scale - zero
            for value, one in zip(own, effect.coefficients, strict=True)
        )
    of_all = next(iter(by.values())) if len(by) == 1 else None
    fixed, number = bool(row.get("fixed", False)), None if finding is None else int(finding)
    return Term(effect, per, of_all, fixed, by if of_all is None else {}, number), values


def _read_value(row: Mapping[str, Any], effect: str, finding: int | None) -> Value:
    sigma = row.get("sigma")
    return Value(
        name=str(row["name"]),
        effect=effect,
        unit=str(row["unit"]),
        value=_number(row["value"], row["name"]),
        sigma=None if sigma is None else _number(sigma, row["name"]),
        before=_number(row.get("before", 0.0), row["name"]),
        labels={str(key): str(one) for key, one in row.get("labels", {}).items()},
        finding=finding,
        determined=bool(row.get("determined", True)),
    )


def _number(value: object, name: str) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        return float(value)
    raise BadInput(f"{name} has {value!r:.40}, expected a number")


def _square(rows: Sequence[Sequence[float]] | None, size: int) -> Array:
    """Return the matrix whose lower triangle is given, zeros without one."""
    out = np.zeros((size, size))
    if rows is None:
        return out
    if [len(row) for row in rows] != list(range(1, size + 1)):
        raise BadInput(f"the covariance is no lower triangle of {size} rows")
    for n, row in enumerate(rows):
        out[n, : n + 1] = out[: n + 1, n] = row
    if not np.isfinite(out).all():
        raise BadInput("the covariance has what is no number")
    return out


def load(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises `BadInput`: it is none.
    """
    try:
        return tomllib.loads(read_text(path))
    except BadInput:
        raise
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not a TOML file: {error}", path) from None


def model_of(path: Path) -> Model:
    """Read a completed model, or `[[term]]` tables: an effect, `per`, value_UNIT for each.

    Raises `BadInput`: the file does not describe a model.
    """
    text = load(path)
    if "schema" in text:
        return read(text, path)
    rows = text.get("term")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise BadInput("no [[term]] table: a model lists its effects, one table each", path)
    return Model(str(text.get("name", path.stem)), tuple(_listed(row, path) for row in rows))


def _listed(row: dict[str, Any], path: Path) -> Term:
    effect = known(str(row.get("effect")))
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
