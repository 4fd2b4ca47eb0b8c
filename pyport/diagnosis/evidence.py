"""Evidence: whitened sufficient statistics, and what each candidate would gain beside a model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis.candidates import Blocks, Candidate
from pyport.diagnosis.trial import CandidateFit, each_at_best, units
from pyport.least_squares.gram import Gram, Part, Slab, index, inverse_of, slabs, without
from pyport.noise.common_mode import Excess
from pyport.runs.stages import stage
from pyport.thresholds import VISIBLE

#: Candidates of so many products are tried at a time: they stay in the processor's cache.
TOGETHER = 1 << 16


class Evidence:
    """Whitened products of all columns, and draws of the noise that they would meet."""

    def __init__(
        self,
        white: Array,
        block: Codes,
        kind: Codes,
        blocks: Blocks,
        numbers: int,
        *,
        common: Excess,
        draws: int,
        dof: Array,
        rng: np.random.Generator,
    ):
        self.blocks = blocks
        self.numbers = numbers
        self.dof = dof
        self.common = common
        self._given = white, block, kind
        self._draws, self._rng = draws, rng

    @cached_property
    def _slabs(self) -> list[Slab]:
        return slabs(*self._given)

    @cached_property
    @stage("products and draws")
    def gram(self) -> Gram:
        """Return the products of all columns and the data."""
        return Gram.summed(self._slabs, len(self.blocks), self._given[0].shape[1])

    @property
    def noise(self) -> Array:
        """Return the products of the columns with drawn noise, shape (blocks, K, draws)."""
        return self._drawn[0]

    @property
    def common_mode_scale(self) -> Array:
        """Return by what each draw's gain is off because the common mode is, shape (draws,)."""
        return self._drawn[1]

    @cached_property
    @stage("products and draws")
    def _drawn(self) -> tuple[Array, Array]:
        """Return products with drawn noise and the common-mode scales; let the columns go."""
        size = self.gram.matrices.shape[1] - 1
        noise = self._draw(self._slabs, size, self._draws, self._rng)
        common_mode_scale = np.ones(self._draws)
        if np.isfinite(self.common.dof):
            common_mode_scale = self.common.dof / self._rng.chisquare(self.common.dof, self._draws)
        del self._given, self._slabs
        return noise, common_mode_scale

    def _draw(self, cut: Sequence[Slab], size: int, draws: int, rng: np.random.Generator) -> Array:
        """Return products of the columns with drawn noise, shape (blocks, size, draws).

        The scale of each block's noise is known from `dof` deviations only,
        which the draws repeat. Rows that are zero but for rounding get none: rounding
        must not decide which row gets which numbers.
        """
        _, antenna = np.unique(self.blocks.antenna, return_inverse=True)
        scale = np.array([np.sqrt(k / rng.chisquare(k, draws)) for k in np.minimum(self.dof, 1e6)])
        out = np.zeros((len(self.blocks), size, draws))
        if not draws:
            return out
        for one in range(len(self.blocks)):
            own = without([slab for slab in cut if slab.block == one], last=size)
            rows = np.sort(np.concatenate([np.zeros(0, np.intp), *(slab.rows for slab in own)]))
            # Single precision is more than the few hundred draws can tell.
            drawn = rng.standard_normal((len(rows), draws), np.float32)
            for slab in own:
                values = slab.values.astype(np.float32)
                out[one, slab.columns] += values.T @ drawn[np.searchsorted(rows, slab.rows)]
            out[one] *= scale[antenna[one]]
        return out

    def beside(self, model: Sequence[Part], only: Codes | None = None) -> Projection:
        """Return what is left of everything, or `only` some columns, when a model is refitted."""
        size = self.gram.matrices.shape[1] - 1
        return Projection(self, model, np.arange(size) if only is None else np.sort(only))


@dataclass(frozen=True)
class _Left:
    """Columns in one scope, with the model projected out.

    Attributes
    ----------
    own
        Products of the columns within each of the G groups, shape (K, K) each.
    cross, solved
        Products with the model's columns, and the model's inverse times them, (K, M, G).
    seen
        Products with the data's residuals, shape (G, K).
    drawn
        Products with drawn noise's residuals, shape (G, K, draws).
    """

    own: Sequence[Array]
    cross: Array
    solved: Array
    seen: Array
    drawn: Array

    def between(self, some: Codes, others: Codes) -> Array:
        """Return projected products of choices of columns, (..., k), (..., l): (..., G k, G l)."""
        _, model, groups = self.cross.shape
        several, k, more = some.shape[:-1], some.shape[-1], others.shape[-1]
        left = np.moveaxis(self.cross[some], -1, -3).reshape(*several, groups * k, model)
        right = np.moveaxis(self.solved[others], -3, -1).reshape(*several, model, groups * more)
        out = -(left @ right).reshape(*several, groups, k, groups, more)
        for group, own in enumerate(self.own):
            out[..., group, :, group, :] += own[some[..., :, None], others[..., None, :]]
        return out.reshape(*several, groups * k, groups * more)


