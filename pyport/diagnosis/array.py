"""Arrays: what is common to all antennas, and what is each antenna's own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.thresholds import SIGNIFICANT


@dataclass(frozen=True)
class Split:
    """A coefficient of many antennas, taken apart.

    Attributes
    ----------
    sessions, common, common_sigma
        The part that all antennas share, session by session, shape (S,).
    antennas, own, own_sigma
        Each antenna's own part, shape (A,), zero on average.
    spread
        Scatter of the own parts beyond their errors.
    chi_squared, dof
        Of the common part being the same in all sessions.
    """

    sessions: tuple[str, ...]
    common: Array
    common_sigma: Array
    antennas: tuple[str, ...]
    own: Array
    own_sigma: Array
    spread: float
    chi_squared: float
    dof: int

    @property
    def has_common(self) -> bool:
        """Tell whether any session's common part stands out of its error."""
        return bool(np.any(np.abs(self.common) > SIGNIFICANT * self.common_sigma))

    @property
    def standing_out(self) -> NDArray[np.bool_]:
        """Tell which antennas have a part of their own, shape (A,)."""
        return np.abs(self.own) > SIGNIFICANT * self.own_sigma

    @property
    def changes(self) -> bool:
        """Tell whether the common part changes from session to session."""
        from scipy.stats import chi2

        return self.dof > 0 and bool(chi2.sf(self.chi_squared, self.dof) < 1e-3)


def split(
    antenna: NDArray[np.str_], session: NDArray[np.str_], value: Array, sigma: Array
) -> Split:
    """Take coefficients apart into a common part per session and an own part per antenna.

    Parameters
    ----------
    antenna, session
        Labels of each coefficient, shape (n,).
    value, sigma
        The coefficients and their errors, shape (n,); errors must be finite and above zero.

    Returns
    -------
    Split
        The own parts are random about zero with a scatter found from the data
        (DerSimonian & Laird 1986), so that one precise antenna does not define
        what is common to all.
    """
    antennas, a = np.unique(antenna, return_inverse=True)
    sessions, s = np.unique(session, return_inverse=True)
    spread = _spread(s, value, sigma)
    weight = 1 / (sigma**2 + spread**2)
    common = np.bincount(s, weight * value) / np.bincount(s, weight)
    for _ in range(200):
        left = np.bincount(a, (value - common[s]) / sigma**2) / np.bincount(a, 1 / sigma**2)
        left -= np.mean(left)
        updated = np.bincount(s, weight * (value - left[a])) / np.bincount(s, weight)
        if np.allclose(updated, common, rtol=0, atol=1e-6 * sigma.min()):
            break
        common = updated
    common_sigma = np.sqrt(
        1 / np.bincount(s, 1 / sigma**2) + spread**2 / np.maximum(np.bincount(s), 1)
    )
    own_sigma = np.sqrt(1 / np.bincount(a, 1 / sigma**2) + 1 / (1 / sigma**2).sum())
    # Sessions share the antennas, so the spread of own parts drops out of their differences.
    difference_sigma = np.sqrt(1 / np.bincount(s, 1 / sigma**2))
    mean = np.average(common, weights=1 / difference_sigma**2)
    chi_squared = float((((common - mean) / difference_sigma) ** 2).sum())
    return Split(
        tuple(map(str, sessions)),
        common,
        common_sigma,
        tuple(map(str, antennas)),
        left,
        own_sigma,
        spread,
        chi_squared,
        len(sessions) - 1,
    )


def _spread(s: NDArray[np.intp], value: Array, sigma: Array) -> float:
    """Return the scatter of antennas about their session's mean beyond their errors."""
    weight = 1 / sigma**2
    mean = np.bincount(s, weight * value) / np.bincount(s, weight)
    excess = float((weight * (value - mean[s]) ** 2).sum()) - (len(value) - s.max() - 1)
    total = weight.sum() - (np.bincount(s, weight**2) / np.bincount(s, weight)).sum()
    return float(np.sqrt(max(0.0, excess / max(total, 1e-300))))
