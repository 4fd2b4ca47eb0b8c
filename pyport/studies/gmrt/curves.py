"""Both functional forms of the paper, antenna by antenna and day by day.

Section 4 fits f(HA) = a + b cos(HA + d) to the elevation offset, and to the
offset times cos(el).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, Array
from pyport.fitting.soundness import doubts
from pyport.least_squares import robust
from pyport.recordings.schema import Recordings
from pyport.studies.gmrt.published import Wave

#: An antenna with fewer scans in a day tells no curve.
ENOUGH_SCANS = 8

#: The tables print whole arcminutes: the least scatter of the mean of two channels [rad].
ROUNDING = ARCMIN / np.sqrt(12 * 2)

#: Residuals beyond this many sigmas have no weight.
REACH = 6.0


@dataclass(frozen=True)
class Track:
    """One antenna in one session, n scans in the order of hour angle.

    The two channels of a scan share most of its scatter, so a scan's offset is
    their mean and counts once.
    """

    #: `antenna`, `session`: whose.
    antenna: str
    session: str
    #: `hour_angle`, `el`, `offset`: shape (n,) [rad].
    hour_angle: Array
    el: Array
    offset: Array
    direction: Array  #: +1 or -1, shape (n,)

    def __len__(self) -> int:
        """Return n."""
        return len(self.offset)


@dataclass(frozen=True)
class Line:
    """A linear fit."""

    #: `value`, `covariance`: of the k coefficients, shape (k,) and (k, k), from the scatter that is
    #: left.
    value: Array
    covariance: Array
    #: `residual`, `weight`: of each scan, shape (n,).
    residual: Array
    weight: Array
    #: `squares`, `spare`: weighted sum of squared residuals, and degrees of freedom.
    squares: float
    spare: int
    condition: float  #: condition number of the columns, each scaled to unit length
    settled: bool  #: whether the weights came to rest

    @property
    def doubts(self) -> list[str]:
        """Return what is wrong with the fit as a whole."""
        return list(
            doubts(
                condition=self.condition,
                covariance=self.covariance,
                numbers=int((self.weight > 0).sum()),
                rank=len(self.value),
                settled=self.settled,
            )
        )

    @property
    def rms(self) -> float:
        """Return the scatter of a scan about the line."""
        return float(np.sqrt(self.squares / self.spare))

    @property
    def sigma(self) -> Array:
        """Return the one-sigma errors of the coefficients, shape (k,)."""
        return np.sqrt(np.diag(self.covariance))


def tracks(recordings: Recordings) -> list[Track]:
    """Return every antenna's day that has enough scans."""
    at, antenna, session = recordings.at, recordings.label("antenna"), recordings.label("session")
    scan = at.column("scan")
    found = []
    for day in np.unique(session):
        for name in np.unique(antenna[session == day]):
            own = np.flatnonzero((antenna == name) & (session == day) & np.isfinite(recordings.y))
            _, first, member = np.unique(scan[own], return_index=True, return_inverse=True)
            if len(first) < ENOUGH_SCANS:
                continue
            one = own[first]
            count = np.bincount(member)
            offset = np.bincount(member, recordings.y[own]) / count
            hour_angle = at.column("hour_angle")[one]
            order = np.argsort(hour_angle)
            found.append(
                Track(
                    str(name),
                    str(day),
                    hour_angle[order],
                    at.el[one][order],
                    offset[order],
                    at.column("scan_direction")[one][order],
                )
            )
    return found


def line(columns: Array, value: Array) -> Line:
    """Return the robust least-squares fit of columns (n, k) to values (n,)."""
    weight, residual, settled = robust.weights(columns, value, REACH, ROUNDING)
    root = np.sqrt(weight)[:, None]
    length = np.linalg.norm(columns * root, axis=0)
    scaled = columns * root / length
    inverse = np.linalg.pinv(scaled.T @ scaled) / np.outer(length, length)
    spare = max(1, int((weight > 0).sum()) - columns.shape[1])
    squares = max(float((weight * residual**2).sum()), spare * ROUNDING**2)
    return Line(
        inverse @ (columns.T @ (weight * value)),
        inverse * squares / spare,
        residual,
        weight,
        squares,
        spare,
        float(np.linalg.cond(scaled)),
        settled,
    )


