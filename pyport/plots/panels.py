"""Panels for print: the sky, residuals against columns, distributions, what the search tried."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.page.payload import reach, stretches
from pyport.page.picture import Column, Picture, Side
from pyport.page.story import Story
from pyport.plots import style
from pyport.plots.findings import running_median
from pyport.plots.style import AFTER, BEFORE, GREY, REGION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

#: Bins of equal count whose medians are drawn, and bins of a distribution.
BINS, CELLS = 14, 48
#: A vector of the 90th percentile is this share of the plot long; none is so many times longer.
LONG, LONGEST = 0.12, 2.5
#: Vectors after are drawn on a scale of their own when those before are so many times longer.
APART = 8.0

Draw = Callable[[], "Figure"]


def panels(picture: Picture, story: Story) -> dict[str, Draw]:
    """Return a function for each panel that draws it, by the panel's name."""
    found: dict[str, Draw] = {
        "sky": partial(sky, picture),
        "azel": partial(azel, picture),
    }
    for column in picture.columns:
        found[f"against-{column.name}"] = partial(against, picture, column)
    if picture.time is not None and np.isfinite(picture.time).any():
        found["against-time"] = partial(against_time, picture)
    found["distributions"] = partial(distributions, picture)
    if story.bars:
        found["rms"] = partial(style.bars, story)
    if len(story.correlation[0]) > 1:
        found["correlations"] = partial(style.heat, story)
    if story.turns:
        found["candidates"] = partial(style.candidates, story)
    return {_plain(name): style.in_style(draw) for name, draw in found.items()}


def _plain(name: str) -> str:
    """Return a panel's name that is a file's name wherever columns get theirs from."""
    return re.sub(r"[^\w-]+", "_", name)


def _kinds(picture: Picture) -> list[tuple[str, str]]:
    kinds = [("before", BEFORE), ("after", AFTER)]
    return kinds if picture.layers else kinds[1:]


def _titles(picture: Picture) -> dict[str, str]:
    names = picture.names if picture.layers else ("residuals", "residuals")
    return dict(zip(("before", "after"), names, strict=True))


def sky(picture: Picture) -> Figure:
    """Draw residual vectors around the zenith, before and after."""
    kinds = _kinds(picture)
    figure = style.figure(3.5 * len(kinds), 3.7)
    for n, (name, colour) in enumerate(kinds, 1):
        axes: PolarAxes = figure.add_subplot(1, len(kinds), n, projection="polar")  # type: ignore[assignment]
        axes.set_theta_zero_location("N")
        axes.set_theta_direction(-1)
        axes.set_rlim(0, 90)
        axes.set_rticks([30, 60], labels=["60°", "30°"])
        axes.set_rlabel_position(22.5)
        axes.set_xticks(np.arange(0, 360, 45) * DEG, ["N", "", "E", "", "S", "", "W", ""])
        az, el = (picture.columns[k].values.astype(float) * DEG for k in (0, 1))
        across, along = _vectors(picture, name)
        turned = (
            across * np.cos(az) + along * -np.sin(az),
            -across * np.sin(az) + along * -np.cos(az),
        )
        key = _arrows(axes, (az, 90 - el / DEG), turned, colour, picture, name)
        axes.set_title(f"{_titles(picture)[name]} ({key})", fontsize=9)
    return figure


def azel(picture: Picture) -> Figure:
    """Draw residual vectors over azimuth and elevation, before and after."""
    kinds = _kinds(picture)
    figure = style.figure(7.0, 2.4 * len(kinds))
    for n, (name, colour) in enumerate(kinds, 1):
        axes = figure.add_subplot(len(kinds), 1, n)
        az, el = (picture.columns[k].values.astype(float) for k in (0, 1))
        key = _arrows(axes, (az, el), _vectors(picture, name), colour, picture, name)
        axes.set_title(f"{_titles(picture)[name]} ({key})", fontsize=9)
        axes.set_ylabel("elevation [deg]")
        axes.set_xlabel("azimuth [deg]")
        axes.margins(0.06, 0.15)
    return figure


