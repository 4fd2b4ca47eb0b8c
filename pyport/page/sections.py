"""The parts of the page that are words and tables, as HTML."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from html import unescape

from pyport.page.markup import Markup, join, table, tag
from pyport.page.story import Bar, Card, Story
from pyport.pointing import kernel

#: Rows of a table beyond which it is cut.
CUT = 400


def head(story: Story) -> Markup:
    """Return the verdict and the key figures."""
    verdict = "the model suffices" if story.good else "the model falls short"
    pill = tag("span", verdict, class_=f"pill {'good' if story.good else 'bad'}")
    facts = [
        tag("div", *_pair(name, value, tag("small", beside))) for name, value, beside in story.facts
    ]
    words = tag(
        "div",
        tag(
            "p",
            tag("b", "pyport"),
            tag("span", f"{story.kind} of {story.source.file}"),
            tag("span", f"model {story.model}"),
            pill if story.kind == "diagnosis" else None,
            class_="brand",
        ),
        tag("h1", story.headline),
        tag("p", story.lead, class_="lead"),
        tag("ul", *(tag("li", text) for text in story.warnings), class_="warning")
        if story.warnings
        else None,
        tag("dl", *facts, class_="facts"),
    )
    return tag("header", words, tag("div", id="first-sky"))


def contents(parts: Sequence[Markup | None]) -> Markup:
    """Return links to the sections, and to what can be taken from the page."""
    found = re.findall(r'<section id="([^"]+)"><h2>([^<]+)</h2>', join(parts))
    links = [tag("a", unescape(title), href=f"#{name}") for name, title in found]
    return tag("nav", *links, tag("span", id="downloads"), aria_label="contents")


def refit() -> Markup:
    """Return the place where the page fits the model's terms again."""
    return section(
        "refit",
        "Fit again",
        "Hold terms or leave them out, mask recordings that a dragged box has chosen: the page "
        "fits the rest by least squares, all readings alike, and every panel follows.",
        tag("div", class_="plain", id="refit-table"),
    )


def section(name: str, title: str, how: str, *inside: Markup | None) -> Markup:
    """Return a section with its heading and a line on how to read it."""
    return tag(
        "section", tag("h2", title), tag("p", how, class_="how") if how else None, *inside, id=name
    )


def findings(story: Story) -> Markup | None:
    """Return a card for each finding, the strongest first."""
    if not story.cards:
        return None
    cards = [_card(n, one) for n, one in enumerate(story.cards, 1)]
    return section(
        "findings",
        "What was left out",
        "Strongest first. A switch takes an effect off the residuals, or leaves it in.",
        tag("div", *cards, class_="cards"),
    )


def _card(n: int, card: Card) -> Markup:
    switch = None
    if card.layer is not None:
        switch = tag(
            "label",
            tag("input", type="checkbox", data_layer=str(card.layer), checked=""),
            "taken off the residuals",
            class_="switch",
        )
    return tag(
        "article",
        tag(
            "div",
            tag("span", f"{n}", class_="rank"),
            tag("h3", card.title),
            tag("span", card.verdict, class_=f"pill {card.verdict}"),
            switch,
            class_="head",
        ),
        tag("p", f"{card.sentence[:1].upper()}{card.sentence[1:]}.", class_="sentence"),
        tag("dl", *(tag("div", *_pair(*pair)) for pair in card.facts), class_="numbers"),
        tag("dl", *(part for pair in card.notes for part in _pair(*pair)), class_="notes")
        if card.notes
        else None,
        class_="card",
    )


def _pair(name: str, *value: str) -> tuple[Markup, Markup]:
    return tag("dt", name), tag("dd", *value)


