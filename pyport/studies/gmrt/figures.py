"""The GMRT paper's figures: elevation offsets against hour angle, an antenna a panel."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pyport.angles import ARCMIN, HOUR
from pyport.files import write_whole
from pyport.studies.gmrt.curves import Curve, curve
from pyport.studies.gmrt.published import Wave, table_18
from pyport.studies.gmrt.sessions import ANTENNAS
from pyport.studies.gmrt.tracks import Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Figures 1 to 4 of the paper.
FIGURES = {1: "2003-05-31", 2: "2003-06-01", 3: "2003-06-02", 4: "2003-06-05"}

BLUE, ORANGE, BLACK = "#0072B2", "#D55E00", "#222222"


def write_figures(found: Sequence[Track], folder: Path) -> list[Path]:
    """Draw the days of these tracks into `folder`/figure-N.png and return the paths."""
    written = []
    for number, session in FIGURES.items():
        day = {track.antenna: track for track in found if track.session == session}
        if day:
            path = folder / f"figure-{number}.png"
            with write_whole(path, "wb") as file:
                draw(number, session, day).savefig(file, format="png", dpi=130)
            written.append(path)
    return written


def draw(number: int, session: str, day: dict[str, Track]) -> Figure:
    """Draw one day: the offsets of each antenna, the published curve and the curve fitted here."""
    from matplotlib.figure import Figure

    published = {wave.antenna: wave for wave in table_18() if wave.session == session}
    figure = Figure(figsize=(11, 13))
    # by hand: matplotlib needs seconds to fit 30 panels
    figure.subplots_adjust(0.07, 0.06, 0.99, 0.94, wspace=0.25, hspace=0.25)
    panels = figure.subplots(6, 5, sharex=True)
    for antenna, axes in zip(ANTENNAS, panels.flat, strict=True):
        _panel(axes, antenna, day.get(antenna), published.get(antenna))
    figure.supxlabel("hour angle [h]", x=0.25, y=0.012, fontsize=13)
    figure.supylabel("elevation offset, encoder minus true [arcmin]", x=0.008, fontsize=13)
    figure.suptitle(f"Figure {number}: elevation offsets against hour angle, {session}", y=0.985)
    fullest = max(day, key=lambda antenna: len(day[antenna]))
    figure.legend(
        *panels.flat[ANTENNAS.index(fullest)].get_legend_handles_labels(),
        loc="lower right",
        ncols=4,
        fontsize=11,
    )
    return figure


def _panel(axes: Axes, antenna: str, track: Track | None, published: Wave | None) -> None:
    """Draw one antenna, or say that there are no offsets of it."""
    axes.set_title(antenna, fontsize=11, pad=2)
    axes.tick_params(labelsize=9)
    axes.locator_params(axis="y", nbins=5)
    if track is None:
        axes.text(0.5, 0.5, "no offsets", ha="center", va="center", transform=axes.transAxes)
        axes.set_yticks([])
        return
    for sign, colour, marker, name in (
        (1, BLUE, "^", "forward"),
        (-1, ORANGE, "v", "reverse"),
    ):
        own = track.direction == sign
        axes.plot(
            track.hour_angle[own] / HOUR,
            track.offset[own] / ARCMIN,
            marker,
            ms=4,
            color=colour,
            label=name,
        )
    h = np.linspace(track.hour_angle.min(), track.hour_angle.max(), 100)
    fitted: Curve = curve(track)
    axes.plot(h / HOUR, fitted(h) / ARCMIN, "-", lw=1, color=BLACK, label="curve, fitted here")
    if published is not None:
        axes.plot(h / HOUR, published(h) / ARCMIN, "--", lw=1.2, color="#009E73", label="Table 18")
