"""A completed model in words: what to enter into the control system, and what that changes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pyport.effects.fields import UNKNOWN
from pyport.models.completed import Completed, Value
from pyport.models.model import Term

#: How every table calls a coefficient's value, what the file has, and their difference.
ENTER, IN_FILE, CHANGE = (
    "enter this into the control system",
    "in the file",
    "change against the file",
)
GRID = "pyport convert writes it for another program as waves, or with --rest-as grid.csv as a grid"
#: Endings of names of what a coefficient is counted from.
COUNTED = frozenset({"c", "s", "centre", "rad", "h"})
#: More coefficients than this are those of many antennas or sessions: a file holds them.
MOST_LINES = 40


def lines(completed: Completed, terms: Sequence[Term] = ()) -> list[str]:
    """Return the table of a completed model for the terminal.

    What a coefficient is counted from (a mean temperature, a moment) stands below, as far as
    `terms` tell; a field without a name has numbers that no control system takes.
    """
    values = [one for one in completed.values if one.effect != UNKNOWN]
    fields = {one.finding for one in completed.values if one.effect == UNKNOWN}
    told = [f"finding {n}: a field without a name; {GRID}" for n in sorted(fields, key=str)]
    told += [f"{term.effect.id}: {_counted(term)}" for term in terms if _counted(term)]
    if not values:
        return told
    return _table(values) + told


def _table(values: Sequence[Value]) -> list[str]:
    if len(values) > MOST_LINES:
        return [
            f"{len(values)} coefficients to {ENTER.removesuffix(' this')}: see completed_model."
        ]
    head = [ENTER, *([IN_FILE, CHANGE] if has_before(values) else [])]
    wide = max(len(label(one)) for one in values)
    found = [f"{'':{wide}s}  {'   '.join(head)}"]
    return found + [_line(one, wide, [len(one) for one in head]) for one in values]


def _counted(term: Term) -> str:
    """Return what a term's coefficients are counted from, as a file tells it."""
    if {"word", "rt32"} & set(term.effect.member) or term.effect.id == UNKNOWN:
        return ""
    numbers = {
        name: value
        for name, value in term.effect.member.items()
        if name.rpartition("_")[2] in COUNTED and isinstance(value, int | float)
    }
    return ", ".join(f"{name} = {value:.10g}" for name, value in numbers.items())


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
