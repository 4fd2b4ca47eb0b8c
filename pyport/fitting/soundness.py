"""Whether a fit's numbers can be trusted: what every fit of this program says of itself.

Per axis it is the root of the mean square of what is left in that axis. On the sky it is the root
of the mean of x^2 + y^2 over pointings that measured both axes, the square root of two larger
where both axes scatter alike. Excluded outliers do not count. Both divide by the number of offsets
or pointings: nothing is taken off for the fitted terms, as TPOINT's sky rms has it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.effects.base import Circumstances
from pyport.effects.degeneracies import BY_ELEVATION
from pyport.fitting import misread
from pyport.fitting.fit import Coefficients, Fit
from pyport.fitting.two_axes import UNLIKELY
from pyport.noise import outliers
from pyport.recordings.schema import Recordings, Stack
from pyport.thresholds import FEWEST, MOSTLY

PER_AXIS = "root mean square per axis, outliers excluded, not reduced for fitted terms"
ON_SKY = (
    "root of the mean of x^2 + y^2 over pointings with both axes, outliers excluded, not reduced "
    "for fitted terms (as TPOINT's sky rms)"
)


def largest_offset(data: Stack, at: Circumstances, used: NDArray[np.bool_] | None = None) -> float:
    """Return the largest offset of either axis as it reads the telescope [rad].

    Of the first axis that is x over the cosine of the second: x / cos E. Of those `used`, (m,).
    """
    reading = np.where(data.is_y, 1.0, np.maximum(np.abs(at.onto_sky), 1e-3)[data.row])
    own = np.abs(data.value) / reading
    return float(own.max(initial=0.0, where=True if used is None else used))


def rms_of(data: Stack, residual: Array, used: NDArray[np.bool_]) -> list[tuple[float, int] | None]:
    """Return the rms across, along and on the sky [rad], and of how many; None where of none.

    `data`: the m measured numbers.
    `residual`, `used`: what is left of each [rad], and whether it is no outlier, shape (m,).
    """
    across = np.flatnonzero(used & ~data.is_y)
    along = np.flatnonzero(used & data.is_y)
    _, x, y = np.intersect1d(data.row[across], data.row[along], return_indices=True)
    square = residual**2
    several = square[across], square[along], square[across[x]] + square[along[y]]
    return [(float(np.sqrt(one.mean())), len(one)) if len(one) else None for one in several]


def neglected(
    data: Stack, at: Circumstances, value: Array, used: NDArray[np.bool_], left: float
) -> float:
    """Return what a model that is linear in its terms neglects of such offsets, rms [rad].

    Each term turns what the others do: their products are lost. Zeros by themselves turn nothing,
    so that the size of offsets counts times what they vary by. Of exact rotations with errors of
    0.1 to 1 deg the linear fit leaves a third of that to as much.

    `value`, `used`: what mount and sky do to each number [rad], and which are no outliers, (m,);
    `left`: what a fit leaves, rms [rad]: less than half of that is lost in the noise, and 0.
    """
    size, vary = np.zeros(len(at)), np.zeros(len(at))
    for is_y, zero in ((False, at.onto_sky), (True, np.ones(len(at)))):
        own = used & (data.is_y == is_y)
        row, offset, unit = data.row[own], value[own], zero[data.row[own]]
        level = float(unit @ offset) / max(float(unit @ unit), 1e-300)
        size += np.bincount(row, offset**2, len(at))
        vary += np.bincount(row, (offset - level * unit) ** 2, len(at))
    lost = float(np.sqrt(np.mean(size * vary)))
    return lost if lost > MOSTLY * left else 0.0


def linear(
    data: Stack, at: Circumstances, value: Array, used: NDArray[np.bool_], left: float
) -> Iterator[str]:
    """Yield that offsets are too large for a model that is linear in its terms, if they are.

    `data`, `at`, `value`, `used`, `left`: as for `neglected`.
    """
    if lost := neglected(data, at, value, used, left):
        most = largest_offset(data, at, used) / DEG
        yield (
            f"offsets of up to {most:.2g} deg are too large for terms that only add up: about "
            f"{lost / ARCSEC:.2g} arcsec rms are lost; enter the fitted terms and record again"
        )


#: Belsley, Kuh & Welsch 1980, Regression Diagnostics: moderate to strong dependencies above 30.
ILL_POSED = 30.0
#: What rounding may make of an eigenvalue of zero, beside the largest.
ROUNDING = 1e-8


def doubts(
    *, condition: float, covariance: Array, numbers: int, rank: int, settled: bool = True
) -> Iterator[str]:
    """Yield a sentence for everything that is wrong with a fit as a whole.

    `condition`: condition number of the design, columns scaled to unit length.
    `covariance`: of the coefficients that the data determine, shape (P, P).
    `numbers`: measured numbers that count: those of some weight.
    `rank`: independent coefficients.
    `settled`: whether the weights of a robust fit came to rest.
    """
    if not settled:
        yield "the fit did not converge: its weights still change with every round"
    if numbers < rank:
        yield f"{numbers} offsets that count cannot determine {rank} coefficients"
    elif numbers == rank:
        yield (
            f"{numbers} offsets that count for {rank} coefficients: the curve goes through all of "
            "them, and the errors say nothing"
        )
    if not positive(covariance):
        yield "the covariance is not positive: some errors and correlations mean nothing"
    if condition > ILL_POSED:
        yield (
            f"the condition number {condition:.3g} is above {ILL_POSED:g}: "
            "these directions do not distinguish all terms well"
        )


def positive(covariance: Array) -> bool:
    """Tell whether a matrix can be a covariance: finite, and no combination has a square below 0.

    A coefficient without error, its row and column zero, is left out.
    """
    if not np.isfinite(covariance).all():
        return False
    variance = np.diag(covariance)
    if np.any(variance < 0):
        return False
    there = variance > 0
    if np.any(covariance[~there] != 0):
        return False
    sigma = np.sqrt(variance[there])
    if len(sigma) == 0:
        return True
    eigenvalues = np.linalg.eigvalsh(covariance[np.ix_(there, there)] / np.outer(sigma, sigma))
    return bool(eigenvalues[0] > -ROUNDING * eigenvalues[-1])


#: A coefficient within so many sigmas of zero might as well be zero.
WEAK = 2.0
#: Coefficients that correlate by more than this stand for each other.
TIED = 0.95
#: So many correlated pairs are named.
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
    yield from fit.recordings.notes
    if (other := misread.of_fit(fit)) is not None:
        yield other.of_fit
    yield from outliers.shared(fit.recordings, fit.stack, fit.noise.used)
    used = fit.noise.used
    if used.sum() - len(fit.covariance) >= FEWEST:
        left = float(np.sqrt(np.mean(fit.residual[used] ** 2)))
        yield from linear(fit.stack, fit.recordings.at, fit.stack.value, used, left)
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
    yield from _of_few_sources(fit)
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


#: A source stays at its declination; names whose rows spread over more of them, by the median name
#: and the middle four fifths of its rows, are names of something else [deg].
WIDEST_DEC_DEG = 10.0
#: Two numbers, a right ascension and a declination, are what a place is wrong by.
OF_A_PLACE = 2


def _of_few_sources(fit: Fit) -> Iterator[str]:
    """Yield that the errors of few sources' places went into the coefficients, if they did.

    Of the antenna with the fewest; one source alone may be a name for all rows, and what has none
    in most rows has more sources than names.
    """
    recordings = fit.recordings
    antenna, source = (recordings.label(name).astype(str) for name in ("antenna", "source"))
    fewest: tuple[int, int] | None = None
    for name in np.unique(antenna).tolist():
        own = antenna == name
        sources = np.unique(source[own & (source != "")])
        blank = np.count_nonzero(own & (source == ""))
        if len(sources) < 2 or 2 * blank > np.count_nonzero(own):
            continue
        count = _coefficients_of(fit, name)
        if OF_A_PLACE * len(sources) <= count and (fewest is None or len(sources) < fewest[0]):
            fewest = len(sources), count
    if fewest is not None and _are_sources(recordings, source):
        yield (
            f"only {fewest[0]} sources for {fewest[1]} coefficients: what their places err by goes "
            "into these terms and is not part of their errors; observe more sources"
        )


def _coefficients_of(fit: Fit, antenna: str) -> int:
    """Return how many determined coefficients act on an antenna's readings."""
    count = 0
    for one in fit.coefficients:
        labels = dict(zip(one.term.per, one.labels, strict=False))
        if labels.get("antenna", antenna) == antenna:
            count += int(np.isfinite(one.value).sum())
    return count


def _are_sources(recordings: Recordings, source: NDArray[np.str_]) -> bool:
    """Tell whether what bears one name stands at one declination, where that is known."""
    if "dec" not in recordings.at:
        return True
    dec = recordings.at.numbers("dec")
    low, high = (
        np.array([np.nanquantile(dec[source == one], at) for one in np.unique(source) if one])
        for at in (0.1, 0.9)
    )
    return bool(np.nanmedian(high - low) < WIDEST_DEC_DEG * DEG)


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
