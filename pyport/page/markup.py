"""HTML from text that may hold anything: every value is escaped here and nowhere else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Elements that hold nothing and are not closed.
VOID = frozenset({"br", "input", "meta"})


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def tag(name: str, *inside: str | None, **attributes: str | None) -> Markup:
    """Return an element; text inside is escaped unless it is `Markup`.

    An underscore at the end of an attribute's name is dropped (`class_`), one
    within is a hyphen (`data_layer`); an attribute of None is left out.
    """
    told = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Markup(f"<{name}{told}>" + ("" if name in VOID else f"{join(inside)}</{name}>"))


def join(parts: Iterable[str | None]) -> Markup:
    """Return parts one after the other, escaped where they are no markup."""
    return Markup(
        "".join(
            one if isinstance(one, Markup) else escape(said(one))
            for one in parts
            if one is not None
        )
    )


def said(text: str) -> str:
    """Return plain text as it is printed: with a plus-minus and with minus signs."""
    return re.sub(r"(?<![\w.-])-(?=\d)", "−", text.replace("+-", "±"))


def chance(p_value: float) -> str:
    """Return a probability in words that hold where it underflows."""
    if p_value <= 1e-300:
        return "below 10⁻³⁰⁰"
    if p_value >= 1e-3:
        return f"{p_value:.2g}"
    digits, _, power = f"{p_value:.1e}".partition("e")
    return f"{digits} × 10{str(int(power)).translate(_RAISED)}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], numeric: int = 0) -> Markup:
    """Return a table that scrolls by itself; the last `numeric` columns are numbers."""
    first = len(head) - numeric

    def cells(kind: str, row: Sequence[str]) -> Markup:
        return join(
            tag(kind, cell, class_="n" if n >= first else None) for n, cell in enumerate(row)
        )

    return tag(
        "div",
        tag(
            "table",
            tag("thead", tag("tr", cells("th", head))),
            tag("tbody", *(tag("tr", cells("td", row)) for row in rows)),
        ),
        class_="scroll",
        tabindex="0",
    )
