"""One picture per finding: what it looks like, what is left, and how big it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array, handy
from pyport.columns import shown
from pyport.diagnosis.joint import rms
from pyport.diagnosis.naming.words import spoken
from pyport.effects.base import THE_HOUR
from pyport.effects.empirical import fields
from pyport.effects.empirical.drivers import unit_in_words
from pyport.effects.empirical.fields import Bumps
from pyport.mounts import ALTAZ
from pyport.plots import pictures

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pyport.diagnosis.diagnose import Diagnosis
    from pyport.diagnosis.naming.finding import Finding, Parameter
    from pyport.effects.base import Effect

#: Okabe and Ito's colours, which every eye can distinguish.
BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#999999"
#: Dots per inch of a picture that is looked at on a screen.
SCREEN_DPI = 110
#: Bins of the running median that shows what a cloud of points follows.
BINS = 12
#: Where panels stand, in shares of the picture. A layout that measures every label draws twice.
_MARGINS = {"left": 0.08, "right": 0.985, "top": 0.9, "hspace": 0.36, "wspace": 0.17}
#: Of a panel. A title whose height is not given is put above the labels after all are measured.
_TITLE: dict[str, Any] = {"fontsize": 10, "y": 1.0}
#: So many coefficients fit beside each other with their names, and so many with level ones.
MOST_BARS, MOST_LEVEL = 40, 8


def write_findings(diagnosis: Diagnosis, folder: Path) -> list[Path]:
    """Draw every finding into `folder`/finding-N-EFFECT.png and return the paths."""
    return [
        pictures.write(
            draw(diagnosis, finding), folder / f"finding-{n}-{finding.effect}.png", SCREEN_DPI
        )
        for n, finding in enumerate(diagnosis.findings, 1)
        if finding.curve is not None
    ]


def draw(diagnosis: Diagnosis, finding: Finding) -> Figure:
    """Draw a finding: residuals before and after it, and its coefficients or its held-out gain."""
    from matplotlib.figure import Figure

    parameters = comparable(finding.parameters)
    names = distinguishing(parameters, diagnosis.problem.recordings.at.mount.names)
    upright = MOST_LEVEL < len(names) <= MOST_BARS
    figure = Figure(figsize=(10, 6.4))
    bottom = 0.055 + 0.012 * max(map(len, names)) if upright else 0.085
    grid = figure.add_gridspec(2, 2, height_ratios=[1.25, 1], bottom=bottom, **_MARGINS)
    rows = _rows(diagnosis, finding)
    left = diagnosis.left(diagnosis.after)
    curve = np.zeros_like(left) if finding.curve is None else finding.curve
    unit, name = handy(rms(curve[rows] + left[rows]))
    label, values = _follows(diagnosis, finding, curve, rows)
    first = figure.add_subplot(grid[0, 0])
    second = figure.add_subplot(grid[0, 1], sharex=first, sharey=first)
    for axes, residual, title in ((first, curve + left, "before"), (second, left, "after")):
        _cloud(axes, diagnosis, finding, rows, values, residual / unit)
        axes.set_title(f"{title}: rms {rms(residual[rows]) / unit:.2f} {name}", **_TITLE)
        axes.set_xlabel(label)
    first.set_ylabel(f"offset that the model leaves [{name}]")
    reach = 1.15 * float(np.quantile(np.abs(curve + left)[rows], 0.985)) / unit
    first.set_ylim(-reach, reach)
    if finding.effect.startswith("scan") and "scan_direction" in diagnosis.problem.recordings.at:
        first.legend(fontsize=8, loc="upper left", ncols=2, framealpha=0.8)
    below = figure.add_subplot(grid[1, :])
    if 1 < len(names) <= MOST_BARS:
        _coefficients(below, parameters, names, 90 if upright else 0)
    else:
        _held_out(below, diagnosis, rows)
    figure.suptitle(_title(diagnosis, finding), fontsize=11)
    return figure


def _rows(diagnosis: Diagnosis, finding: Finding) -> NDArray[np.intp]:
    """Return the readings that a finding is about and that count."""
    counts = diagnosis.share > 0
    antennas = finding.where.subset.get("antenna")
    if antennas:
        counts &= np.isin(diagnosis.problem.antenna, antennas)
    axes = [axis == "el" for axis in finding.where.axes]
    return np.flatnonzero(counts & np.isin(diagnosis.problem.stack.is_y, axes))


def _follows(
    diagnosis: Diagnosis, finding: Finding, curve: Array, rows: NDArray[np.intp]
) -> tuple[str, Array]:
    """Return the column that drives the effect, or that it follows best: label and values (m,)."""
    at, row = diagnosis.problem.recordings.at, diagnosis.problem.stack.row
    bumps = _bumps(diagnosis, finding)
    if (within := fields.within_period(bumps, at)) is not None:
        where = finding.variant.partition(": ")[2]
        return f"{where}: how far into it [{within[1]}]", within[0][row]
    driver = _driver(diagnosis, finding)
    choices = {"el": at.el, "az": at.az}
    more = [name for name in ("hour_angle", "time", driver) if name in at]
    choices |= {name: np.asarray(at.column(name), float) for name in more}
    choices = {name: one for name, one in choices.items() if np.isfinite(one[row][rows]).all()}
    best, share = "el", -1.0
    for name, values in choices.items():
        explained = _explained(values[row][rows], curve[rows])
        if explained > share + 0.02:
            best, share = name, explained
    if driver in choices:
        best = driver
    if best == "time":
        return "time since the first recording [h]", (
            choices[best][row] - np.min(choices[best])
        ) / 3600
    words, unit, scale = shown(best)
    return f"{words} [{unit}]" if unit else words, choices[best][row] / scale


def _bumps(diagnosis: Diagnosis, finding: Finding) -> Bumps:
    """Return what a field is made of; nothing for an effect with a name."""
    effect = _effect(diagnosis, finding)
    found: Bumps = {} if effect is None else effect.member.get("bumps", {})
    return found


def _effect(diagnosis: Diagnosis, finding: Finding) -> Effect | None:
    """Return the effect that a finding is of, None without a place in the joint fit."""
    if finding.choice is None:
        return None
    return diagnosis.after.choices[finding.choice].candidate.effect


def _driver(diagnosis: Diagnosis, finding: Finding) -> str:
    """Return the column that a finding is to be seen against by its physics; "" where none is."""
    if finding.effect.startswith("scan"):
        return "hour_angle"
    effect = _effect(diagnosis, finding)
    if effect is None:
        return ""
    return "time" if effect.changes_with or effect.driver == THE_HOUR else effect.driver or ""


def _explained(values: Array, curve: Array) -> float:
    """Return the share of a curve's variance that bins of a column explain."""
    edges = np.quantile(values, np.linspace(0, 1, BINS + 1)[1:-1])
    bins = np.searchsorted(edges, values)
    count = np.maximum(np.bincount(bins, minlength=BINS), 1)
    mean = np.bincount(bins, curve, minlength=BINS) / count
    total = float(np.var(curve))
    return 1 - float(np.mean((curve - mean[bins]) ** 2)) / total if total > 0 else 0.0


