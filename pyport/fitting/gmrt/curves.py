"""Both functional forms of the paper, antenna by antenna and day by day.

Section 4 fits f(HA) = a + b cos(HA + d) to the elevation offset, and to the
offset times cos(el). In a, b cos d and -b sin d both are linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.fitting.gmrt.tracks import Track, line


@dataclass(frozen=True)
class Curve:
    """A fitted curve, values with their one-sigma errors [rad].

    Attributes
    ----------
    track
        What it was fitted to.
    times_cos_el
        Which of the two forms.
    a, b, d
        The coefficients; b is negative, as nearly everywhere in Table 18.
    cosine, sine
        b cos d and -b sin d: the even and the odd part.
    half_difference
        Half of forward minus reverse, fitted along; the paper left it in.
    rms
        Scatter of a scan about the curve.
    condition
        Of the three columns: how a, b and d trade against each other.
    """

    track: Track
    times_cos_el: bool
    a: tuple[float, float]
    b: tuple[float, float]
    d: tuple[float, float]
    cosine: tuple[float, float]
    sine: tuple[float, float]
    half_difference: tuple[float, float]
    rms: float
    condition: float

    def __call__(self, hour_angle: Array) -> Array:
        """Return the curve at hour angles [rad]."""
        return self.a[0] + self.b[0] * np.cos(hour_angle + self.d[0])


def curves(found: Sequence[Track], *, times_cos_el: bool = False) -> list[Curve]:
    """Return the curve of each track, in one of the paper's two forms."""
    return [curve(track, times_cos_el=times_cos_el) for track in found]


def curve(track: Track, *, times_cos_el: bool = False) -> Curve:
    """Return the curve of a track, in one of the paper's two forms."""
    size = np.cos(track.el) if times_cos_el else np.ones(len(track))
    shape = np.stack([np.ones(len(track)), np.cos(track.hour_angle), np.sin(track.hour_angle)])
    fit = line(np.stack([*shape, size * track.direction], axis=1), size * track.offset)
    (a, cosine, sine, half), sigma = fit.value, fit.sigma
    b, d = polar(float(cosine), float(sine))
    # b and d turn with (cosine, sine): one row each of the rotation
    turn = np.array([[np.cos(d), -np.sin(d)], [-np.sin(d) / b, -np.cos(d) / b]])
    of_b, of_d = np.sqrt(np.diag(turn @ fit.covariance[1:3, 1:3] @ turn.T))
    unit = shape / np.linalg.norm(shape, axis=1, keepdims=True)
    return Curve(
        track,
        times_cos_el,
        (float(a), float(sigma[0])),
        (b, float(of_b)),
        (d, float(of_d)),
        (float(cosine), float(sigma[1])),
        (float(sine), float(sigma[2])),
        (float(half), float(sigma[3])),
        fit.rms,
        float(np.linalg.cond(unit)),
    )


def polar(cosine: float, sine: float) -> tuple[float, float]:
    """Return b and d with b cos(h + d) = cosine cos h + sine sin h, b negative as in Table 18."""
    return -float(np.hypot(cosine, sine)), float(np.arctan2(sine, -cosine))
