"""Model files of all formats, read by suffix or content, and TOML with any program's names."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, cast

from pyport.errors import BadInput
from pyport.files import is_file, write_file
from pyport.formats import discos, katpoint_model, tpoint_mod
from pyport.formats.field_system import ctl
from pyport.formats.model_file import UPRIGHT_DEG, WORDS, Entry, ModelFile, in_unit
from pyport.models import toml
from pyport.models.model import BUILT_IN, Model
from pyport.models.terms import editing
from pyport.models.terms.words import SCALES
from pyport.recordings.formats.text import Line, is_measured, read_text
from pyport.toml_text import toml_spelled

#: Keys of the value and its sigma in a unit.
_SUFFIX = {unit: f"_{unit}" if unit else "" for unit in SCALES}
_MARKS = ("fixed", "used", "parallel")
#: No coefficient is as large.
TURN_DEG = 360


def _whole(value: object) -> bool:
    """Tell whether this is a list of whole numbers that are not negative."""
    some = isinstance(value, list)
    return some and all(type(one) is int and one >= 0 for one in cast("list[Any]", value))


#: What writers ask of details, and in words.
_DETAILS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "statistics": (
        lambda one: isinstance(one, dict) and all(map(_is_number, one.values())),
        "a table of numbers",
    ),
    "number_and_date": (lambda one: _whole(one) and len(one) >= 6, "six whole numbers or more"),
    "flags": (
        lambda one: _whole(one) and all(flag <= 4 for flag in one),
        "whole numbers from 0 to 4",
    ),
    "comments": (lambda one: isinstance(one, str), "a text"),
}


def _is_number(value: object) -> bool:
    some = isinstance(value, Decimal | int) and not isinstance(value, bool)
    return some and is_measured(Decimal(cast("Decimal | int", value)))


def names_terms(path: Path) -> bool:
    """Tell whether a TOML file names its vocabulary; one that lists effects does not."""
    try:
        return "vocabulary" in tomllib.loads(read_text(path))
    except (ValueError, RecursionError):  # whoever reads the file as effects says what is wrong
        return False


def read_toml(path: Path) -> ModelFile:
    """Read a model in the vocabulary that the file names.

    Raises `BadInput`: the file is no such TOML, or a term is none of its vocabulary.
    """
    try:
        tree = tomllib.loads(read_text(path), parse_float=Decimal)
    except BadInput:
        raise
    except (ValueError, InvalidOperation, RecursionError) as error:
        raise BadInput(f"{error}: expected TOML", path) from None
    vocabulary = str(tree.get("vocabulary"))
    if vocabulary not in WORDS:
        wanted = f"expected one of {', '.join(WORDS)}"
        raise BadInput(f"no vocabulary is called {vocabulary[:20]!r}, {wanted}", path)
    rows = tree.get("term")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise BadInput("no [[term]] table: a model lists its terms, one table each", path)
    found = tuple(_entry(row, vocabulary, path) for row in rows)
    names = [one.name for one in found]
    if twice := next((name for name in names if names.count(name) > 1), ""):
        raise BadInput(f"{twice} stands twice, expected each term once", path)
    details = tree.get("details", {})
    if not isinstance(details, dict):
        raise BadInput(f"details is {details!r:.40}, expected a table", path)
    for name, (holds, wanted) in _DETAILS.items():
        if name in details and not holds(details[name]):
            raise BadInput(f"{name} is {details[name]!r:.40}, expected {wanted}", path)
    flags = details.get("flags", ())
    if flags and max(_place(one) for one in found) > len(flags):
        raise BadInput(f"{len(flags)} flags, expected one for each parameter", path)
    phi = _number(tree.get("phi_deg", UPRIGHT_DEG), "phi_deg", path)
    return ModelFile(vocabulary, found, str(tree.get("name", "")), phi, details)


def _place(entry: Entry) -> int:
    """Return which of P1, P2, ... a term is, 0 where it is none of them."""
    number = entry.name.removeprefix("P")
    return int(number) if number.isdecimal() and len(number) < 4 else 0


def _entry(row: dict[str, Any], vocabulary: str, path: Path) -> Entry:
    name = str(row.get("name"))
    meant = str(row.get("formula", ""))
    if not meant and WORDS[vocabulary](name) is None:
        wrong = f"{name[:20]!r} is no term that pyport knows of {vocabulary}"
        raise BadInput(f"{wrong}; say what it does: formula = 'x = sin 3A sin E'", path)
    if meant:
        try:
            editing.formula_word(name, meant)
        except BadInput as error:
            raise BadInput(error.message, path) from None
    units = [unit for unit, suffix in _SUFFIX.items() if f"value{suffix}" in row]
    if len(units) != 1:
        wanted = ", ".join(f"value{suffix}" for suffix in _SUFFIX.values())
        raise BadInput(f"{name} expects one of {wanted}", path)
    (unit,) = units
    value, sigma = (row.get(f"{key}{_SUFFIX[unit]}") for key in ("value", "sigma"))
    marks = {mark: row[mark] for mark in _MARKS if mark in row}
    number = _number(value, f"{name}'s value", path)
    spread = None if sigma is None else _number(sigma, f"{name}'s sigma", path)
    if not all(isinstance(mark, bool) for mark in marks.values()):
        raise BadInput(f"{name}: {', '.join(marks)} are true or false", path)
    return Entry(name, number, unit, spread, **marks, formula=meant)


def _number(value: object, what: str, path: Path) -> Decimal:
    if _is_number(value):
        return Decimal(cast("Decimal", value))
    raise BadInput(f"{what} is {value!r}, expected a number", path)


def write(file: ModelFile, path: Path) -> None:
    """Write a model with its digits as they stand."""
    whole: dict[str, Any] = {"name": file.title} if file.title else {}
    whole["vocabulary"] = file.vocabulary
    if file.phi_deg != UPRIGHT_DEG:
        whole["phi_deg"] = file.phi_deg
    tables = {"term": [_row(entry) for entry in file.entries], "details": file.details}
    text = toml_spelled(whole | {key: table for key, table in tables.items() if table})
    write_file(path, text)


def _row(entry: Entry) -> dict[str, Any]:
    suffix = _SUFFIX[entry.unit]
    row: dict[str, Any] = {"name": entry.name, f"value{suffix}": entry.value}
    if entry.formula:
        row["formula"] = entry.formula
    if entry.sigma is not None:
        row[f"sigma{suffix}"] = entry.sigma
    default = Entry("", Decimal(0), "")
    changed = (mark for mark in _MARKS if getattr(entry, mark) != getattr(default, mark))
    return row | {mark: getattr(entry, mark) for mark in changed}


@dataclass(frozen=True)
class ModelFormat:
    """A format of model files: its name, suffixes, vocabulary, and how it is read and written.

    `any_mount` tells whether it has terms for others than alt-azimuth ones.
    """

    name: str
    suffixes: tuple[str, ...]
    vocabulary: str
    read: Callable[[Path], ModelFile]
    write: Callable[[ModelFile, Path], None] | None
    any_mount: bool = False


FORMATS = {
    one.name: one
    for one in (
        ModelFormat(
            "tpoint-mod", (".mod",), "tpoint", tpoint_mod.read, tpoint_mod.write, any_mount=True
        ),
        ModelFormat("fs-ctl", (".ctl",), "field-system", ctl.read, ctl.write, any_mount=True),
        ModelFormat("fs-err-model", (), "field-system", ctl.read_new_model, None),
        ModelFormat(
            "katpoint", (".txt", ".katpoint"), "katpoint", katpoint_model.read, katpoint_model.write
        ),
        ModelFormat(
            "ska-mid",
            (".json",),
            "ska-mid",
            katpoint_model.read_ska_mid,
            katpoint_model.write_ska_mid,
        ),
        ModelFormat("discos", (".xml",), "field-system", discos.read, discos.write),
        ModelFormat("toml", (".toml",), "", read_toml, write),
    )
}
BY_SUFFIX = {suffix: one for one in FORMATS.values() for suffix in one.suffixes}


def load(name: str) -> Model:
    """Return a built-in model, one from a file, or from a katpoint description.

    Files are TOML; TPOINT's .mod, the Field System's .ctl and .err, katpoint's, SKA-Mid's .json and
    DISCOS's .xml, of which `FILE#RECEIVER` picks one.

    Raises `BadInput`: there is no such model or file, or the file does not describe a model.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]()
    if katpoint_model.is_description(name):
        line = Line(Path("katpoint description"), 1, name)
        return katpoint_model.describe(line).model("katpoint description")
    path, _ = split(name)
    if not is_file(path):
        known = ", ".join(sorted(BUILT_IN))
        raise BadInput(f"no model and no file is called {name!r}; built in are {known}")
    if path.suffix.lower() == ".toml" and not names_terms(path):
        return toml.model_of(path)
    return read(name).model(path.stem)


