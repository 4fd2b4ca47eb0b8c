"""katpoint's pointing models: descriptions, configuration files, antennas; SKA-Mid's JSON.

Angles are written D:M:S, P9 and P12 are plain ratios, and what is missing at
the end is zero.
"""

from __future__ import annotations

import configparser
import json
import re
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.files import write_file
from pyport.formats.model_file import Entry, ModelFile
from pyport.models.terms.field_system import KATPOINT_NUMBER as NUMBER
from pyport.models.terms.field_system import RATIOS, UNITS
from pyport.recordings.formats.katpoint_csv import MODEL_FIELD, angle
from pyport.recordings.formats.text import Line, lines_of, read_text

_VALUE = r"[-+]?(?:\d+:\d+:\d+(?:\.\d*)?|\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\.\d+)"
_DESCRIPTION = re.compile(rf"{_VALUE}(?:(?:\s*,\s*|\s+){_VALUE})*")


def is_description(text: str) -> bool:
    """Tell whether a text is a description string of more than one parameter."""
    return bool(_DESCRIPTION.fullmatch(text.strip())) and len(_values(text)) > 1


def read(path: Path) -> ModelFile:
    """Read a description string, a configuration file or an antenna's description from a file.

    Raises `BadInput`: the file holds none of them.
    """
    lines = [line for line in lines_of(path) if line.text.strip()]
    if lines[0].text.strip() == "[header]":
        return _configuration(lines, path)
    first = lines[0]
    antenna = first.text.partition("=")[2] if first.text.startswith("#") else first.text
    if antenna.count(",") >= MODEL_FIELD and not is_description(antenna):
        return of_antenna(Line(path, first.number, antenna))
    if len(lines) > 1 or not _DESCRIPTION.fullmatch(first.text.strip()):
        wanted = "expected a katpoint description such as 0:03:12.5 0 -0:00:07.0"
        raise first.error(f"this is {first.text.strip()[:60]!r}, {wanted}")
    return describe(first)


def of_antenna(line: Line) -> ModelFile:
    """Return the pointing model in an antenna's description."""
    fields = [part.strip() for part in line.text.split(",")]
    return describe(Line(line.file, line.number, fields[MODEL_FIELD]), fields[0])


def describe(line: Line, title: str = "") -> ModelFile:
    """Return the model that a description string holds."""
    values = _values(line.text)
    if len(values) > NUMBER:
        raise line.error(f"{len(values)} parameters, expected at most {NUMBER}")
    return ModelFile("katpoint", tuple(entries(line, dict(enumerate(values, 1)))), title)


def entries(line: Line, values: dict[int, str]) -> list[Entry]:
    """Return P1, P2, ... that are not zero."""
    found = []
    for number, text in values.items():
        name = f"P{number}"
        unit = "" if name in RATIOS else "arcsec"
        value = angle(line, text) if unit else line.decimal(text, name)
        if value:
            found.append(Entry(name, value, unit))
    return found


