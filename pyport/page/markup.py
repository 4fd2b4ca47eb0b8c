"""HTML from text that may hold anything: every value is escaped here and nowhere else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.naming.words import number, spoken
from pyport.effects.empirical.fields import UNKNOWN
from pyport.errors import BadInput
from pyport.models import toml
from pyport.models.complete import label
from pyport.models.model import Model, Term
from pyport.recordings.schema import Recordings
from pyport.report.typed import Finding
from pyport.toml_text import toml_spelled

#: Parameters shown on a finding's card; the table has them all.
MOST_PARAMETERS = 4


def notes(finding: Finding, axes: tuple[str, str]) -> list[tuple[str, str]]:
    """Return what else there is to say of a finding: where, what else it could be, what next.

    `axes` is what the mount calls its axes.
    """
    where = finding.where
    found = [
        (f"{one.column.replace('_', ' ')}", f"from {one.low:.4g} to {one.high:.4g}")
        for one in where.region
    ]
    found += [(name, " ".join(values)) for name, values in where.subset.items()]
    if where.since:
        found.append(("since" if where.until is None else "from", where.since))
    if where.between:
        found.append(("began between", " and ".join(where.between)))
    if where.until:
        found.append(("to", where.until))
    if finding.looks_like:
        found.append(("looks like", finding.looks_like))
    if len(finding.class_) > 1:
        found.append(("could as well be", ", ".join(finding.class_[1:]).replace("_", " ")))
    if len(finding.parameters) <= MOST_PARAMETERS:
        found += [(spoken(p.name, axes), number(p)) for p in finding.parameters]
    if finding.evidence.runner_up not in (None, finding.effect):
        gain = finding.evidence.runner_up_delta_bic
        text = str(finding.evidence.runner_up).replace("_", " ")
        found.append(("next best", text if gain is None else f"{text}, gain in BIC {gain:,.0f}"))
    found += [("" if n else "checked", one) for n, one in enumerate(finding.checks)]
    if finding.stability is not None:
        found.append(("resampled", finding.stability.words))
    if finding.decide_by:
        found.append(("next", finding.decide_by))
    return found


#: More coefficients than these are no table to switch them in, and too long for a page.
MOST_COEFFICIENTS = 40
#: A model's file of more characters than this would be most of the page.
LARGEST_FILE = 150_000


@dataclass(frozen=True)
class Linear:
    """A completed model's coefficients and what one unit of each adds to n recordings."""

    #: `names`, `labels`: the coefficient, and the same with the antenna or session that it holds
    #: for.
    names: tuple[str, ...]
    labels: tuple[str, ...]
    #: `units`, `values`: as the model's file has them.
    units: tuple[str, ...]
    values: tuple[float, ...]
    free: tuple[bool, ...]  #: whether it was fitted
    #: `x`, `y`: offsets of one unit [rad], shape (P, n) each.
    x: Array
    y: Array


def linear(model: Model, recordings: Recordings) -> Linear | None:
    """Return what can be fitted again of a completed model, None for nothing or for too much."""
    if model.completed is None or not model.completed.values:
        return None
    columns = list(_columns(model, recordings))
    kept = [
        (one, x, y)
        for one, (x, y) in zip(model.completed.values, columns, strict=True)
        if one.effect != UNKNOWN
    ]
    if not 0 < len(kept) <= MOST_COEFFICIENTS:
        return None
    values = [one for one, _, _ in kept]
    return Linear(
        tuple(one.name for one in values),
        tuple(map(label, values)),
        tuple(one.unit for one in values),
        tuple(one.value for one in values),
        tuple(one.sigma is not None for one in values),
        np.stack([x for _, x, _ in kept]),
        np.stack([y for _, _, y in kept]),
    )


def as_file(model: Model) -> str | None:
    """Return the text of the model's file, None where none can hold it or it is too long."""
    try:
        text = toml_spelled(toml.tree(model))
    except BadInput:
        return None
    return text if len(text) <= LARGEST_FILE else None


def _columns(model: Model, recordings: Recordings) -> Iterator[tuple[Array, Array]]:
    """Yield what one unit of each coefficient adds, in the order of a completed model's values."""
    for term in model.terms:
        x, y = term.effect.columns(recordings.at)
        for labels in term.by or {(): ()}:
            there = _rows(term, labels, recordings)
            for n, coefficient in enumerate(term.effect.coefficients):
                yield x[:, n] * there * coefficient.scale, y[:, n] * there * coefficient.scale


def _rows(term: Term, labels: tuple[str, ...], recordings: Recordings) -> Array:
    """Return 1 for the recordings that a set of labels is of, shape (n,)."""
    there = np.ones(len(recordings), bool)
    for name, value in zip(term.per, labels, strict=False):
        there &= recordings.label(name).astype(str) == value
    return there.astype(float)


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
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Markup(f"<{name}{written}>" + ("" if name in VOID else f"{join(inside)}</{name}>"))


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

    def cells(kind: str, row: Sequence[str]) -> list[Markup]:
        return [tag(kind, cell, class_="n" if n >= first else None) for n, cell in enumerate(row)]

    return scrolled(cells("th", head), [tag("tr", *cells("td", row)) for row in rows])


def scrolled(heads: Sequence[Markup], body: Sequence[Markup], kind: str | None = None) -> Markup:
    """Return a table that scrolls by itself, of the cells of its head and its other rows."""
    whole = tag("table", tag("thead", tag("tr", *heads)), tag("tbody", *body), class_=kind)
    return tag("div", whole, class_="scroll", tabindex="0")
