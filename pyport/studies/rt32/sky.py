"""The RT32 document's figures 3, 4 and 5: what the model leaves over the sky."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array, separation
from pyport.files import write_whole
from pyport.fitting.fit import off_by
from pyport.page.of_diagnosis import bars_of, picture_of, source_of
from pyport.page.picture import Layer, Picture, sides
from pyport.page.story import Row, Story
from pyport.plots.findings import BLUE, GREY, ORANGE
from pyport.pointing import PARAMETERS, jump_altitude
from pyport.report.typed import as_json
from pyport.studies.rt32.fit import Rt32Fit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


RED = "#CC0000"

#: Averages of figure 4 reach so far, and leave out residuals larger than this [rad].
SMOOTHING_RADIUS = 5 * DEG
SMOOTHING_LARGEST = 0.01 * DEG

#: An average of fewer residuals than this is not drawn.
_FEWEST = 3

#: The scale bar [deg], and how many degrees of the sky's axes stand for it.
_BAR_DEG = 0.02
_BAR_AZ_DEG, _BAR_ALT_DEG = 24.0, 8.0
_SMOOTH_BAR_DEG = 0.005

#: Figures 3 and 5 show residuals up to this [deg]; in figure 3 a cross stands for a larger one.
_REACH_DEG = 0.04


@dataclass(frozen=True)
class Residuals:
    """What is left on one axis: azimuth from south (unwrapped), altitude, residual [rad], (m,)."""

    az_south: Array
    altitude: Array
    value: Array

    @property
    def large(self) -> NDArray[np.bool_]:
        """Return which are larger than figure 4 takes."""
        return np.abs(self.value) > SMOOTHING_LARGEST


def residuals(fit: Rt32Fit) -> tuple[Residuals, Residuals]:
    """Return the residuals of azimuth (times cos H) and of altitude."""
    at, is_y = fit.recordings.at, fit.stack.is_y
    az, alt = at.az[fit.stack.row] - np.pi, at.el[fit.stack.row]
    across, along = (Residuals(az[rows], alt[rows], fit.residual[rows]) for rows in (~is_y, is_y))
    return across, along


def smoothed(left: Residuals, az_south: Array, altitude: Array) -> Array:
    """Return cosine-weighted averages of residuals within 5 deg of points, shape (k,).

    The weight falls to zero at the edge of the circle; residuals beyond 0.01 deg
    are left out; NaN where fewer than three are in reach. The other turn of the
    cable is another place.
    """
    kept = ~left.large
    az, alt, value = left.az_south[kept], left.altitude[kept], left.value[kept]
    apart = az_south[:, None] - az
    distance = separation(az_south[:, None], altitude[:, None], az, alt)
    near = (distance < SMOOTHING_RADIUS) & (np.abs(apart) < np.pi)
    weight = np.where(near, np.cos(np.pi / 2 * distance / SMOOTHING_RADIUS), 0.0)
    total = weight.sum(axis=1)
    enough = near.sum(axis=1) >= _FEWEST
    return np.divide(weight @ value, total, out=np.full(len(total), np.nan), where=enough)


def write_figures(fit: Rt32Fit, folder: Path) -> list[Path]:
    """Draw figures 3, 4 and 5 into `folder`/figure-N.png and return the paths."""
    written = []
    for number, draw in ((3, vectors), (4, smooth), (5, distributions)):
        path = folder / f"figure-{number}.png"
        with write_whole(path, "wb") as file:
            draw(fit).savefig(file, format="png", dpi=130, metadata={"Software": None})
        written.append(path)
    return written


def vectors(fit: Rt32Fit) -> Figure:
    """Draw figure 3: every residual as a bar at its place in the sky."""
    figure, (upper, lower) = _page(fit, "Figure 3: residuals over the sky", (11, 10))
    across, along = residuals(fit)
    for axes, left, name in ((upper, across, "azimuth x cos H"), (lower, along, "altitude")):
        horizontal = left is across
        scale = (_BAR_AZ_DEG if horizontal else _BAR_ALT_DEG) / (_BAR_DEG * DEG)
        beyond = np.abs(left.value) > _REACH_DEG * DEG
        for rows, colour in ((~left.large, BLUE), (left.large & ~beyond, ORANGE)):
            length = left.value[rows] * scale
            _bars(axes, left.az_south[rows], left.altitude[rows], length, colour, horizontal)
        far = left.az_south[beyond] / DEG, left.altitude[beyond] / DEG
        axes.plot(*far, "x", ms=4, mew=0.8, color="#444444")
        _bar_of_scale(axes, _BAR_DEG, _BAR_AZ_DEG if horizontal else None, _BAR_ALT_DEG)
        _sky(axes)
        axes.set_title(
            f"{name} residuals: {len(left.value)} points, {left.large.sum()} beyond"
            f" {SMOOTHING_LARGEST / DEG:g} deg (orange), {beyond.sum()} of them beyond"
            f" {_REACH_DEG:g} deg (crosses)",
            fontsize=10,
        )
    return figure


def smooth(fit: Rt32Fit) -> Figure:
    """Draw figure 4: averages on a grid, upright for altitude, level for azimuth."""
    figure, (axes,) = _page(fit, "Figure 4: smoothed residuals", (11, 5.8), rows=1)
    across, along = residuals(fit)
    grid_az, grid_alt = np.meshgrid(np.arange(-270.0, 271.0, 10.0), np.arange(5.0, 90.0, 4.0))
    az, alt = grid_az.ravel() * DEG, grid_alt.ravel() * DEG
    for left, horizontal, colour in ((across, True, BLUE), (along, False, ORANGE)):
        scale = (_BAR_AZ_DEG if horizontal else _BAR_ALT_DEG) / (2 * _SMOOTH_BAR_DEG * DEG)
        value = smoothed(left, az, alt)
        drawn = np.isfinite(value)
        _bars(axes, az[drawn], alt[drawn], value[drawn] * scale, colour, horizontal, width=1.6)
    _bar_of_scale(axes, _SMOOTH_BAR_DEG, _BAR_AZ_DEG / 2, None)
    _bar_of_scale(axes, _SMOOTH_BAR_DEG, None, _BAR_ALT_DEG / 2, left=150)
    _sky(axes)
    axes.set_title(
        "averages within 5 deg: level bars azimuth x cos H, upright bars altitude", fontsize=10
    )
    return figure


def distributions(fit: Rt32Fit) -> Figure:
    """Draw figure 5: residuals along azimuth (left) and altitude (right)."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7.5), layout="constrained")
    panels = figure.subplots(2, 2, sharex="col", sharey=True)
    figure.suptitle(_title(fit, "Figure 5: distribution of residuals"), fontsize=12)
    for row, left, name in zip(
        panels, residuals(fit), ("azimuth x cos H", "altitude"), strict=True
    ):
        beyond = int((np.abs(left.value) > _REACH_DEG * DEG).sum())
        for axes, where in zip(row, (left.az_south, left.altitude), strict=True):
            axes.axhline(0, color=GREY, lw=0.8)
            for level in (-fit.level, fit.level):
                axes.axhline(level / DEG, color=RED, lw=0.8, ls="--")
            axes.plot(where / DEG, left.value / DEG, ".", ms=4, mew=0, alpha=0.6, color=BLUE)
            axes.set_ylim(-_REACH_DEG, _REACH_DEG)
        row[0].set_ylabel(f"{name} residual [deg]")
        row[1].set_title(f"{beyond} beyond the panel", fontsize=9, loc="right")
        row[0].set_title(f"dashed: the level, {fit.level / DEG:.3f} deg", fontsize=9, loc="left")
    panels[1, 0].set_xlabel("azimuth from south through west [deg]")
    panels[1, 0].set_xticks(np.arange(-270, 271, 90))
    panels[1, 1].set_xlabel("altitude [deg]")
    panels[1, 1].set_xlim(0, 90)
    return figure


