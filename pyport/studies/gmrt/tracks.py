"""An antenna's day as the analysis takes it: one offset a scan, and a robust line through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, Array
from pyport.fitting.soundness import doubts
from pyport.least_squares import robust
from pyport.recordings.schema import Recordings

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
