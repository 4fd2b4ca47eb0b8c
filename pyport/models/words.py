"""A completed model in words: what to enter into the control system, and what that changes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pyport.models.completed import Completed, Value

#: How every table calls a coefficient's value, what the file has, and their difference.
ENTER, IN_FILE, CHANGE = (
    "enter this into the control system",
    "in the file",
    "change against the file",
)
#: More coefficients than this are those of many antennas or sessions: a file holds them.
MOST_LINES = 40


def lines(completed: Completed) -> list[str]:
    """Return the table of a completed model for the terminal."""
    values = completed.values
    if not values:
        return []
    if len(values) > MOST_LINES:
        return [
            f"{len(values)} coefficients to {ENTER.removesuffix(' this')}: see completed_model."
        ]
    told = has_before(values)
    head = [ENTER, *([IN_FILE, CHANGE] if told else [])]
    wide = max(len(label(one)) for one in values)
    found = [f"{'':{wide}s}  {'   '.join(head)}"]
    return found + [_line(one, wide, [len(one) for one in head]) for one in values]


def has_before(values: Sequence[Value]) -> bool:
    """Tell whether the model that was given had values of its own."""
    return any(one.before for one in values)


def label(one: Value) -> str:
    """Return the name of a coefficient with the labels that it holds for."""
    return one.name + (f"[{' '.join(one.labels.values())}]" if one.labels else "")


def _line(one: Value, wide: int, widths: Sequence[int]) -> str:
    digits = decimals(one)
    numbers = [f"{one.value:.{digits}f}", f"{one.before:.{digits}f}", f"{one.change:+.{digits}f}"]
    cells = [f"{text:>{width}s}" for text, width in zip(numbers, widths, strict=False)]
    known = "held" if one.sigma is None else f"+- {one.sigma:.{digits}f}"
    open_ = "" if one.determined else ", not determined by these recordings"
    found = "" if one.finding is None else f"  finding {one.finding}"
    return f"{label(one):{wide}s}  {'   '.join(cells)} {known} {one.unit}{open_}{found}".rstrip()


def decimals(one: Value) -> int:
    """Return so many decimals that the error has two digits, as the page has."""
    size = one.sigma or abs(one.value)
    return max(0, min(9, 1 - math.floor(math.log10(size)))) if size > 0 else 3
