"""The array that a steering system reads: its grid and its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array, wrap
from pyport.errors import BadInput
from pyport.files import write_whole

#: Rows of the largest table: half a gigabyte of text, and two of memory.
MOST_ROWS = 10_000_000


@dataclass(frozen=True)
class Grid:
    """Azimuths and zenith distances of a table, in degrees, ascending by equal steps.

    Azimuth as the telescope's own counter has it, unwrapped: -100 and 260 are
    different columns. Zenith distances below zero point in plunge.
    """

    az_deg: Array
    zd_deg: Array

    def __post_init__(self) -> None:
        """Refuse what no table holds."""
        if len(self) > MOST_ROWS:
            raise BadInput(f"a grid of {len(self):,} rows, expected at most {MOST_ROWS:,}")

    def __len__(self) -> int:
        """Return the number of rows of the table."""
        return len(self.az_deg) * len(self.zd_deg)

    def points_deg(self) -> tuple[Array, Array]:
        """Return azimuth and zenith distance of every point [deg], shape (azimuths, zenith)."""
        az_deg, zd_deg = np.meshgrid(self.az_deg, self.zd_deg, indexing="ij")
        return az_deg, zd_deg

    def steps_deg(self) -> tuple[float, float]:
        """Return the steps in azimuth and in zenith distance [deg]."""
        return _step(self.az_deg), _step(self.zd_deg)

    def check(self, file: str | Path) -> None:
        """Refuse steps that differ: look-ups count on them. Raises `BadInput` about a file."""
        for what, values in (("azimuths", self.az_deg), ("zenith distances", self.zd_deg)):
            if not np.allclose(np.diff(values), _step(values), rtol=0, atol=1e-9):
                raise BadInput(
                    f"its {what} do not ascend by equal steps, expected a grid that does", file
                )


def _step(values: Array) -> float:
    return float(values[-1] - values[0]) / (len(values) - 1) if len(values) > 1 else 1.0


def span(text: str) -> Array:
    """Return the values that FIRST:LAST:STEP stands for [deg], both ends included.

    Raises `BadInput`: the text is not three numbers, or the steps do not lead from first to last.
    """
    try:
        first, last, step = (float(word) for word in text.split(":"))
        count = round((last - first) / step) + 1
    except (ValueError, ZeroDivisionError, OverflowError):
        raise BadInput(f"expected FIRST:LAST:STEP in degrees, found {text!r}") from None
    if count > MOST_ROWS:
        raise BadInput(f"{text!r} has {count:,} steps, expected at most {MOST_ROWS:,} rows")
    values = np.asarray(first + step * np.arange(max(count, 0)), dtype=float)
    if count < 2 or step < 0 or abs(values[-1] - last) > 1e-9 * abs(last - first):
        raise BadInput(f"{text!r}: steps of {step:g} deg do not lead from {first:g} to {last:g}")
    return values


#: What the RT32's steering reads: 541 x 95 points, one degree apart.
RT32_GRID = Grid(np.arange(-270.0, 271.0), np.arange(-5.0, 90.0))

#: The last decimal of the published table: offsets are whole multiples of 1e-7 deg.
UNITS_PER_DEG = 1e7


@dataclass(frozen=True)
class Table:
    """Offsets on a grid, in degrees, to be added to the true coordinates.

    Attributes
    ----------
    grid
        n azimuths and m zenith distances.
    d_az_deg, d_zd_deg
        Offset of azimuth (the coordinate's) and of zenith distance, shape (n, m).
    model, refraction, reading
        What they were computed from and how, by name; "" where a file does not tell.
    """

    grid: Grid
    d_az_deg: Array
    d_zd_deg: Array
    model: str = ""
    refraction: str = ""
    reading: str = ""

    @cached_property
    def side_by_side(self) -> Array:
        """Return both offsets, those of one direction together in memory, shape (n, m, 2)."""
        return np.stack([self.d_az_deg, self.d_zd_deg], axis=2)

    def units(self) -> NDArray[np.int64]:
        """Return both offsets in whole units of 1e-7 deg, shape (2, n, m).

        Every file is written from these, so that all of them hold the same digits.
        """
        with np.errstate(invalid="ignore"):  # what is no number is refused where it is written
            units = np.rint(np.stack([self.d_az_deg, self.d_zd_deg]) * UNITS_PER_DEG)
            return units.astype(np.int64)


@dataclass(frozen=True)
class Difference:
    """New minus old on the points that both tables have.

    Attributes
    ----------
    grid
        The common points, n azimuths and m zenith distances.
    az_deg, zd_deg
        Difference of the azimuth and of the zenith-distance offsets [deg], shape (n, m);
        the azimuth's of the coordinate, as tables hold it.
    """

    grid: Grid
    az_deg: Array
    zd_deg: Array

    @property
    def on_sky_deg(self) -> Array:
        """Return the azimuth differences on the sky, times sin z [deg], shape (n, m)."""
        return self.az_deg * np.sin(self.grid.zd_deg * DEG)


def compare(new: Table, old: Table) -> Difference:
    """Return new minus old.

    Raises
    ------
    BadInput
        The tables have no azimuth or no zenith distance in common.
    """
    az_deg, new_i, old_i = np.intersect1d(new.grid.az_deg, old.grid.az_deg, return_indices=True)
    zd_deg, new_j, old_j = np.intersect1d(new.grid.zd_deg, old.grid.zd_deg, return_indices=True)
    if not (len(az_deg) and len(zd_deg)):
        raise BadInput("the two tables have no point in common")
    ours, theirs = np.ix_(new_i, new_j), np.ix_(old_i, old_j)
    turn = wrap((new.d_az_deg[ours] - old.d_az_deg[theirs]) * DEG) / DEG
    return Difference(
        Grid(az_deg, zd_deg),
        turn,
        new.d_zd_deg[ours] - old.d_zd_deg[theirs],
    )


def describe(difference: Difference, least_deg: float = 0.5e-7) -> list[str]:
    """Return lines of text: what differs by more than `least_deg`, where most, which way."""
    az, zd = difference.grid.points_deg()
    lines = [f"{len(difference.grid)} points in common"]
    for name, values in (
        ("azimuth", difference.az_deg),
        ("azimuth on the sky", difference.on_sky_deg),
        ("zenith distance", difference.zd_deg),
    ):
        differs = np.abs(values) > least_deg
        if not differs.any():
            lines.append(f"{name}: equal everywhere")
            continue
        worst = np.unravel_index(np.argmax(np.abs(values)), values.shape)
        higher = np.mean(values[differs] > 0)
        lines.append(
            f"{name}: {int(differs.sum())} differ, {100 * higher:.0f} % upward, "
            f"mean {1e3 * np.mean(values):+.4f}, rms {1e3 * np.sqrt(np.mean(values**2)):.4f}, "
            f"most {1e3 * values[worst]:+.4f} mdeg at azimuth {az[worst]:g}, "
            f"zenith distance {zd[worst]:g}"
        )
    return lines


def picture(difference: Difference, path: str | Path, title: str) -> None:
    """Draw the two differences over the sky, each with its own symmetric scale."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6.4), layout="constrained")
    figure.suptitle(title)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, values, what in (
        (panels[0], difference.on_sky_deg, "azimuth on the sky"),
        (panels[1], difference.zd_deg, "zenith distance"),
    ):
        mdeg = 1e3 * values.T
        # a few cells at the zenith or along a step must not swallow the scale
        limit = max(float(np.percentile(np.abs(mdeg), 98)), 1e-4)
        mesh = axes.pcolormesh(
            difference.grid.az_deg,
            difference.grid.zd_deg,
            mdeg,
            cmap="RdBu_r",
            vmin=-limit,
            vmax=limit,
            shading="nearest",
            rasterized=True,
        )
        axes.set_ylabel("zenith distance [deg]")
        axes.invert_yaxis()
        axes.set_title(f"offset of {what}, new - old")
        figure.colorbar(mesh, ax=axes, label="mdeg", extend="both")
    panels[1].set_xlabel("azimuth [deg]")
    with write_whole(path, "wb") as file:
        figure.savefig(file, format="png", dpi=110)