def _vectors(picture: Picture, name: str) -> tuple[Array, Array]:
    """Return residuals across and along elevation in the picture's unit, 0 for none."""
    scale = picture.unit[0]
    across, along = picture.on_sky(name)
    return across / scale, along / scale


def _typical(picture: Picture, name: str) -> float:
    """Return a long vector's length; both kinds share one unless it were too short to see."""
    sizes = {
        kind: float(np.quantile(np.hypot(*_vectors(picture, kind))[_counted(picture)], 0.9)) or 1.0
        for kind, _ in _kinds(picture)
    }
    largest = max(sizes.values())
    return sizes[name] if largest > APART * sizes[name] else largest


def _counted(picture: Picture) -> NDArray[np.bool_]:
    """Tell which recordings count on every axis that was measured in them."""
    lost = [np.isfinite(side.before) & ~(side.share > 0) for side in (picture.x, picture.y)]
    counted = ~(lost[0] | lost[1])
    return counted if counted.any() else np.ones(len(counted), bool)


def _arrows(
    axes: Axes,
    feet: tuple[Array, Array],
    vectors: tuple[Array, Array],
    colour: str,
    picture: Picture,
    name: str,
) -> str:
    """Draw arrows whose length is a share of the plot, and return what the scale is."""
    full = style.nice(_typical(picture, name))
    # One outlier must not cross the plot.
    short = np.minimum(1.0, LONGEST * full / np.maximum(np.hypot(*vectors), 1e-300))
    across, along = (one * short for one in vectors)
    axes.quiver(
        *feet,
        across,
        along,
        color=colour,
        scale=full / LONG,
        scale_units="width",
        units="width",
        width=0.0022,
        headwidth=3,
        headlength=3.5,
        headaxislength=3,
    )
    axes.plot(*feet, ".", ms=1.6, color=colour, mew=0)
    return f"{LONG * 100:.0f} % of the width is {full:g} {picture.unit[1]}"


def against(picture: Picture, column: Column) -> Figure:
    """Draw residuals of both axes against a column, medians in bins beside them."""
    labels = column.values.dtype.kind == "U"
    figure, rows = _stack(picture, style.figure if labels else style.framed)
    if labels:
        names, codes = np.unique(column.values, return_inverse=True)
        spread = (np.arange(len(codes)) * 0.618034 % 1 - 0.5) * 0.7
        x = codes + spread
    else:
        names, x = np.array([]), column.values.astype(float)
    for axes, (name, side) in rows:
        for low, high, _ in column.regions:
            axes.axvspan(low, high, color=REGION, alpha=0.25, lw=0)
        _clouds(axes, picture, x, name, side, lined=not labels)
    bottom = rows[-1][0]
    if labels:
        words = [str(one) for one in names]
        crowded = sum(map(len, words)) > 60
        bottom.set_xticks(np.arange(len(names)), words, rotation=60 if crowded else 0)
    bottom.set_xlabel(column.title)
    return figure


