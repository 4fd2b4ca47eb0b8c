"""What a set publishes, read back: JSON whose shape is checked before anything relies on it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from pyport.errors import BadInput

_HEXADECIMAL = re.compile(r"[0-9a-f]*")
#: Names of cases become names of files, so they can hold nothing that leads elsewhere.
_CASE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,99}")


def read_json(path: Path) -> Any:  # noqa: ANN401 - whatever JSON holds
    """Read JSON; `BadInput` where there is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput("there is no such file: expected one of a sealed set", path) from None
    except (ValueError, RecursionError) as error:
        raise BadInput(f"this is no JSON ({error})", path) from None


def read_seal(path: Path) -> dict[str, Any]:
    """Read the hashes that fix a set, `sealed.json`.

    Raises `BadInput`: there is no such file, or something that a seal tells is missing or of
      another kind.
    """
    sealed = _table(read_json(path), path, "a seal")
    for key in ("name", "solver_sha256", "examiner_sha256"):
        _text(sealed, key, path)
    _table(sealed.get("thresholds"), path, "thresholds")
    cases = sealed.get("cases")
    if not isinstance(cases, list) or not cases:
        raise BadInput("no list of cases, expected that of a sealed set", path)
    for one in cases:
        case = _table(one, path, "a case")
        _name(case.get("case"), path)
        for key in ("recordings_sha256", "truth_commitment"):
            if not _HEXADECIMAL.fullmatch(_text(case, key, path)):
                raise BadInput(f"{key} is no hash, expected hexadecimal digits", path)
        arguments = case.get("arguments")
        if not isinstance(arguments, list) or not all(isinstance(one, str) for one in arguments):
            raise BadInput(f"{case['case']} has no list of arguments, expected words", path)
    return sealed


def read_answers(path: Path) -> dict[str, str]:
    """Read the hashes of all reports by case, out of `answers.json`.

    Raises `BadInput`: there is no such file, or it is of another shape.
    """
    held = _table(read_json(path), path, "answers").get("reports_sha256")
    hashes = _table(held, path, "reports_sha256")
    for case in hashes:
        _name(case, path)
        _text(hashes, case, path)
    return hashes


def read_report(path: Path) -> dict[str, Any]:
    """Read what was kept of a solver's answer, `report.json`.

    Raises `BadInput`: there is no such file, or something that scoring relies on is of another
      kind.
    """
    report = check_report(read_json(path), path)
    examined = _table(report.get("examined"), path, "examined")
    _optional(examined, "failed", path, _is_text, "text")
    return report


def check_report(value: object, path: Path) -> dict[str, Any]:
    """Return a solver's answer, whoever the solver was.

    Raises `BadInput`: something that scoring relies on is of another kind than a report's.
    """
    report = _table(value, path, "a report")
    _optional(report, "p_value", path, _is_number, "a number")
    for finding in _list(report, "findings", path):
        for key in ("effect", "verdict"):
            _text(finding, key, path)
        names = finding.get("class")
        if not isinstance(names, list) or not all(map(_is_text, names)):
            raise BadInput("a finding has no list of names as its class", path)
        for parameter in _list(finding, "parameters", path):
            _text(parameter, "name", path)
            if not _is_number(parameter.get("value")):
                raise BadInput(f"parameter {parameter['name'][:40]!r} has no number", path)
            for key in ("sigma", "expected"):
                _optional(parameter, key, path, _is_number, "a number")
        evidence = _table(finding.get("evidence") or {}, path, "evidence")
        _optional(evidence, "runner_up", path, _is_text, "text")
        _check_place(_table(finding.get("where"), path, "where"), path)
    return report


def _check_place(where: dict[str, Any], path: Path) -> None:
    for interval in _list(where, "region", path):
        _text(interval, "column", path)
        for key in ("low", "high"):
            if key not in interval:
                raise BadInput(f"an interval has no {key}, expected a number or null", path)
            _optional(interval, key, path, _is_number, "a number")
    for point in _list(where, "curve", path):
        if not (_is_number(point.get("az_deg")) and _is_number(point.get("el_deg"))):
            raise BadInput("a point of a curve is not az_deg and el_deg, expected both", path)
    _optional(where, "since", path, _is_moment, "an ISO 8601 time")


def _list(table: dict[str, Any], key: str, path: Path) -> list[dict[str, Any]]:
    found = table.get(key) or []
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise BadInput(f"{key} is {str(found)[:40]!r}, expected a list of JSON objects", path)
    return found


def _optional(
    table: dict[str, Any], key: str, path: Path, fits: Callable[[object], bool], wanted: str
) -> None:
    value = table.get(key)
    if value is not None and not fits(value):
        raise BadInput(f"{key} is {str(value)[:40]!r}, expected {wanted}", path)


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_number(value: object) -> bool:
    """Tell whether a value is a number that sums of squares can hold."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e99


def _is_moment(value: object) -> bool:
    try:
        datetime.fromisoformat(str(value)).timestamp()
    except (ValueError, OverflowError, OSError):
        return False
    return isinstance(value, str)


def _table(value: object, path: Path, what: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise BadInput(f"{what} is {str(value)[:40]!r}, expected a JSON object", path)
    return value


def _text(table: dict[str, Any], key: str, path: Path) -> str:
    value = table.get(key)
    if not isinstance(value, str):
        raise BadInput(f"{key[:40]!r} is {str(value)[:40]!r}, expected text", path)
    return value


def _name(value: object, path: Path) -> None:
    if not isinstance(value, str) or not _CASE.fullmatch(value):
        raise BadInput(f"a case is called {str(value)[:40]!r}, expected letters and digits", path)
