"""Arguments of the Python interface: taken for what they are, or refused in one line."""

from __future__ import annotations

import difflib
import math
import operator
import os
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput

#: A name this near to a known one is a slip: `sessoin` (0.857) of `session`, `section` (0.71) not.
SLIP = 0.85


def refusal(name: str, value: object, expected: str) -> BadInput:
    """Return what is said of an argument that cannot be used."""
    kind = "None" if value is None else f"of type {type(value).__name__}"
    if isinstance(value, str | int | float):
        kind = f"{value!r:.60}"
    return BadInput(f"{name} is {kind}, expected {expected}")


def nearest(name: str, known: Iterable[str], least: float = 0.6) -> str | None:
    """Return the known name that is spelled most like another, None where none is alike.

    `least`: how much alike it has to be, from 0 to 1: difflib's ratio.
    """
    return next(iter(difflib.get_close_matches(name, list(known), 1, least)), None)


def mapping(name: str, value: Any) -> Mapping[Any, Any]:  # noqa: ANN401 - whatever is given
    """Return a mapping whose keys are texts, or refuse."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise refusal(name, value, "names and values: a dictionary")
    return value


def texts(name: str, value: Any) -> tuple[str, ...]:  # noqa: ANN401 - whatever is given
    """Return texts, one alone as one of them, or refuse."""
    if isinstance(value, str):
        return (value,)
    found = several(value)
    if found is None or not all(isinstance(one, str) for one in found):
        raise refusal(name, value, "a text or several")
    return found


def several(value: Any) -> tuple[Any, ...] | None:  # noqa: ANN401 - whatever is given
    """Return what a flat collection holds; None where it is none, as a text or a matrix."""
    some = isinstance(value, Collection) and not isinstance(value, str)
    return tuple(value) if some and getattr(value, "ndim", 1) == 1 else None


def number(name: str, value: Any, low: float, high: float = math.inf) -> float:  # noqa: ANN401
    """Return a finite number between limits, both excluded, or refuse."""
    try:
        found = float(value) if np.ndim(value) == 0 and not isinstance(value, str) else math.nan
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not low < found < high:
        limit = "" if math.isinf(high) else f" and below {high:g}"
        raise refusal(name, value, f"a number above {low:g}{limit}")
    return found


def whole(name: str, value: Any, lowest: int) -> int:  # noqa: ANN401 - whatever is given
    """Return a whole number that is not too low, or refuse."""
    try:
        found = operator.index(value)
    except TypeError:
        found = lowest - 1
    if found < lowest:
        raise refusal(name, value, f"a whole number, {lowest} or more")
    return found


def place(name: str, value: Any) -> Path:  # noqa: ANN401 - whatever is given
    """Return the place of a file, or refuse."""
    if not isinstance(value, str | os.PathLike) or "\0" in os.fspath(value):
        raise refusal(name, value, "the place of a file")
    return Path(value)