def split(name: str | Path) -> tuple[Path, str]:
    """Return the path and the receiver of `FILE#RECEIVER`."""
    path = Path(name)
    if is_file(path):
        return path, ""
    file, _, receiver = str(name).rpartition("#")
    return (Path(file), receiver) if file else (path, "")


def read(name: str | Path, chosen: str = "") -> ModelFile:
    """Read a model file, of a named format, of its suffix's, or of what its content looks like.

    Raises `BadInput`: there is no such file, or it is none of a model.
    """
    path, receiver = split(name)
    if not is_file(path):
        raise BadInput("no such file, expected a pointing model", path)
    if receiver:
        return _checked(discos.read(path, receiver), path)
    return _checked((FORMATS[chosen] if chosen else format_of(path)).read(path), path)


def _checked(file: ModelFile, path: Path) -> ModelFile:
    """Return a model whose numbers can be what they stand for.

    Raises `BadInput`: its first axis rises by more than a right angle, or a term is a turn or more.
    """
    if abs(file.phi_deg) > UPRIGHT_DEG:
        raise BadInput(f"phi is {file.phi_deg} deg, expected -90 to 90", path)
    for entry in file.entries:
        if entry.used and abs(in_unit(entry.value, entry.unit, "deg")) >= TURN_DEG:
            said = f"{entry.name} is {entry.value} {entry.unit}".rstrip()
            raise BadInput(f"{said}, expected less than a turn", path)
    return file


def format_of(path: Path) -> ModelFormat:
    """Return the format of a model file by its suffix; katpoint's has none of its own."""
    if path.suffix.lower() == ".err":
        return FORMATS["fs-err-model"]
    return BY_SUFFIX.get(path.suffix.lower(), FORMATS["katpoint"])
