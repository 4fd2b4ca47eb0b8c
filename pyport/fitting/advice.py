"""What a fit's figures warn of: weak terms, terms that go together, a design that is ill posed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pyport.angles import Array
from pyport.effects.degeneracies import BY_ELEVATION
from pyport.fitting.fit import Coefficients, Fit
from pyport.fitting.soundness import doubts
from pyport.fitting.two_axes import UNLIKELY

#: A coefficient within so many sigmas of zero might as well be zero.
WEAK = 2.0
#: Coefficients that correlate by more than this stand for each other.
TIED = 0.95
#: So many correlated pairs are told.
MOST_PAIRS = 6


def named(fit: Fit) -> list[tuple[str, Coefficients, int]]:
    """Return name, owner and place of every fitted coefficient, in the covariance's order."""
    return [
        (coefficient.name + (f"[{' '.join(one.labels)}]" if any(one.labels) else ""), one, n)
        for one in fit.coefficients
        for n, coefficient in enumerate(one.term.effect.coefficients)
    ]


def correlation(fit: Fit) -> Array:
    """Return the correlations of the fitted coefficients, shape (P, P), 0 where one is unknown."""
    sigma = np.sqrt(np.maximum(np.diag(fit.covariance), 0))
    scale = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=sigma > 0)
    return np.clip(fit.covariance * np.outer(scale, scale), -1, 1)


def warnings(fit: Fit) -> Iterator[str]:
    """Yield a sentence for everything that a user should know before trusting the numbers."""
    everything = named(fit)
    unknown = [name for name, one, n in everything if not np.isfinite(one.value[n])]
    if unknown:
        yield f"not determined: {', '.join(unknown)}; drop or fix all but one of what they share"
    weak = [
        name
        for name, one, n in everything
        if np.isfinite(one.value[n]) and abs(one.value[n]) < WEAK * one.sigma[n]
    ]
    if weak:
        yield f"within {WEAK:g} sigmas of zero: {', '.join(weak)}; try --drop"
    yield from _tied(fit, everything)
    across, along = fit.recordings.at.mount.names
    for term, apart in fit.two_axes:
        if apart.p_value < UNLIKELY / len(fit.two_axes):
            name = term.effect.id.replace("_", " ")
            yield (
                f"the {name} seen in {across} and that seen in {along} differ by "
                f"{apart.sigmas:.1f} sigmas: no {name} does that; pyport diagnose tells where"
            )
    known = np.array([np.isfinite(one.value[n]) for _, one, n in everything], bool)
    yield from doubts(
        condition=fit.condition,
        covariance=fit.covariance[np.ix_(known, known)],
        numbers=int(fit.noise.used.sum()),
        rank=int(known.sum()),
    )


def _tied(fit: Fit, everything: list[tuple[str, Coefficients, int]]) -> Iterator[str]:
    """Yield the strongest correlations, and what would loosen those that are known to tie."""
    matrix = correlation(fit)
    rows, columns = np.nonzero(np.tril(np.abs(matrix) > TIED, -1))
    order = np.argsort(-np.abs(matrix[rows, columns]), kind="stable")
    met: set[str] = set()
    for place in order[:MOST_PAIRS]:
        row, column = rows[place], columns[place]
        pair = everything[column], everything[row]
        yield f"{pair[0][0]} and {pair[1][0]} correlate by {matrix[row, column]:+.3f}"
        ids = {one.term.effect.id for _, one, _ in pair}
        met |= {remedy for family, remedy in BY_ELEVATION.items() if ids <= family}
    if len(order) > MOST_PAIRS:
        yield f"{len(order) - MOST_PAIRS} more pairs correlate by more than {TIED}"
    yield from sorted(met)