def against_time(picture: Picture) -> Figure:
    """Draw residuals against time, the gaps between campaigns cut out."""
    figure, rows = _stack(picture, style.figure)
    time = picture.time if picture.time is not None else np.zeros(0)
    parts = stretches(time)
    total = sum(b - a for a, b in parts) or 1.0
    gap = 0.02 * total if len(parts) > 1 else 0.0
    x = np.full(len(time), np.nan)
    marks, start = [], 0.0
    for a, b in parts:
        # However short, a stretch has a width to be seen in.
        width = max(b - a, 0.02 * total)
        inside = (time >= a) & (time <= b)
        x[inside] = start + (time[inside] - a + (width - (b - a)) / 2)
        marks.append((start, str(np.datetime64(int(a), "s"))[:10]))
        start += width + gap
    for axes, (name, side) in rows:
        for place, _ in marks[1:]:
            axes.axvline(place - gap / 2, color=GREY, lw=0.6, ls=":")
        _clouds(axes, picture, x, name, side, lined=True)
    bottom = rows[-1][0]
    if len(parts) == 1:
        first = parts[0][0]
        bottom.xaxis.set_major_formatter(
            lambda value, _: str(np.datetime64(int(first + value), "s"))[11:16]
        )
        bottom.xaxis.set_major_locator(style.hours(first, total))
        bottom.set_xlabel(f"UTC from {marks[0][1]}")
    else:
        every = max(1, len(marks) // 6)
        chosen = marks[::every]
        bottom.set_xticks([m[0] for m in chosen], [m[1] for m in chosen], ha="left")
        bottom.set_xlabel("date, UTC; gaps are cut out")
    return figure


def _stack(
    picture: Picture, empty: Callable[[float, float], Figure]
) -> tuple[Figure, list[tuple[Axes, tuple[str, Side]]]]:
    """Return a figure with a row for each measured axis."""
    measured = picture.sides()
    figure = empty(7.0, 0.7 + 1.9 * len(measured))
    rows = figure.subplots(len(measured), 1, sharex=True, squeeze=False)[:, 0]
    return figure, list(zip(rows, measured, strict=True))


def _clouds(axes: Axes, picture: Picture, x: Array, name: str, side: Side, *, lined: bool) -> None:
    """Draw residuals before and after, with their medians."""
    scale, unit = picture.unit
    axes.axhline(0, color=GREY, lw=0.8)
    for kind, colour in _kinds(picture):
        y = getattr(side, kind) / scale
        there = np.isfinite(x) & np.isfinite(y)
        label = f"{_titles(picture)[kind]}, rms {side.rms(getattr(side, kind)) / scale:.3g}"
        size, alpha = (4.0, 0.7) if there.sum() < 400 else (2.4, 0.45)
        axes.plot(x[there], y[there], ".", ms=size, alpha=alpha, mew=0, color=colour, label=label)
        if lined:
            middle = running_median(x[there], y[there], BINS, 3)
            dashes = "--" if kind == "before" and picture.layers else "-"
            axes.plot(*middle, dashes, color=colour, lw=1.4)
    far = reach(side, side.before, side.after) / scale
    axes.set_ylim(-far, far)
    axes.set_ylabel(f"{name}\n[{unit}]")
    axes.legend(fontsize=7, loc="upper right", ncols=2, framealpha=0.85, markerscale=2.5)


def distributions(picture: Picture) -> Figure:
    """Draw how residuals are distributed before and after, beside the noise."""
    measured = picture.sides()
    figure = style.figure(3.5 * len(measured), 2.6)
    for axes, (name, side) in zip(
        figure.subplots(1, len(measured), squeeze=False)[0], measured, strict=True
    ):
        _distribution(axes, picture, name, side)
    return figure


def _distribution(axes: Axes, picture: Picture, name: str, side: Side) -> None:
    scale, unit = picture.unit
    far = reach(side, side.before, side.after) / scale
    edges = np.linspace(-far, far, CELLS + 1)
    counted = (side.share > 0) & np.isfinite(side.before)
    for kind, colour in _kinds(picture):
        values = getattr(side, kind)[counted] / scale
        axes.hist(values, edges.tolist(), histtype="stepfilled", color=colour, alpha=0.16, lw=0)
        axes.hist(
            values,
            edges.tolist(),
            histtype="step",
            color=colour,
            lw=1.2,
            label=f"{_titles(picture)[kind]}, rms {side.rms(getattr(side, kind)) / scale:.3g}",
        )
    if side.floor:
        sigma = side.floor / scale
        x = np.linspace(-far, far, 241)
        expected = counted.sum() * (edges[1] - edges[0]) / (sigma * np.sqrt(2 * np.pi))
        axes.plot(
            x,
            expected * np.exp(-0.5 * (x / sigma) ** 2),
            "--",
            color="black",
            lw=1,
            label=f"noise alone, {sigma:.3g}",
        )
    axes.set_xlabel(f"{name} [{unit}]")
    axes.set_ylabel("offsets")
    axes.legend(fontsize=7)
