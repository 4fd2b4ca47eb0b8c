"""The GMRT paper's figures: elevation offsets against hour angle, an antenna a panel.

The fewer hours a curve is fitted over, the more its a, b and d trade against
each other: the sigmas of a, of b and of d stand to each other as the hours have
it, whatever the noise. Table 18 prints them for every antenna.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pyport.angles import ARCMIN, HOUR, Array
from pyport.effects import Circumstances
from pyport.files import write_whole
from pyport.formats.models import load
from pyport.recordings import sky
from pyport.studies.gmrt.curves import Cosine, Curve, Track, columns, curve, line
from pyport.studies.gmrt.published import ANTENNAS, Wave, table_18

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


#: Fewer curves than this tell no hours.
_ENOUGH = 5

#: Hour angles that a day may have ended at are tried so close together [rad].
_STEP = 0.1 * HOUR


@dataclass(frozen=True)
class Hours:
    """The hour angles [rad] of one day's scans."""

    left: Array  #: that print has left, of any antenna, in order
    ended: float  #: where the paper's scans ended by the sigmas of all its curves
    #: Where they ended by each curve alone: between these for two in three.
    middle: tuple[float, float]
    #: Antenna -> of a scan about the paper's curve [rad], by that curve's sigmas.
    scatter: dict[str, float]

    @property
    def scanned(self) -> Array:
        """Return the hour angles that the paper fitted: what is left, and as closely on."""
        return until(self.left, self.ended)


def until(left: Array, end: float) -> Array:
    """Return hour angles and on from them, as far apart in the mean, until `end` [rad]."""
    step = float(np.diff(left).mean())
    return np.concatenate([left, np.arange(left[-1] + step, end + step / 2, step)])


def hours(left: Array, waves: Sequence[Wave], dec: float, latitude: float) -> Hours | None:
    """Return the hours of one day, None where its curves are too few to tell.

    `left`: hour angles of the scans that print has left, in order [rad].
    `waves`: the paper's curves of that day.
    `dec`, `latitude`: of the source, and of the site [rad]: it is not scanned once it has set.
    """
    if len(waves) < _ENOUGH or len(left) < _ENOUGH:
        return None
    sets = float(sky.hour_angle_at(np.zeros(1), dec, latitude)[0])
    ends = np.arange(left[-1], min(sets, np.pi) if np.isfinite(sets) else np.pi, _STEP)
    # log of what the sigmas of a, b and b d are times the scatter, (ends, waves, 3)
    printed = np.log([(w.sigma_a, w.sigma_b, abs(w.b) * w.sigma_d) for w in waves])
    foretold = np.log([[_sigmas(until(left, end), wave) for wave in waves] for end in ends])
    scatter = printed - foretold
    misfit = np.abs(scatter - scatter.mean(axis=2, keepdims=True)).sum(axis=2)
    best = int(misfit.sum(axis=1).argmin())
    low, high = np.quantile(ends[misfit.argmin(axis=0)], [1 / 6, 5 / 6])
    each = np.exp(scatter[best].mean(axis=1))
    return Hours(
        left,
        float(ends[best]),
        (float(low), float(high)),
        {wave.antenna: float(one) for wave, one in zip(waves, each, strict=True)},
    )


def _sigmas(hour_angle: Array, wave: Wave) -> Array:
    """Return the sigmas of a, b and b d of a curve fitted to one offset a scan of unit scatter."""
    design = columns(hour_angle)
    inverse = np.linalg.inv(design.T @ design)
    cos, sin = np.cos(wave.d), np.sin(wave.d)
    turn = np.array([[1, 0, 0], [0, cos, -sin], [0, -sin, -cos]])
    sigmas: Array = np.sqrt(np.diag(turn @ inverse @ turn.T))
    return sigmas


#: So many stretches of scans are left out in turn.
_STRETCHES = 8


def continued(
    track: Track, scanned: Array, dec: float, latitude: float
) -> tuple[Cosine, Cosine] | None:
    """Return the cosine that best fits a track gone on, with two covariances.

    None where it would be less sure than the offsets that are left are different.

    `track`: the scans that are left.
    `scanned`: hour angles of all scans [rad], those that are lost included.
    `dec`, `latitude`: of the source, and of the site [rad].
    Returns `formal`, `stretches`: one curve: its covariance from the scatter of single scans, and
      from leaving out stretches of scans in turn (a jackknife), which errors that last for several
      scans do not mislead.
    """
    left = _classical(track.hour_angle, dec, latitude)
    best = np.linalg.pinv(columns(scanned)) @ _classical(scanned, dec, latitude)
    design = np.concatenate([left, track.direction[:, None]], axis=1)
    fit = line(design, track.offset)
    size = left.shape[1]
    value = best @ fit.value[:size]
    formal = Cosine(value, best @ fit.covariance[:size, :size] @ best.T)
    if np.sqrt(np.mean(formal.sigma(scanned) ** 2)) > np.ptp(track.offset):
        return None
    root = np.sqrt(fit.weight)
    without = []
    for stretch in np.array_split(np.arange(len(track)), min(_STRETCHES, len(track))):
        kept = np.delete(root, stretch)
        rows = np.delete(design, stretch, axis=0) * kept[:, None]
        wanted = np.delete(track.offset, stretch) * kept
        without.append(best @ np.linalg.lstsq(rows, wanted, rcond=None)[0][:size])
    apart = np.array(without) - np.mean(without, axis=0)
    share = (len(without) - 1) / len(without)
    return formal, Cosine(value, share * apart.T @ apart)


def _classical(hour_angle: Array, dec: float, latitude: float) -> Array:
    """Return the classical model's columns along elevation at hour angles, shape (n, 4)."""
    at = Circumstances(*sky.horizon(hour_angle, np.full(len(hour_angle), dec), latitude))
    along = np.concatenate([term.effect.columns(at)[1] for term in load("altaz").terms], axis=1)
    return along[:, np.any(along != 0, axis=0)]


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