class Projection:
    """Everything beside one model: scope by scope, what each column still shows."""

    def __init__(self, evidence: Evidence, model: Sequence[Part], columns: Codes):
        self.evidence = evidence
        self.model = model
        self.columns = columns
        self.inverse = inverse_of(evidence.gram.cross(model, model))[0]
        self.values = self.inverse @ evidence.gram.moments(model)
        self.drawn_values = self.inverse @ evidence.gram.moments(model, evidence.noise)
        self._left: dict[str, _Left] = {}

    def left(self, scope: str) -> _Left:
        """Return all columns in a scope with the model projected out."""
        if scope not in self._left:
            self._left[scope] = self._project(scope)
        return self._left[scope]

    def _project(self, scope: str) -> _Left:
        evidence, kept = self.evidence, self.columns
        groups = evidence.blocks.groups(scope)
        count, size = evidence.blocks.count(scope), len(kept)
        whole = size == evidence.gram.matrices.shape[1] - 1
        own: list[Array] = []
        seen = np.zeros((count, size))
        drawn = np.zeros((count, size, evidence.noise.shape[2]))
        cross = np.zeros((count, len(self.values), size))
        solved = np.empty_like(cross)
        places, columns = index(self.model, len(groups))
        for group in range(count):
            blocks = np.flatnonzero(groups == group)
            for block in blocks:
                matrix = evidence.gram.matrices[block]
                seen[group] += matrix[kept, -1]
                drawn[group] += evidence.noise[block, kept]
                cross[group, places[block]] += matrix[columns[:, None], kept]
            # Of a single block all products are a view: they are the most there is in memory.
            matrices = evidence.gram.matrices
            one = len(blocks) == 1
            products = matrices[blocks[0]] if one else matrices[blocks].sum(axis=0)
            own.append(products[:-1, :-1] if whole else products[kept[:, None], kept])
            # A group meets no more of the model than its own blocks' coefficients.
            met = np.unique(places[blocks])
            within = cross[group, met]
            seen[group] -= within.T @ self.values[met]
            drawn[group] -= within.T @ self.drawn_values[met]
            solved[group] = self.inverse[:, met] @ within
        cross, solved = (np.ascontiguousarray(one.transpose(2, 1, 0)) for one in (cross, solved))
        return _Left(own, cross, solved, seen, drawn)

    @stage("trying candidates")
    def trials(self, wanted: Sequence[tuple[Candidate, str]]) -> list[CandidateFit]:
        """Return what each (candidate, scope) would gain, if it shows at all."""
        alike: dict[tuple[str, int], list[int]] = {}
        for n, (candidate, scope) in enumerate(wanted):
            alike.setdefault((scope, len(candidate.columns)), []).append(n)
        found: dict[int, CandidateFit] = {}
        for (scope, width), numbers in alike.items():
            most = max(1, TOGETHER // (width * len(self.left(scope).own)) ** 2)
            for low in range(0, len(numbers), most):
                some = numbers[low : low + most]
                tried = self._tried([wanted[n][0] for n in some], scope)
                found.update({n: one for n, one in zip(some, tried, strict=True) if one.dof})
        return [found[n] for n in sorted(found)]

    def _tried(self, candidates: Sequence[Candidate], scope: str) -> Iterator[CandidateFit]:
        """Yield what candidates of as many columns each would gain in a scope."""
        evidence, left, count = self.evidence, self.left(scope), len(candidates)
        columns = np.stack([self._places(one) for one in candidates])
        information = left.between(columns, columns)
        power = np.concatenate([np.diag(own)[columns] for own in left.own], axis=1)
        known = np.stack([np.resize(one.precision, power.shape[1]) for one in candidates])
        length = units(np.sqrt(np.maximum(power, 0)), known)
        unit = information / (length[:, :, None] * length[:, None])
        eigenvalues, vectors = np.linalg.eigh(unit)
        good = eigenvalues > VISIBLE**2 * np.maximum(1.0, eigenvalues[:, -1:])
        eigenvalues = np.where(good, eigenvalues, 0.0)
        strength = np.where(good, np.sqrt(eigenvalues), np.inf)
        root = np.ascontiguousarray((vectors / strength[:, None]).swapaxes(1, 2)) / length[:, None]
        moments = left.seen[:, columns].swapaxes(0, 1).reshape(count, -1, 1)
        seen = (root @ moments)[:, :, 0]
        drawn = root @ left.drawn[:, columns].swapaxes(0, 1).reshape(*length.shape, -1)
        dof = good.sum(axis=1)
        # What the antennas share they cannot average out.
        shared = "antenna" not in scope
        excess = evidence.common.factor if shared else 1.0
        gain = np.vecdot(seen, seen) / excess
        worth = each_at_best(eigenvalues / excess, seen * np.sqrt(eigenvalues) / excess)[0]
        values = (seen[:, None] @ root)[:, 0]
        drawn_gain = (drawn**2).sum(axis=1) * (evidence.common_mode_scale if shared else 1.0)
        deviations = min(float(evidence.dof.sum()), evidence.common.dof)
        for n, candidate in enumerate(candidates):
            yield CandidateFit(
                candidate,
                scope,
                float(gain[n]),
                int(dof[n]),
                float(gain[n] - dof[n] * np.log(max(evidence.numbers, 3))) - candidate.price,
                float(worth[n]) - candidate.price,
                deviations if shared else float(np.median(evidence.dof)),
                values[n],
                information[n] / excess,
                drawn_gain[n],
            )

    def _places(self, candidate: Candidate) -> Codes:
        """Return where a candidate's columns stand among those that are looked at."""
        return np.searchsorted(self.columns, candidate.columns)

    def share(self, winner: CandidateFit, other: CandidateFit) -> float:
        """Return how much of the winner's fitted curve another of its scope can draw, 0 to 1.

        Both are seen with the model projected out, so this is the squared
        cosine between the winner's curve and the other's nearest one.
        """
        left = self.left(winner.scope)
        own, rival = self._places(winner.candidate), self._places(other.candidate)
        drawn = left.between(rival, own) @ winner.values
        length = float(winner.values @ left.between(own, own) @ winner.values)
        nearest = float(drawn @ inverse_of(left.between(rival, rival))[0] @ drawn)
        return nearest / max(length, 1e-300)