@dataclass(frozen=True)
class Curve:
    """A fitted curve, values with their one-sigma errors [rad]."""

    track: Track  #: what it was fitted to
    cosine: Cosine  #: the fitted curve
    half_difference: tuple[float, float]  #: half of forward minus reverse, fitted along
    rms: float  #: scatter of a scan about the curve
    condition: float  #: of the three columns: how a, b and d trade against each other
    doubts: tuple[str, ...]  #: what is wrong with the fit as a whole

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
        Cosine(fit.value[:3], fit.covariance[:3, :3]),
        (float(fit.value[3]), float(fit.sigma[3])),
        fit.rms,
        condition(track.hour_angle),
        tuple(fit.doubts),
    )


#: Phases that the nearest agreeing curve is looked for at, from the published one [rad].
_TURNS = np.linspace(-np.pi, np.pi, 1441)
_FINER = np.linspace(-1, 1, 401) * (_TURNS[1] - _TURNS[0])


@dataclass(frozen=True)
class Cosine:
    """A curve that is linear in its coefficients."""

    value: Array  #: the level, and the coefficients of cos HA and of sin HA [rad], shape (3,)
    covariance: Array  #: theirs, shape (3, 3)

    def __call__(self, hour_angle: Array) -> Array:
        """Return the curve at hour angles [rad]."""
        return columns(hour_angle) @ self.value

    def sigma(self, hour_angle: Array) -> Array:
        """Return the one-sigma error of the curve at hour angles [rad]."""
        design = columns(hour_angle)
        return np.sqrt(np.einsum("ni,ij,nj->n", design, self.covariance, design))

    def polar(self, like: Wave | None = None) -> tuple[tuple[float, float], ...]:
        """Return a, b and d [rad], each with its sigma.

        b is negative, as nearly everywhere in Table 18, or has the sign of
        `like`, and d is within half a turn of that one's.
        """
        sign = -1.0 if like is None else math.copysign(1.0, like.b)
        b = sign * math.hypot(*self.value[1:])
        d = math.atan2(-sign * self.value[2], sign * self.value[1])
        if like is not None:
            d += 2 * math.pi * round((like.d - d) / (2 * math.pi))
        # b and d turn with the coefficients of cosine and sine: one row each of the rotation
        turn = np.array([[np.cos(d), -np.sin(d)], [-np.sin(d), -np.cos(d)]])
        along, across = np.sqrt(np.diag(turn @ self.covariance[1:, 1:] @ turn.T))
        of_a = float(np.sqrt(self.covariance[0, 0]))
        return (float(self.value[0]), of_a), (b, float(along)), (d, float(across / abs(b)))

    def sigmas_from(self, wave: Wave) -> Array:
        """Return by how many combined sigmas a, b and d differ from a published curve, shape (3,).

        For b and d: the fewest at which both could have the same one, all other
        coefficients free (a profile likelihood). It is the difference over the
        combined sigma where the errors are small, and holds where they are not.
        """
        of_a = abs(self.value[0] - wave.a) / math.hypot(
            math.sqrt(self.covariance[0, 0]), wave.sigma_a
        )
        return np.array([of_a, *np.sqrt([self._squares(wave, "b"), self._squares(wave, "d")])])

    def _squares(self, wave: Wave, which: str) -> float:
        """Return the least chi-square at which b, or d, is the published curve's."""
        weight = np.linalg.inv(self.covariance[1:, 1:])

        def least(turn: Array) -> Array:
            """Return the least chi-square at each phase, so far from the published one."""
            unit = np.stack([np.cos(wave.d + turn), -np.sin(wave.d + turn)])
            pull = unit.T @ weight @ self.value[1:]
            stiff = np.einsum("it,ij,jt->t", unit, weight, unit)
            if which == "b":
                pull, stiff = pull + wave.b / wave.sigma_b**2, stiff + wave.sigma_b**-2
            b = np.where(pull * wave.b > 0, pull / stiff, 0.0)
            left = self.value[1:, None] - b * unit
            own = (b - wave.b) / wave.sigma_b if which == "b" else turn / wave.sigma_d
            return np.einsum("it,ij,jt->t", left, weight, left) + own**2

        near = _TURNS[least(_TURNS).argmin()]
        return float(least(near + _FINER).min())


def columns(hour_angle: Array) -> Array:
    """Return a constant, cos HA and sin HA, shape (n, 3)."""
    return np.stack([np.ones(len(hour_angle)), np.cos(hour_angle), np.sin(hour_angle)], axis=1)


def condition(hour_angle: Array) -> float:
    """Return how a, b and d trade against each other at these hour angles: a condition number."""
    design = columns(hour_angle)
    return float(np.linalg.cond(design / np.linalg.norm(design, axis=0)))
