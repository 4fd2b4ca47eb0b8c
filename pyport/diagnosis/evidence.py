"""Evidence: whitened sufficient statistics, and what each candidate would gain beside a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.common_mode import Excess
from pyport.fitting.gram import Gram, Part, inverted
from pyport.fitting.stacking import Codes

#: Shares of a coefficient's holders that a candidate is tried with.
SCOPES = ("all", "session", "antenna", "antenna and session")
#: A candidate must keep this share of its length when the model is projected out.
VISIBLE = 1e-5


@dataclass(frozen=True)
class Blocks:
    """The blocks of the data: one for each antenna in each session."""

    antenna: NDArray[np.str_]
    session: NDArray[np.str_]

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.antenna)

    def groups(self, scope: str) -> Codes:
        """Give blocks that share a coefficient the same number."""
        labels = {
            "all": np.zeros(len(self), int),
            "session": self.session,
            "antenna": self.antenna,
            "antenna and session": np.arange(len(self)),
        }[scope]
        return np.unique(labels, return_inverse=True)[1]

    def names(self, scope: str) -> list[str]:
        """Name the groups of a scope, in their order."""
        if scope == "all":
            return [""]
        if scope == "antenna and session":
            return [f"{a} {s}".strip() for a, s in zip(self.antenna, self.session, strict=True)]
        return [str(one) for one in np.unique(getattr(self, scope))]

    def scopes(self) -> list[str]:
        """Return the scopes that differ from each other here, the smallest first."""
        several = len(np.unique(self.antenna)) > 1, len(np.unique(self.session)) > 1
        wanted = {"all": True, "session": several[1], "antenna": several[0]}
        found = [scope for scope, there in wanted.items() if there]
        return [*found, "antenna and session"] if all(several) else found


@dataclass(frozen=True)
class Trial:
    """What a candidate gains when it joins a model and the model is refitted.

    Attributes
    ----------
    candidate, scope, part
        What was tried, and for which blocks the coefficients are shared.
    gain
        Drop of the whitened sum of squares.
    dof
        Independent coefficients that it adds.
    delta_bic
        `gain` less what that many coefficients must earn; above zero is worth having.
    noise_dof
        Deviations from which the scale of its noise is known.
    information
        Information on its coefficients with the model refitted, shape (P, P).
    drawn
        The same gain on each draw of the fitted noise, shape (draws,).
    """

    candidate: Candidate
    scope: str
    part: Part
    gain: float
    dof: int
    delta_bic: float
    noise_dof: float
    information: Array
    drawn: Array


class Evidence:
    """Whitened products of all columns, and draws of the noise that they would meet."""

    def __init__(
        self,
        gram: Gram,
        blocks: Blocks,
        pointings: int,
        *,
        common: Excess,
        draws: int,
        dof: Array,
        rng: np.random.Generator,
    ):
        self.gram = gram
        self.blocks = blocks
        self.pointings = pointings
        self.dof = dof
        self.common = common
        self.noise = self._draw(draws, dof, rng)
        self.luck = np.ones(draws)
        if np.isfinite(common.dof):
            self.luck = common.dof / rng.chisquare(common.dof, draws)

    def _draw(self, draws: int, dof: Array, rng: np.random.Generator) -> Array:
        """Return products of the columns with drawn noise, shape (blocks, K, draws).

        The products of C with white noise have the covariance C'C, so no
        recording needs to be simulated. The scale of each block's noise is
        known from `dof` deviations only, which the draws repeat.
        """
        size = self.gram.matrices.shape[1] - 1
        out = np.empty((len(self.blocks), size, draws))
        for block, matrix in enumerate(self.gram.matrices[:, :-1, :-1]):
            eigenvalues, vectors = np.linalg.eigh(matrix)
            root = vectors * np.sqrt(np.maximum(eigenvalues, 0))
            out[block] = root @ rng.standard_normal((size, draws))
        _, antenna = np.unique(self.blocks.antenna, return_inverse=True)
        scale = np.array([np.sqrt(k / rng.chisquare(k, draws)) for k in np.minimum(dof, 1e6)])
        return out * scale[antenna][:, None, :]

    def part(self, columns: Codes, scope: str) -> Part:
        """Return columns as a part of a model."""
        return Part(np.asarray(columns, np.intp), self.blocks.groups(scope))

    def trials(self, model: Sequence[Part], wanted: Sequence[tuple[Candidate, str]]) -> list[Trial]:
        """Return what each (candidate, scope) would gain beside `model`, if it shows at all."""
        inverse = inverted(self.gram.cross(model, model))[0]
        values = inverse @ self.gram.moments(model)
        drawn_values = inverse @ self.gram.moments(model, self.noise)
        found = []
        for candidate, scope in wanted:
            part = self.part(candidate.columns, scope)
            cross = self.gram.cross(model, [part])
            own = self.gram.cross([part], [part])
            left = own - cross.T @ inverse @ cross
            power = np.diag(own)
            length = np.where(power > 0, np.sqrt(np.maximum(power, 0)), np.inf)
            eigenvalues, vectors = np.linalg.eigh(left / np.outer(length, length))
            good = eigenvalues > VISIBLE**2 * max(1.0, float(eigenvalues[-1]))
            if not good.any():
                continue
            root = (vectors[:, good] / np.sqrt(eigenvalues[good])).T / length
            seen = root @ (self.gram.moments([part]) - cross.T @ values)
            drawn = root @ (self.gram.moments([part], self.noise) - cross.T @ drawn_values)
            dof = int(good.sum())
            # What the antennas share they cannot average out.
            shared = "antenna" not in scope
            excess = self.common.factor if shared else 1.0
            gain = float(seen @ seen) / excess
            penalty = dof * np.log(max(self.pointings, 3))
            found.append(
                Trial(
                    candidate,
                    scope,
                    part,
                    gain,
                    dof,
                    gain - penalty,
                    min(self.dof.sum(), self.common.dof) if shared else float(np.median(self.dof)),
                    left / excess,
                    (drawn**2).sum(axis=0) * (self.luck if shared else 1.0),
                )
            )
        return found

    def share(self, model: Sequence[Part], winner: Trial, other: Trial) -> float:
        """Return how much of the winner's fitted curve the other trial can draw, from 0 to 1.

        Both are seen with the model projected out, so this is the squared
        cosine between the winner's curve and the other's nearest one.
        """
        inverse = inverted(self.gram.cross(model, model))[0]
        of_winner = self.gram.cross(model, [winner.part])
        seen = self.gram.moments([winner.part]) - of_winner.T @ (inverse @ self.gram.moments(model))
        values = inverted(winner.information)[0] @ seen
        of_other = self.gram.cross(model, [other.part])
        between = self.gram.cross([other.part], [winner.part]) - of_other.T @ inverse @ of_winner
        drawn = between @ values
        length = float(values @ winner.information @ values)
        return float(drawn @ inverted(other.information)[0] @ drawn) / max(length, 1e-300)


def family_p_value(trials: Sequence[Trial]) -> float:
    """Return the probability that pure noise gives a search as good as the best of these.

    Each trial is scored by the chance of its gain under the F distribution; the
    best score is compared with the best score of every draw. Beyond the last
    draw the chance is that of the best trial alone times the number of
    independent trials that the draws show.
    """
    if not trials:
        return 1.0
    scores = np.array([_log_chance(trial, np.array([trial.gain]))[0] for trial in trials])
    drawn = np.min([_log_chance(trial, trial.drawn) for trial in trials], axis=0)
    best = float(scores.min())
    above = (1 + int((drawn <= best).sum())) / (1 + len(drawn))
    if above > 5 / (1 + len(drawn)):
        return float(above)
    independent = max(1.0, np.log(2) / np.exp(float(np.median(drawn))))
    return float(min(above, -np.expm1(-independent * np.exp(best))))


def _log_chance(trial: Trial, gain: Array) -> Array:
    """Return the logarithm of the chance of a gain at least this large from noise."""
    from scipy.stats import f

    return np.asarray(f.logsf(gain / trial.dof, trial.dof, min(trial.noise_dof, 1e6)))


def threshold(trials: Sequence[Trial], chance: float) -> float:
    """Return the log-chance that the best of a search falls below in `chance` of all noise."""
    if not trials:
        return float("-inf")
    drawn = np.min([_log_chance(trial, trial.drawn) for trial in trials], axis=0)
    return float(np.quantile(drawn, chance))


def gain_needed(trial: Trial, log_chance: float) -> float:
    """Return the gain whose chance under noise is `exp(log_chance)`."""
    from scipy.stats import f

    dof = min(trial.noise_dof, 1e6)
    return float(trial.dof * f.isf(np.exp(log_chance), trial.dof, dof))