def _page(
    fit: Rt32Fit, title: str, size: tuple[float, float], rows: int = 2
) -> tuple[Figure, NDArray[np.object_]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(_title(fit, title), fontsize=12)
    return figure, np.atleast_1d(figure.subplots(rows, 1, sharex=True))


def _title(fit: Rt32Fit, title: str) -> str:
    """Return the title, with a warning before it where no telescope measured the data."""
    made_up = "SIMULATED CAMPAIGN. " if "simulated" in fit.recordings.meta else ""
    return f"{made_up}{title}, {fit.recordings.file.stem}"


def _bars(
    axes: Axes,
    az_south: Array,
    altitude: Array,
    length: Array,
    colour: str,
    horizontal: bool,  # noqa: FBT001 - what `residuals` distinguishes
    width: float = 0.7,
) -> None:
    """Draw a bar from each place, `length` [deg of the axis] long, with a dot at its foot."""
    from matplotlib.collections import LineCollection

    foot = np.column_stack([az_south, altitude]) / DEG
    tip = foot + np.outer(length, [1.0, 0.0] if horizontal else [0.0, 1.0])
    axes.add_collection(
        LineCollection(list(np.stack([foot, tip], axis=1)), colors=colour, linewidths=width)
    )
    axes.plot(*foot.T, ".", ms=1.5 * width + 1, mew=0, color=colour)


def _bar_of_scale(
    axes: Axes, size_deg: float, across: float | None, up: float | None, left: float = 215.0
) -> None:
    """Draw the scale bar: level where `across` is given, upright otherwise."""
    tip = (left + across, 96.0) if across is not None else (left, 93.0 + (up or 0.0))
    axes.plot([left, tip[0]], [96.0 if across is not None else 93.0, tip[1]], color=RED, lw=2.5)
    axes.text(left - 5, 96.0, f"+{size_deg:g} deg", ha="right", va="center", fontsize=9, color=RED)


def _sky(axes: Axes) -> None:
    """Draw the jump's curve, and lay the axes out."""
    az = np.linspace(-270, 270, 541)
    curve = jump_altitude(az * DEG) / DEG
    shown = curve <= 90
    for branch in (az <= 0, az > 0):
        axes.plot(az[branch & shown], curve[branch & shown], color=RED, lw=1.5)
    axes.set_xlim(-280, 280)
    axes.set_ylim(0, 103)
    axes.set_xticks(np.arange(-270, 271, 45))
    axes.set_yticks(np.arange(0, 91, 15))
    axes.set_ylabel("altitude [deg]")
    axes.set_xlabel("azimuth from south through west [deg]")


def of_rt32(fit: Rt32Fit, honest: Array) -> tuple[Picture, Story]:
    """Return what the panels draw of a fit of p1..p12, and what the page says of it.

    `fit`: the fit; each parameter is a layer, linear about the solution.
    `honest`: standard errors by whole sessions [rad], shape (P,).
    """
    values = np.nan_to_num(fit.values)
    curves = list((fit.design.columns * values).T)
    before = fit.residual + sum(curves, np.zeros(len(fit.residual)))
    x, y = sides(fit.recordings, fit.stack, before, curves, fit.inside.astype(float))
    layers = tuple(Layer(_name(k)) for k in range(len(values)))
    titles = ("before the fit", "after the fit")
    picture = picture_of(fit.recordings, layers, x, y, titles, "after")
    return picture, _story(fit, honest, picture)


def _name(k: int) -> str:
    return f"p{k + 1} {PARAMETERS[k].name}" if k < len(PARAMETERS) else "step of the box offset"


def _story(fit: Rt32Fit, honest: Array, picture: Picture) -> Story:
    form = "exact" if fit.exact else "approximate"
    inside, level = int(fit.inside.sum()), fit.level / ARCSEC
    made_up = " The recordings are simulated." if "simulated" in fit.recordings.meta else ""
    correlation = np.nan_to_num(fit.correlation)
    names = tuple(f"p{k + 1}" if k < len(PARAMETERS) else "step" for k in range(len(fit.values)))
    rows = tuple(
        Row(_name(k), "", as_json(value / ARCSEC), as_json(honest[k] / ARCSEC), "arcsec")
        for k, value in enumerate(fit.values)
    )
    return Story(
        kind="fit",
        source=source_of(fit.recordings),
        model=f"rt32-{form}, {fit.method}",
        headline=f"The {form} form fits to {fit.rms / ARCSEC:.3g} arcsec.",
        lead=f"Rms of the {inside:,} of {len(fit.stack):,} offsets within {level:.3g} arcsec. "
        f"Errors are those between whole sessions.{made_up}",
        good=True,
        facts=(
            ("rms within the level", f"{fit.rms / ARCSEC:.3g}", "arcsec, both axes"),
            ("offsets within", f"{inside:,}", f"of {len(fit.stack):,}"),
            ("condition number", f"{fit.condition:.3g}", "columns of unit length"),
            ("recordings", f"{len(fit.recordings):,}", f"{fit.rounds} rounds of votes"),
        ),
        bars=bars_of(picture),
        rows=rows,
        correlation=(names, tuple(tuple(row) for row in correlation.tolist())),
        condition=fit.condition,
        outliers=off_by(fit.recordings, fit.stack, fit.residual, fit.inside),
    )
