"""Tables spelled as TOML, which the standard library reads and does not write."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def spelled(whole: Mapping[str, Any]) -> str:
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
    return [f"{_key(key)} = {_value(one, spread=True)}" for key, one in table.items()]


def _key(key: str) -> str:
    bare = key.replace("_", "").replace("-", "")
    return key if bare.isascii() and bare.isalnum() else _text(key)


def _text(text: str) -> str:
    # JSON leaves DEL as it is, which TOML does not allow
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, *, spread: bool = False) -> str:  # noqa: ANN401 - what TOML holds
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        if spread and value and isinstance(value[0], Mapping | list | tuple):
            return "[\n" + "".join(f"  {_value(one)},\n" for one in value) + "]"
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, str):
        return _text(value)
    return json.dumps(value)  # numbers, true and false are spelled alike in both
