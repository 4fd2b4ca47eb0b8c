"""The page as one file: words, panels, their numbers, and nothing from anywhere else."""

from __future__ import annotations

import base64
import hashlib
import json
from importlib.resources import files
from pathlib import Path

from pyport import __version__
from pyport.files import write_whole
from pyport.page import sections, tables
from pyport.page.markup import Markup, tag
from pyport.page.payload import MOST_DRAWN, payload
from pyport.page.picture import Picture
from pyport.page.story import Story

#: The program of the page, in the order in which its parts need each other.
SCRIPTS = (
    "unpack",
    "svg",
    "pointer",
    "scales",
    "against",
    "sky",
    "spread",
    "rings",
    "gram",
    "refit",
    "downloads",
    "main",
)


def write(picture: Picture, story: Story, path: Path) -> Path:
    """Write the page, whole or not at all, and return its path."""
    with write_whole(path) as file:
        file.write(html(picture, story))
    return path


def html(picture: Picture, story: Story) -> str:
    """Return the page; the same picture and story give the same bytes."""
    script = _script()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    # Nothing is fetched, and no script runs but this one, whatever a label holds.
    policy = f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'"
    data = payload(picture) | {"file": story.source.file, "model": story.model_file}
    numbers = json.dumps(data, separators=(",", ":"), ensure_ascii=True)
    head = tag(
        "head",
        Markup('<meta charset="utf-8">'),
        Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
        Markup(f'<meta http-equiv="Content-Security-Policy" content="{policy}">'),
        tag("title", f"{story.source.file}: {story.headline}"),
        Markup(f"<style>{_text('page.css')}</style>"),
    )
    parts = _main(picture, story)
    body = tag(
        "body",
        sections.head(story),
        sections.contents(parts),
        tag("main", *parts),
        sections.foot(story, __version__),
        Markup(f'<script type="application/json" id="data">{_inert(numbers)}</script>'),
        Markup(f"<script>{script}</script>"),
    )
    return f'<!doctype html>\n<html lang="en">{head}\n{body}</html>\n'


def _main(picture: Picture, story: Story) -> list[Markup | None]:
    stretch = tag(
        "label",
        "length of the vectors ",
        tag("input", id="stretch", type="range", min="-2", max="5", step="0.25", value="0"),
        class_="switch stretch",
    )
    drawn = ""
    if len(picture) > MOST_DRAWN:
        drawn = f" {MOST_DRAWN:,} of {len(picture):,} recordings are drawn, chosen at random."
    return [
        sections.findings(story),
        tag("div", id="bar", role="toolbar"),
        Markup("<noscript><p>The panels are drawn by a script in this page.</p></noscript>"),
        sections.section(
            "sky",
            "Over the sky",
            "Residual vectors, from where the telescope pointed. Point at one to see the "
            "recording; drag a box to choose recordings in every panel, Escape to let them go."
            f"{drawn}",
            stretch,
            tag("div", class_="panels two", id="sky-panels"),
        ),
        sections.section(
            "against",
            "Against what they may follow",
            "Lines are medians of bins with equally many points"
            + (": dashed before, solid after. " if picture.layers else ". ")
            + ("Yellow is where a finding is confined to. " if story.cards else "")
            + "Points beyond the frame lie on its edge; grey ones are not counted.",
            tag("div", class_="panels", id="against-panels"),
            tag("div", id="chosen"),
        ),
        sections.section(
            "spread",
            "How far off",
            "The dashed curve is what noise alone would give."
            if any(side.floor for _, side in picture.sides())
            else "",
            tag("div", class_="panels", id="spread-panels"),
            sections.unseen(story),
            *tables.by_label(picture),
        ),
        tables.parameters(story),
        sections.refit() if picture.linear is not None and len(picture) <= MOST_DRAWN else None,
        tables.candidates(story),
        sections.sight(story),
        sections.rows_aside(story),
    ]


def _script() -> str:
    parts = "\n".join(_text(f"{name}.js") for name in SCRIPTS)
    return f'(() => {{\n"use strict";\n{parts}}})();\n'


def _text(name: str) -> str:
    return (files("pyport.page") / "static" / name).read_text(encoding="utf-8")


def _inert(text: str) -> str:
    """Return JSON that cannot end the element it stands in."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


HEIGHT = 720


def framed(picture: Picture, story: Story) -> str:
    """Return the page in a frame of its own.

    Scripts and styles of the page and of the notebook cannot touch each other.
    Where frames are not shown the words above it remain.
    """
    found = [
        tag("li", tag("b", f"{one.title}, {one.verdict}: "), one.sentence) for one in story.cards
    ]
    return str(
        tag(
            "div",
            tag("p", tag("b", story.headline), f" {story.lead}"),
            tag("ol", *found) if found else None,
            tag(
                "iframe",
                srcdoc=html(picture, story),
                sandbox="allow-scripts allow-downloads",
                style=f"width:100%;height:{HEIGHT}px;border:1px solid #8884;border-radius:8px",
                title=story.headline,
            ),
        )
    )
