"""What a set publishes, read back: JSON whose shape is checked before anything relies on it."""

from __future__ import annotations

import json
import re
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

    Raises
    ------
    BadInput
        There is no such file, or something that a seal tells is missing or of another kind.
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

    Raises
    ------
    BadInput
        There is no such file, or it is of another shape.
    """
    held = _table(read_json(path), path, "answers").get("reports_sha256")
    hashes = _table(held, path, "reports_sha256")
    for case in hashes:
        _name(case, path)
        _text(hashes, case, path)
    return hashes


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
