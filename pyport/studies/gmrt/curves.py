"""Both functional forms of the paper, antenna by antenna and day by day.

Section 4 fits f(HA) = a + b cos(HA + d) to the elevation offset, and to the
offset times cos(el).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.studies.gmrt.cosine import Cosine, columns, condition
from pyport.studies.gmrt.tracks import Track, line


@dataclass(frozen=True)
class Curve:
    """A fitted curve, values with their one-sigma errors [rad].

    Attributes
    ----------
    track
        What it was fitted to.
    times_cos_el
        Which of the two forms.
    cosine
        The fitted curve.
    half_difference
        Half of forward minus reverse, fitted along.
    rms
        Scatter of a scan about the curve.
    condition
        Of the three columns: how a, b and d trade against each other.
    doubts
        What is wrong with the fit as a whole.
    """

    track: Track
    times_cos_el: bool
    cosine: Cosine
    half_difference: tuple[float, float]
    rms: float
    condition: float
    doubts: tuple[str, ...]

    def __call__(self, hour_angle: Array) -> Array:
        """Return the curve at hour angles [rad]."""
        return self.cosine(hour_angle)

    @property
    def odd(self) -> tuple[float, float]:
        """Return the coefficient of sin HA, -b sin d, with its sigma."""
        return float(self.cosine.value[2]), float(np.sqrt(self.cosine.covariance[2, 2]))


def curves(found: Sequence[Track], *, times_cos_el: bool = False) -> list[Curve]:
    """Return the curve of each track, in one of the paper's two forms."""
    return [curve(track, times_cos_el=times_cos_el) for track in found]


def curve(track: Track, *, times_cos_el: bool = False) -> Curve:
    """Return the curve of a track, in one of the paper's two forms."""
    size = np.cos(track.el) if times_cos_el else np.ones(len(track))
    design = np.column_stack([columns(track.hour_angle), size * track.direction])
    fit = line(design, size * track.offset)
    return Curve(
        track,
        times_cos_el,
        Cosine(fit.value[:3], fit.covariance[:3, :3]),
        (float(fit.value[3]), float(fit.sigma[3])),
        fit.rms,
        condition(track.hour_angle),
        tuple(fit.doubts),
    )
