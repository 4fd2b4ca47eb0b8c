"""Tables as the text of a TOML file."""

from __future__ import annotations

import datetime as dt
import json
import math
from collections.abc import Mapping
from decimal import Decimal
from typing import Any

#: Places of a decimal number beyond which it has a power of ten instead: no measurement has.
MOST_PLACES = 99


def toml_spelled(whole: Mapping[str, Any]) -> str:
    """Return tables as TOML, coefficients and rows of matrices one a line."""
    lines = [f"{key} = {_value(one)}" for key, one in whole.items() if not _is_table(one)]
    for key, one in whole.items():
        if isinstance(one, Mapping):
            lines += ["", f"[{key}]", *_pairs(one)]
        elif _is_table(one):
            for row in one:
                lines += ["", f"[[{key}]]", *_pairs(row)]
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:  # noqa: ANN401 - what TOML holds
    rows = isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)
    return isinstance(value, Mapping) or rows


def _pairs(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_value(one, spread=True)}" for key, one in _there(table)]


def _there(table: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Return keys and values, without those that are nothing: TOML cannot say so."""
    return [(str(key), one) for key, one in table.items() if one is not None]


def _key(key: str) -> str:
    bare = key.replace("_", "").replace("-", "")
    return key if bare.isascii() and bare.isalnum() else _text(key)


def _text(text: str) -> str:
    # JSON leaves DEL and halves of surrogate pairs as they are, which TOML does not allow
    whole = text.encode("utf-8", "replace").decode()
    return json.dumps(whole, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, *, spread: bool = False) -> str:  # noqa: ANN401 - what TOML holds
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in _there(value)) + " }"
    if isinstance(value, list | tuple):
        if spread and value and isinstance(value[0], Mapping | list | tuple):
            return "[\n" + "".join(f"  {_value(one)},\n" for one in value) + "]"
        return "[" + ", ".join(_value(one) for one in value if one is not None) + "]"
    return _text(value) if isinstance(value, str) else _scalar(value)


def _scalar(value: Any) -> str:  # noqa: ANN401 - what TOML holds
    if isinstance(value, Decimal):
        return _decimal(value)
    if isinstance(value, dt.date | dt.time):
        return value.isoformat()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return json.dumps(value)  # other numbers, true and false are spelled alike in both


def _decimal(value: Decimal) -> str:
    """Return a number with its digits as they stand; one that is no whole number has a point."""
    if not value.is_finite():
        return str(float(value))
    text = str(value) if abs(value.adjusted()) > MOST_PLACES else f"{value:f}"
    return text if {".", "E"} & set(text) or not value.as_tuple().exponent else f"{text}.0"
