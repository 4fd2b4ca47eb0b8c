"""Two steering tables beside each other: where they differ, by how much, in which direction."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pyport.angles import DEG, Array, wrap
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.steering.grid import Grid, Table


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