def _cloud(
    axes: Axes, diagnosis: Diagnosis, finding: Finding, rows: NDArray[np.intp], x: Array, y: Array
) -> None:
    """Draw residuals, by direction of the scan where the effect is one of scanning."""
    at = diagnosis.problem.recordings.at
    axes.axhline(0, color=GREY, lw=0.8)
    groups: list[tuple[NDArray[np.intp], str, str | None]] = [(rows, BLUE, None)]
    if finding.effect.startswith("scan") and "scan_direction" in at:
        direction = np.asarray(at.column("scan_direction"))[diagnosis.problem.stack.row[rows]]
        groups = [(rows[direction > 0], BLUE, "forward"), (rows[direction < 0], ORANGE, "reverse")]
    for some, colour, label in groups:
        axes.plot(x[some], y[some], ".", ms=3.5, alpha=0.45, color=colour, mew=0, label=label)
        axes.plot(*running_median(x[some], y[some], BINS, 2), "-", lw=1.8, color=colour)
    axes.tick_params(labelsize=9)


def running_median(x: Array, y: Array, bins: int, least: int) -> tuple[Array, Array]:
    """Return the median in bins of equal count, none where they hold less than `least` each."""
    if len(x) < least * bins:
        return np.zeros(0), np.zeros(0)
    parts = np.array_split(np.argsort(x, kind="stable"), bins)
    return np.array([x[p].mean() for p in parts]), np.array([np.median(y[p]) for p in parts])


