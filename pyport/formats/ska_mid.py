"""SKA-Mid's global pointing model: JSON, eighteen coefficients for an antenna and a band."""

from __future__ import annotations

import json
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.model_file import Entry, ModelFile
from pyport.models.terms.field_system import UNITS
from pyport.recordings.formats.csv import read_text

INTERFACE = "https://schema.skao.int/ska-mid-dish-gpm/1.2"
#: The dish structure takes no coefficient beyond this.
LARGEST = 2000


def read(path: Path) -> ModelFile:
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


def _entry(name: str, told: Any, path: Path) -> Entry:  # noqa: ANN401 - whatever JSON holds
    if not isinstance(told, dict) or not isinstance(told.get("value"), Decimal):
        raise BadInput(f"{name} has no value, expected a number", path)
    unit = told.get("units", told.get("unit")) or UNITS[name]
    if unit != UNITS[name]:
        raise BadInput(f"{name} is in {unit!r}, expected {UNITS[name]!r}", path)
    sigma, used = told.get("stderr"), told.get("used", True)
    if not isinstance(sigma, Decimal | None) or not isinstance(used, bool):
        raise BadInput(f"{name} has a stderr or used that is none", path)
    value = told["value"]
    return Entry(name, value, unit, sigma, fixed=not used, used=used or value != 0)


def write(file: ModelFile, path: Path) -> None:
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
    with write_whole(path) as out:
        json.dump(tree, out, indent=2, default=_plain)
        out.write("\n")


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
