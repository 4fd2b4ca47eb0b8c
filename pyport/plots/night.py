"""A night as a watch saw it, for print: the live page's panels in one figure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from pyport.plots import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

#: A residual vector of the 90 % quantile is drawn so long [deg of elevation].
LONG_DEG = 14.0
#: No more evidence than so many times the alarm's is drawn.
SHOWN = 3.0


def night(live: Mapping[str, Any]) -> Figure:
    """Draw what a watch knows of a night.

    `live`: as `pyport.watch.live.live` returns it.
    """
    figure = style.figure(9.0, 5.4)
    grid = figure.add_gridspec(3, 2, width_ratios=(5, 6))
    _sky(cast("PolarAxes", figure.add_subplot(grid[:, 0], projection="polar")), live)
    series = [figure.add_subplot(grid[k, 1]) for k in range(3)]
    times, label = _times(live)
    across, along = live["axes"]
    _lines(series[0], times, live, {"xel": across, "el": along}, "zero [arcsec]")
    _lines(
        series[1], times, live, {"north": "toward north", "east": "toward east"}, "tilt [arcsec]"
    )
    _evidence(series[2], times, live)
    series[2].set_xlabel(label)
    for alarm in live["alarms"]:
        figure.suptitle(
            f"alarm {alarm['number']}, {alarm['state']}: {alarm['sentence']}", wrap=True
        )
    return figure


def _times(live: Mapping[str, Any]) -> tuple[NDArray[Any], str]:
    times = np.array([row[0] for row in live["recent"]])
    if not live["timed"]:
        return times, "pointing"
    return times.astype("datetime64[s]"), "time (UTC)"


def _sky(axes: PolarAxes, live: Mapping[str, Any]) -> None:
    """Draw the offsets as vectors where they were measured, the last ten in another colour."""
    rows = np.array([row[1:5] for row in live["recent"]], float)
    az, el = np.radians(rows[:, 0]), rows[:, 1]
    x, y = np.nan_to_num(rows[:, 2]), np.nan_to_num(rows[:, 3])
    scale = LONG_DEG / max(float(np.quantile(np.hypot(x, y), 0.9)), 1e-9)
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_rlim(0, 90)
    axes.set_yticks([30, 60], ["60", "30"])
    axes.set_xticks(np.radians([0, 90, 180, 270]), ["N", "E", "S", "W"])
    east, north = (90 - el) * np.sin(az), (90 - el) * np.cos(az)
    # up is toward the zenith, across toward growing azimuth
    east_to = east + scale * (x * np.cos(az) - y * np.sin(az))
    north_to = north - scale * (x * np.sin(az) + y * np.cos(az))
    turn, far = np.arctan2(east, north), np.arctan2(east_to, north_to)
    for n in range(len(rows)):
        colour = style.BEFORE if n >= len(rows) - 10 else style.AFTER
        ends = np.hypot([east[n], east_to[n]], [north[n], north_to[n]])
        axes.plot([turn[n], far[n]], ends, color=colour, lw=1.2)
    axes.plot(turn, np.hypot(east, north), ".", ms=2.5, color="black")
    axes.set_title(f"offsets; a bar of {LONG_DEG:.0f} deg: {LONG_DEG / scale:.1f} arcsec")


def _lines(
    axes: Axes, times: NDArray[Any], live: Mapping[str, Any], names: Mapping[str, str], label: str
) -> None:
    for (name, called), colour in zip(names.items(), (style.AFTER, style.BEFORE), strict=True):
        known = [n for n, one in enumerate(live["running"]) if one[name] is not None]
        if not known:
            continue
        value, sigma = np.array([live["running"][n][name] for n in known]).T
        axes.plot(times[known], value, color=colour, lw=1.2, label=called)
        axes.fill_between(
            times[known], value - 2 * sigma, value + 2 * sigma, color=colour, alpha=0.2, lw=0
        )
    axes.axhline(0, color=style.GREY, lw=0.5)
    axes.set_ylabel(label)
    axes.legend(fontsize=7, loc="upper left")
    axes.tick_params(labelbottom=False)


def _evidence(axes: Axes, times: NDArray[Any], live: Mapping[str, Any]) -> None:
    value = np.array([np.nan if row[7] is None else row[7] for row in live["recent"]])
    if live["timed"]:
        from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

        locator = AutoDateLocator()
        axes.xaxis.set_major_locator(locator)
        axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))
    axes.plot(times, np.minimum(value, SHOWN * live["threshold"]), color=style.AFTER, lw=1.2)
    axes.axhline(live["threshold"], color=style.BEFORE, ls="--", lw=0.8)
    axes.annotate("alarm", (times[0], live["threshold"]), fontsize=7, va="bottom")
    axes.set_ylabel("evidence [decades]")