def comparable(parameters: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
    """Return the coefficients that stand on one axis: of the unit that most of them have."""
    units = [one.unit for one in parameters]
    return tuple(one for one in parameters if one.unit == max(units, key=units.count))


def distinguishing(
    parameters: tuple[Parameter, ...], axes: tuple[str, str] = ALTAZ.names
) -> list[str]:
    """Return what distinguishes coefficients: their antennas or sessions, or else their names.

    `axes` is what the mount calls its axes.
    """
    owners = [one.name.partition("[")[2].rstrip("]") for one in parameters]
    if all(owners) and len(set(owners)) == len(owners):
        return owners
    return [spoken(one.name.partition("[")[0], axes) for one in parameters]


def _coefficients(
    axes: Axes, parameters: tuple[Parameter, ...], names: list[str], turned: int
) -> None:
    places = np.arange(len(parameters))
    unit = parameters[0].unit
    size = np.abs([p.value for p in parameters]).max()
    scale, name = 1.0, unit_in_words(unit)
    if unit == "arcsec":
        radians, name = handy(float(size) * ARCSEC)
        scale = radians / ARCSEC
    axes.axhline(0, color=GREY, lw=0.8)
    axes.errorbar(
        places,
        [p.value / scale for p in parameters],
        [p.sigma / scale for p in parameters],
        fmt="o",
        ms=4,
        color=BLUE,
        ecolor=GREY,
        capsize=2,
    )
    axes.set_xticks(places, names, rotation=turned, fontsize=8)
    axes.set_xlim(-0.6, len(places) - 0.4)
    kinds = {one.name.partition("[")[0].replace("_", " ") for one in parameters}
    axes.set_ylabel(f"{kinds.pop() if len(kinds) == 1 else 'coefficient'} [{name}]", fontsize=9)
    axes.set_title("coefficients with one-sigma errors", **_TITLE)


def _held_out(axes: Axes, diagnosis: Diagnosis, rows: NDArray[np.intp]) -> None:
    """Draw how predictions of unseen readings miss, before and after."""
    unit, name = handy(rms(diagnosis.left(diagnosis.before)[rows]))
    both = rows[diagnosis.unseen.counted[rows]]
    if len(both) == 0:
        axes.set_axis_off()
        return
    reach = float(np.quantile(np.abs(diagnosis.unseen.before[both]), 0.99)) / unit
    bins = np.linspace(-reach, reach, 41).tolist()
    for values, colour, label in (
        (diagnosis.unseen.before[both], GREY, "before"),
        (diagnosis.unseen.after[both], BLUE, "after"),
    ):
        text = f"{label}: rms {rms(values) / unit:.2f} {name}"
        axes.hist(values / unit, bins, histtype="step", lw=1.8, color=colour, label=text)
    axes.set_xlabel(f"miss of readings that the fit had not seen [{name}]", fontsize=9)
    axes.set_ylabel("readings", fontsize=9)
    axes.legend(fontsize=9)


def _title(diagnosis: Diagnosis, finding: Finding) -> str:
    variant = f" ({finding.variant})" if finding.variant else ""
    file = diagnosis.problem.recordings.file.stem
    model = diagnosis.problem.model.name
    return f"{file}: {finding.effect}{variant}, {finding.verdict}, beside {model}"