def _values(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")] if "," in text else text.split()


def _configuration(lines: list[Line], path: Path) -> ModelFile:
    """Return the model of a file with [header] and [params]."""
    parser = configparser.ConfigParser(inline_comment_prefixes=(";", "#"), interpolation=None)
    try:
        parser.read_string("\n".join(line.text for line in lines))
        params, header = dict(parser["params"]), dict(parser["header"])
    except (configparser.Error, KeyError) as error:
        reason = str(error).replace("\n", " ")
        raise BadInput(f"no katpoint model with [header] and [params]: {reason}", path) from None
    values = {}
    for name, text in params.items():
        if not re.fullmatch(r"[pP]([1-9]|1\d|2[0-2])", name):
            raise BadInput(f"[params] has {name[:20]!r}, expected P1 to P{NUMBER}", path)
        values[int(name[1:])] = text
    return ModelFile("katpoint", tuple(entries(lines[0], values)), details={"header": header})


def write(file: ModelFile, path: Path) -> None:
    """Write a model in katpoint's vocabulary as a description string."""
    write_file(path, description(file) + "\n")


def description(file: ModelFile) -> str:
    """Return the description string of a model in katpoint's vocabulary."""
    by_name = {entry.name: entry for entry in file.entries if entry.used}
    texts = [
        _text(by_name[name]) if name in by_name else "0"
        for name in (f"P{n}" for n in range(1, NUMBER + 1))
    ]
    last = max((n for n, text in enumerate(texts, 1) if text != "0"), default=1)
    return " ".join(texts[:last])


def _text(entry: Entry) -> str:
    if not entry.value:
        return "0"
    if entry.unit:
        return sexagesimal(entry.value)
    short = f"{float(entry.value):.9g}"
    return short if Decimal(short) == entry.value else f"{entry.value}"


def sexagesimal(arcsec: Decimal) -> str:
    """Return arcseconds as D:M:S with all digits, at least one behind the point."""
    exponent = arcsec.as_tuple().exponent
    decimals = max(1, -exponent if isinstance(exponent, int) else 0)
    minutes, seconds = divmod(abs(arcsec), 60)
    degrees, minutes = divmod(minutes, 60)
    sign = "-" if arcsec < 0 else ""
    width = 3 + decimals
    return f"{sign}{int(degrees)}:{int(minutes):02d}:{seconds:0{width}.{decimals}f}"


INTERFACE = "https://schema.skao.int/ska-mid-dish-gpm/1.2"
#: The dish structure takes no coefficient beyond this.
LARGEST = 2000


def read_ska_mid(path: Path) -> ModelFile:
    """Read a global pointing model; `used` false means fixed.

    Raises `BadInput`: the file is no JSON, or lacks one of the eighteen coefficients.
    """
    try:
        tree = json.loads(read_text(path), parse_float=Decimal, parse_int=Decimal)
    except json.JSONDecodeError as error:
        raise BadInput(f"not JSON: {error.msg}", path, error.lineno) from None
    except (RecursionError, InvalidOperation) as error:
        raise BadInput(f"not SKA-Mid's JSON: {error}", path) from None
    held = tree.get("coefficients") if isinstance(tree, dict) else None
    if not isinstance(held, dict):
        raise BadInput("no 'coefficients', expected SKA-Mid's eighteen", path)
    missing = [name for name in UNITS if name not in held]
    extra = [name for name in held if name not in UNITS]
    if missing or extra:
        wrong = f"lacks {', '.join(missing)}" if missing else f"has {', '.join(extra)} too many"
        raise BadInput(f"'coefficients' {wrong}, expected SKA-Mid's eighteen", path)
    details = {key: value for key, value in tree.items() if key != "coefficients"}
    title = str(tree.get("antenna", ""))
    found = tuple(_entry(name, held[name], path) for name in UNITS)
    return ModelFile("ska-mid", found, title, details=details)


def _entry(name: str, given: Any, path: Path) -> Entry:  # noqa: ANN401 - whatever JSON holds
    if not isinstance(given, dict) or not isinstance(given.get("value"), Decimal):
        raise BadInput(f"{name} has no value, expected a number", path)
    unit = given.get("units", given.get("unit")) or UNITS[name]
    if unit != UNITS[name]:
        raise BadInput(f"{name} is in {unit!r}, expected {UNITS[name]!r}", path)
    sigma, used = given.get("stderr"), given.get("used", True)
    if not isinstance(sigma, Decimal | None) or not isinstance(used, bool):
        raise BadInput(f"{name} has a stderr or used that is none", path)
    value = given["value"]
    return Entry(name, value, unit, sigma, fixed=not used, used=used or value != 0)


def write_ska_mid(file: ModelFile, path: Path) -> None:
    """Write a model in SKA-Mid's vocabulary.

    Raises `BadInput`: a coefficient is beyond what the dish structure takes.
    """
    by_name = {entry.name: entry for entry in file.entries}
    nothing = {name: Entry(name, Decimal(0), unit, fixed=True) for name, unit in UNITS.items()}
    for entry in file.entries:
        if abs(entry.value) > LARGEST:
            raise BadInput(f"{entry.name} is {entry.value}, expected at most {LARGEST}", path)
    tree: dict[str, Any] = {"interface": INTERFACE, "antenna": file.title or "SKAxxx", "band": None}
    tree |= file.details
    tree["coefficients"] = {name: _as_json(by_name.get(name, nothing[name])) for name in UNITS}
    write_file(path, json.dumps(tree, indent=2, default=_plain) + "\n")


def _plain(value: object) -> float | str:
    """Return a number of decimals, or a date, as JSON can hold it."""
    return float(value) if isinstance(value, Decimal) else str(value)


def _as_json(entry: Entry) -> dict[str, Any]:
    return {
        "value": entry.value,
        "units": entry.unit,
        "stderr": entry.sigma,
        "used": entry.used and not entry.fixed,
    }