def unseen(story: Story) -> Markup | None:
    """Return rms before and after beside the noise floor, of everything and of each antenna."""
    if not story.bars:
        return None
    sizes = [v for b in story.bars for v in (b.before, b.after, b.floor or 0.0) if math.isfinite(v)]
    most = max(sizes, default=1.0) * 1.04 or 1.0
    rail = tag("div", *(part for one in story.bars for part in _bar(one, most)), class_="rail")
    legend = tag(
        "p",
        tag("span", tag("i", class_="before"), "before"),
        tag("span", tag("i", class_="after"), "after"),
        tag("span", tag("i", class_="floor"), "noise alone") if story.bars[0].floor else None,
        tag("span", "rms in arcsec"),
        class_="legend",
    )
    title = "On data that the fit had not seen" if story.bars_how else "Rms before and after"
    how = tag("p", story.bars_how, class_="how") if story.bars_how else None
    return tag("div", tag("h3", title), how, rail, legend, class_="plain")


def _bar(bar: Bar, most: float) -> list[Markup]:
    def at(value: float) -> str:
        return f"{100 * min(max(value / most, 0), 1) if math.isfinite(value) else 0:.2f}%"

    low, high = sorted((bar.before, bar.after))
    run = f"left:{at(low)};width:calc({at(high)} - {at(low)})"
    marks = [
        tag("i", class_="run", style=run),
        tag("i", class_="dot before", style=f"left:{at(bar.before)}"),
        tag("i", class_="dot after", style=f"left:{at(bar.after)}"),
    ]
    if bar.floor is not None:
        marks.append(tag("i", class_="floor", style=f"left:{at(bar.floor)}"))
    numbers = f"{bar.after:.3g}"
    if bar.before != bar.after:
        numbers = f"{bar.before:.3g} → {numbers}"
    return [
        tag("span", bar.name, class_="name"),
        tag("span", *marks, class_="track"),
        tag("span", numbers),
    ]


def sight(story: Story) -> Markup | None:
    """Return what would have been seen, and what these recordings cannot show."""
    parts = []
    if story.limits:
        rows = [(name.replace("_", " "), f"{size:.2g}") for name, size in story.limits]
        parts.append(
            _folded(
                f"How small an effect would have been seen: {len(rows)} effects",
                "Rms that half of all such recordings would have shown.",
                table(("effect", "arcsec rms"), rows, 1),
                unfolded=story.good,
            )
        )
    if story.dropped:
        parts.append(
            _folded(
                f"Looked at and dropped: {len(story.dropped)} effects",
                "The search found them, and they do not predict data that were left out.",
                table(("effect", "why"), story.dropped),
            )
        )
    if story.noise:
        parts.append(tag("ul", *(tag("li", one) for one in story.noise), class_="noise"))
    if story.untestable:
        rows = [(name.replace("_", " "), reason) for name, reason in story.untestable]
        parts.append(
            _folded(
                f"What these recordings cannot show: {len(rows)} effects",
                "",
                table(("effect", "why"), rows),
            )
        )
    if not parts:
        return None
    return section("sight", "What could be seen, and what could not", "", *parts)


def rows_aside(story: Story) -> Markup | None:
    """Return the rows that were not used, each with its reason, and the outliers."""
    parts = []
    for title, rows in (
        ("excluded rows", story.source.set_aside),
        ("offsets not counted, as outliers", story.outliers),
    ):
        if rows:
            listed = [(str(line), reason) for line, reason in rows[:CUT]]
            more = f"The first {CUT} of {len(rows)}." if len(rows) > CUT else ""
            parts.append(_folded(f"{len(rows):,} {title}", more, table(("line", "reason"), listed)))
    if not parts:
        return None
    return section("aside", "What was not used", "Nothing is dropped in silence.", *parts)


def _folded(title: str, how: str, inside: Markup, *, unfolded: bool = False) -> Markup:
    return tag(
        "details",
        tag("summary", title),
        tag("p", how, class_="how") if how else None,
        inside,
        open="" if unfolded else None,
    )


def foot(story: Story, version: str) -> Markup:
    """Return where the page comes from."""
    parts = [f"pyport {version}, computed with {kernel.path()}", f"file {story.source.file}"]
    if story.source.sha256:
        parts.append(f"SHA-256 {story.source.sha256}")
    parts += [f"{key} {value}" for key, value in story.source.meta if key != "bookkeeping"]
    return tag("footer", tag("p", " · ".join(parts)))
