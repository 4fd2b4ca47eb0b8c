"""The page inside another: a frame for notebooks, with the verdict in words above it."""

from __future__ import annotations

from pyport.page.document import html
from pyport.page.markup import tag
from pyport.page.picture import Picture
from pyport.page.story import Story

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
