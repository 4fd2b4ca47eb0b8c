"""Where an array's antennas stand: displacements that recordings imply, against a survey's."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pyport.diagnosis.arrays.places import Comparison, Places
from pyport.diagnosis.arrays.report import ArrayReport
from pyport.plots import pictures
from pyport.plots.findings import BLUE, GREY, ORANGE, SCREEN_DPI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

KM = 1000.0
#: So many antennas farthest off the others are named in the picture, and all beyond two sigmas.
NAMED = 8


def write_places(found: ArrayReport, folder: Path) -> Path | None:
    """Draw into `folder`/array-places.png and return the path; None where no site is known."""
    if found.places is None:
        return None
    picture = draw(found.places, found.comparison)
    return pictures.write(picture, folder / "array-places.png", SCREEN_DPI)


def draw(places: Places, comparison: Comparison | None) -> Figure:
    """Draw implied displacements against surveyed ones, or by antenna where there is no survey."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 6.4), layout="constrained")
    axes = figure.add_subplot()
    if comparison is None:
        _by_antenna(axes, places)
    else:
        _beside_survey(axes, places, comparison)
    axes.tick_params(labelsize=9)
    return figure


def _beside_survey(axes: Axes, places: Places, one: Comparison) -> None:
    surveyed, implied = one.surveyed_m / KM, one.implied_m / KM
    at = [places.antennas.index(name) for name in one.antennas]
    reach = 1.08 * np.array([surveyed.min(), surveyed.max()])
    axes.plot(reach, reach, "-", color=GREY, lw=1, label="as surveyed")
    label = f"{one.slope:.2f} $\\pm$ {one.slope_sigma:.2f} of it, correlation {one.correlation:.2f}"
    axes.plot(reach, one.slope * reach, "--", color=ORANGE, lw=1.4, label=label)
    axes.errorbar(
        surveyed,
        implied,
        one.sigma_m / KM,
        fmt="none",
        ecolor=GREY,
        lw=1,
        label="each mount's lean",
    )
    axes.errorbar(
        surveyed,
        implied,
        places.sigma_m[at] / KM,
        fmt="o",
        ms=4,
        color=BLUE,
        capsize=2,
        label="implied by the recordings",
    )
    far = np.argsort(-np.abs(surveyed))[:NAMED]
    for n in np.union1d(far, np.flatnonzero(np.abs(one.misses) > 2)):
        axes.annotate(
            one.antennas[n],
            (surveyed[n], implied[n]),
            xytext=(5, 5),
            textcoords="offset points",
            fontsize=8,
        )
    axes.set_xlabel("surveyed displacement toward east, about the mean [km]")
    axes.set_ylabel("implied displacement toward east, about the mean [km]")
    axes.legend(fontsize=9, loc="upper left")
    axes.set_title(f"{len(one.antennas)} antennas", fontsize=10)


def _by_antenna(axes: Axes, places: Places) -> None:
    order = np.arange(len(places.antennas))
    axes.axhline(0, color=GREY, lw=0.8)
    for some, colour, label in (
        (places.usable, BLUE, "well known"),
        (~places.usable, GREY, "poorly known"),
    ):
        if some.any():
            axes.errorbar(
                order[some],
                places.east_m[some] / KM,
                places.sigma_m[some] / KM,
                fmt="o",
                ms=4,
                color=colour,
                ecolor=colour,
                capsize=2,
                label=label,
            )
    axes.set_xticks(order, places.antennas, rotation=90, fontsize=8)
    axes.set_ylabel("implied displacement toward east of the median antenna [km]")
    axes.legend(fontsize=9)
