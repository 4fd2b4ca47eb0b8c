"""How figures for print look, and the panels that are drawn from the page's tables."""

from __future__ import annotations

import functools
from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from pyport.page.story import Story

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.ticker import Locator

#: Okabe and Ito's colours, which every eye can distinguish, also in grey.
BEFORE, AFTER, GREY, REGION = "#D55E00", "#0072B2", "#8A8A8A", "#F0E442"
#: Margins of a stack of panels whose marks are numbers: left, right, bottom, top. [inches]
MARGINS = 0.82, 0.12, 0.48, 0.08
#: Pixels per inch of a figure in a notebook: seven inches fill its column.
SCREEN_DPI = 110
_STYLE: dict[str, Any] = {
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.labelsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def in_style(draw: Callable[[], Figure]) -> Callable[[], Figure]:
    """Return a function that draws with small type and open frames, and leaves no trace of it."""

    def drawn() -> Figure:
        import matplotlib as mpl

        with mpl.rc_context(cast(Any, _STYLE)):
            return draw()

    return drawn


@functools.cache
def _shown() -> type[Figure]:
    """Return figures that a notebook shows: without pyplot it knows no other way to draw them."""
    from matplotlib.figure import Figure

    class Shown(Figure):
        def _repr_png_(self) -> bytes:
            file = BytesIO()
            self.savefig(file, format="png", dpi=SCREEN_DPI)
            return file.getvalue()

    return Shown


def figure(width: float, height: float) -> Figure:
    """Return an empty figure [inches], which a notebook shows as a picture."""
    return _shown()(figsize=(width, height), layout="constrained")


def framed(width: float, height: float) -> Figure:
    """Return an empty figure [inches] with margins for numbers, which need not be measured."""
    made = _shown()(figsize=(width, height))
    left, right, bottom, top = MARGINS
    made.subplots_adjust(
        left / width, bottom / height, 1 - right / width, 1 - top / height, hspace=0.1
    )
    return made


def nice(value: float) -> float:
    """Return a round number (1, 2 or 5 times a power of ten) not far above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(m * power for m in (1, 2, 5, 10) if m * power >= value * 0.999))


def hours(first: float, span: float) -> Locator:
    """Return where an axis of seconds since `first` [s, UTC] has its marks: at full hours or so."""
    from matplotlib.ticker import FixedLocator

    steps = (60, 300, 600, 1800, 3600, 7200, 10800, 21600, 43200, 86400)
    step = next((one for one in steps if span / one <= 9), 86400 * max(1, round(span / 7 / 86400)))
    start = -(-first // step) * step - first
    return FixedLocator(np.arange(start, span + 1, step).tolist())


def bars(story: Story) -> Figure:
    """Draw rms before and after beside the noise, of everything and of each antenna."""
    made = figure(7.0, 0.9 + 0.19 * max(3, len(story.bars)))
    axes = made.subplots()
    places = np.arange(len(story.bars))[::-1]
    before, after = (np.array([getattr(b, k) for b in story.bars]) for k in ("before", "after"))
    axes.hlines(places, after, before, color=GREY, lw=1)
    axes.plot(before, places, "o", ms=4, color=BEFORE, label="before")
    axes.plot(after, places, "o", ms=4, color=AFTER, label="after")
    floors = [(b.floor, p) for b, p in zip(story.bars, places, strict=True) if b.floor is not None]
    if floors:
        axes.plot(*zip(*floors, strict=True), "k|", ms=9, label="noise alone")
    axes.set_yticks(places, [one.name for one in story.bars])
    axes.set_xlim(left=0)
    how = f", {story.bars_how}" if story.bars_how else ""
    axes.set_xlabel(f"rms [arcsec]{how}")
    axes.legend(fontsize=7, loc="upper right")
    return made


def heat(story: Story) -> Figure:
    """Draw the correlations of the coefficients."""
    names, matrix = story.correlation
    labels = [name.replace("_", " ") for name in names]
    side = 1.6 + 0.27 * len(names)
    made = figure(side + 0.6, side)
    axes = made.subplots()
    image = axes.imshow(np.array(matrix), cmap="PuOr_r", vmin=-1, vmax=1)
    axes.set_xticks(np.arange(len(labels)), labels, rotation=90)
    axes.set_yticks(np.arange(len(labels)), labels)
    if len(names) <= 16:
        for (i, j), value in np.ndenumerate(np.array(matrix)):
            colour = "white" if abs(value) > 0.75 else "black"
            text = f"{100 * value:.0f}".replace("-0", "0")
            axes.text(j, i, text, ha="center", va="center", fontsize=6, color=colour)
    made.colorbar(image, ax=axes, shrink=0.7, label="correlation")
    return made


def candidates(story: Story) -> Figure:
    """Draw, turn by turn, what each candidate gained."""
    turns = story.turns
    made = figure(7.0, sum(0.6 + 0.18 * len(one.rivals) for one in turns))
    rows = made.subplots(
        len(turns), 1, squeeze=False, height_ratios=[3 + len(one.rivals) for one in turns]
    )[:, 0]
    for n, (axes, turn) in enumerate(zip(rows, turns, strict=True), 1):
        places = np.arange(len(turn.rivals))[::-1]
        gains = [max(one.delta_bic, 0) for one in turn.rivals]
        colours = [BEFORE if one.member else AFTER for one in turn.rivals]
        axes.barh(places, gains, color=colours, height=0.7)
        axes.set_yticks(
            places,
            [f"{r.effect} {r.variant}".strip().replace("_", " ")[:60] for r in turn.rivals],
        )
        axes.set_title(f"turn {n}: {turn.winner.replace('_', ' ')}", loc="left")
        axes.set_xlabel("gain in BIC; in orange, what cannot be distinguished")
    return made
