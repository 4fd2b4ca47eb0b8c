"""The keys of report.json as a page of the manual, from the types of the report."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from pyport.report.typed import Report


def keys(kind: type = Report, path: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield path, type and meaning of every key that a file of a report may have."""
    hints = get_type_hints(kind, include_extras=True)
    for one in dataclasses.fields(kind):
        if not one.metadata.get("written", True):
            continue
        held, meaning = get_args(hints[one.name])
        inner, many = _inside(held)
        here = f"{path}{one.name.rstrip('_')}"
        yield here, _spelled(held), meaning
        if isinstance(inner, type) and dataclasses.is_dataclass(inner):
            yield from keys(inner, f"{here}{many}.")


def _inside(kind: Any) -> tuple[Any, str]:  # noqa: ANN401 - a type
    """Return what a type holds, and what stands for its place in a path."""
    if get_origin(kind) is UnionType:
        kind = next(one for one in get_args(kind) if one is not type(None))
    if get_origin(kind) is tuple:
        return get_args(kind)[0], "[]"
    if get_origin(kind) is dict:
        return get_args(kind)[1], ".NAME"
    return kind, ""


def _spelled(kind: Any) -> str:  # noqa: ANN401 - a type
    """Return a type in words of JSON."""
    if dataclasses.is_dataclass(kind) or kind is dict or get_origin(kind) is dict:
        return "object"
    if get_origin(kind) in {tuple, list}:
        return "list"
    if parts := get_args(kind):
        return " or ".join("null" if one is type(None) else _spelled(one) for one in parts)
    names = {str: "text", int: "number", float: "number", bool: "true or false"}
    return names.get(kind, "any")


def markdown() -> str:
    """Return the page of all keys."""
    rows = (f"| `{path}` | {kind} | {meaning} |" for path, kind, meaning in keys())
    return "\n".join([_HEAD, "| key | type | |", "|---|---|---|", *rows, ""])


_HEAD = """# The keys of `report.json`

Written by `pyport dev keys`. `pyport diagnose RECORDINGS --out DIR` leaves a `report.json` for each
file. In a path, `[]` stands for each entry of a list and `NAME` for each key of an object. Numbers
that are not known are null. Beside these, `computed_with` says what computed it (numpy, or the
compiled kernel) and `files` holds the hashes of the files beside it.
"""
