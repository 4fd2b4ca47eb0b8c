"""The fit of a model to recordings: robust, weighted by each antenna's own scatter."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.errors import BadInput
from pyport.fitting import robust
from pyport.fitting.gram import inverted
from pyport.fitting.models import Model, Term
from pyport.fitting.stacking import Codes, Stack, group, stack, term_columns
from pyport.fitting.two_axes import Difference, from_products
from pyport.recordings.schema import Recordings
from pyport.threads import one_thread

#: Residuals beyond this many sigmas have no weight (Tukey's biweight, flat up to three).
REACH = 6.0


@dataclass(frozen=True)
class Coefficients:
    """The fitted coefficients of one term for one group of rows.

    Attributes
    ----------
    term
        What they are of.
    labels
        Values of the labels that the term is split by.
    value, sigma
        In internal units, shape (k,), what the model gave included; NaN where
        the data leave them open.
    """

    term: Term
    labels: tuple[str, ...]
    value: Array
    sigma: Array


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Attributes
    ----------
    recordings, model, stack
        What was fitted to what.
    coefficients
        Of every term and group.
    covariance
        Of all coefficients in their order, shape (P, P).
    residual, weight
        What is left of each number [rad] and its robust weight, shape (m,).
    condition
        Condition number of the design, columns scaled to unit length.
    two_axes
        Terms that act on both axes, with what each axis alone says of their coefficients.
    settled
        Whether the weights came to rest.
    """

    recordings: Recordings
    model: Model
    stack: Stack
    coefficients: tuple[Coefficients, ...]
    covariance: Array
    residual: Array
    weight: Array
    condition: float
    two_axes: tuple[tuple[Term, Difference], ...] = ()
    settled: bool = True


@one_thread
def fit(recordings: Recordings, model: Model, refit: Collection[str] | None = None) -> Fit:
    """Fit a model's terms to recordings.

    Every antenna and axis is weighted by its own robust scatter. Sigmas are
    those of the scatter that is left.

    Raises
    ------
    BadInput
        There are fewer measured offsets than coefficients.
    """
    data = stack(recordings)
    value = data.value - data.spread(*model.offsets(recordings.at))
    terms = model.fitted(refit)
    columns, owners = _expanded(recordings, data, terms)
    if len(value) < columns.shape[1]:
        raise BadInput(
            f"{len(value)} measured offsets cannot determine {columns.shape[1]} coefficients",
            recordings.file,
        )
    weight, scatter, settled = _weights(recordings, data, columns, value)
    root = np.sqrt(weight) / scatter
    normal = (columns * root[:, None]).T @ (columns * root[:, None])
    inverse, _, condition, known = inverted(normal)
    values = inverse @ (columns.T @ (root**2 * value))
    sigma = np.sqrt(np.maximum(np.diag(inverse), 0))
    values, sigma = np.where(known, values, np.nan), np.where(known, sigma, np.nan)
    found = []
    start = 0
    for term, labels in owners:
        stop = start + len(term.effect.coefficients)
        given = np.array(term.given(labels))
        found.append(Coefficients(term, labels, values[start:stop] + given, sigma[start:stop]))
        start = stop
    left = value - columns @ np.nan_to_num(values)
    across = (columns * root[:, None])[~data.is_y]
    products = normal, across.T @ across
    moments = columns.T @ (root**2 * value), across.T @ (root * value)[~data.is_y]
    known_from = float((root * value) @ (root * value)), int(np.count_nonzero(root * value))
    compared = _two_axes(products, moments, known_from, owners)
    return Fit(
        recordings, model, data, tuple(found), inverse, left, weight, condition, tuple(compared),
        settled,
    )  # fmt: skip


def _two_axes(
    products: tuple[Array, Array],
    moments: tuple[Array, Array],
    data: tuple[float, int],
    owners: list[tuple[Term, tuple[str, ...]]],
) -> Iterator[tuple[Term, Difference]]:
    """Yield what each axis alone says of the terms that act on both.

    `products` (P, P) and `moments` (P,) are those over all data and over cross-elevations.
    """
    width = [len(term.effect.coefficients) for term, _ in owners]
    of_column = np.repeat([id(term) for term, _ in owners], width)
    whole, across = products
    for term in {id(term): term for term, _ in owners}.values():
        own, rest = (np.flatnonzero(one) for one in (of_column == id(term), of_column != id(term)))
        power = np.diag(across)[own], np.diag(whole - across)[own]
        if not (np.any(power[0] > 0) and np.any(power[1] > 1e-12 * power[0])):
            continue
        ro, oo, none = np.ix_(rest, own), np.ix_(own, own), np.zeros((len(own), len(own)))
        along = whole - across
        normal = np.block(
            [
                [whole[np.ix_(rest, rest)], across[ro], along[ro]],
                [across[ro].T, across[oo], none],
                [along[ro].T, none, along[oo]],
            ]
        )
        everything, of_x = moments
        seen = np.concatenate([everything[rest], of_x[own], (everything - of_x)[own]])
        total, rows = data
        apart = from_products(normal, seen, total, len(own), rows)
        if apart is not None:
            yield term, apart


def _expanded(
    recordings: Recordings, data: Stack, terms: list[Term]
) -> tuple[Array, list[tuple[Term, tuple[str, ...]]]]:
    """Return a column for every coefficient, (m, P), and the term and group of each set of them."""
    arrays = [np.zeros((len(data), 0))]
    owners = []
    for term in terms:
        basis = term_columns(data, term.effect, recordings)
        codes, names = group(recordings, term.per)
        for code, name in enumerate(names):
            arrays.append(basis * (codes[data.row] == code)[:, None])
            owners.append((term, name))
    return np.concatenate(arrays, axis=1), owners


def _weights(
    recordings: Recordings, data: Stack, columns: Array, value: Array
) -> tuple[Array, Array, bool]:
    """Return robust weights and the scatter [rad] of each number's antenna, session and axis.

    Last comes whether all weights came to rest.
    """
    codes, names = group(recordings, ("antenna", "session"))
    series: Codes = codes[data.row] * 2 + data.is_y
    weight, scatter, settled = np.ones(len(value)), np.ones(len(value)), True
    floors = [robust.rounding(value[data.is_y == is_y]) for is_y in (False, True)]
    for one in range(2 * len(names)):
        rows = np.flatnonzero(series == one)
        if len(rows) == 0:
            continue
        own = columns[rows][:, np.any(columns[rows] != 0, axis=0)]
        weight[rows], residual, rest = robust.weights(own, value[rows], REACH, floors[one % 2])
        settled &= rest
        rank = np.linalg.matrix_rank(own) if own.size else 0
        spare = max(1.0, float(weight[rows].sum()) - rank)
        own_scatter = np.sqrt(float((weight[rows] * residual**2).sum()) / spare)
        scatter[rows] = max(own_scatter, floors[one % 2], 1e-12)
    return weight, scatter, settled
