"""Significance: how often noise alone would do as well, over the whole search."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.evidence import CandidateFit
from pyport.stages import stage


@stage("significance")
def family_p_value(trials: Sequence[CandidateFit]) -> float:
    """Return the probability that pure noise gives a search as good as the best of these.

    Each trial is scored by the chance of its gain under the F distribution; the
    best score is compared with the best score of every draw. Beyond the last
    draw the chance is that of the best trial alone times the number of
    independent trials that the draws show.
    """
    if not trials:
        return 1.0
    best = float(_log_chances(trials, np.array([[trial.gain] for trial in trials])).min())
    drawn = _log_chances(trials, np.stack([trial.drawn for trial in trials])).min(axis=0)
    above = (1 + int((drawn <= best).sum())) / (1 + len(drawn))
    if above > 5 / (1 + len(drawn)):
        return float(above)
    independent = max(1.0, np.log(2) / -np.log1p(-np.exp(float(np.median(drawn)))))
    return float(min(above, -np.expm1(-independent * np.exp(best))))


def _log_chances(trials: Sequence[CandidateFit], gains: Array) -> Array:
    """Return log-chances of gains at least this large from noise, shape (trials, ...).

    The F distribution's tail is an incomplete beta function; where that
    underflows its leading term stands for it.
    """
    from scipy.special import betainc, betaln

    half = np.array([[trial.dof / 2] for trial in trials])
    rest = np.array([[min(trial.noise_dof, 1e6) / 2] for trial in trials])
    x = rest / (rest + gains / 2)
    chance = betainc(rest, half, x)
    # Where x is one the chance is one, and its leading term, no number then, is not asked.
    with np.errstate(divide="ignore", invalid="ignore"):
        leading = rest * np.log(x) + (half - 1) * np.log1p(-x) - np.log(rest) - betaln(rest, half)
        return np.where(chance > 1e-250, np.log(np.maximum(chance, 1e-300)), leading)


@stage("significance")
def threshold(trials: Sequence[CandidateFit], chance: float) -> float:
    """Return the log-chance that the best of a search falls below in `chance` of all noise."""
    if not trials:
        return float("-inf")
    drawn = _log_chances(trials, np.stack([trial.drawn for trial in trials])).min(axis=0)
    return float(np.quantile(drawn, chance))


def gain_needed(trial: CandidateFit, log_chance: float) -> float:
    """Return the gain whose chance under noise is `exp(log_chance)`."""
    from scipy.special import betaincinv

    rest = min(trial.noise_dof, 1e6) / 2
    x = float(betaincinv(rest, trial.dof / 2, np.exp(log_chance)))
    return 2 * rest * (1 - x) / max(x, 1e-300)
