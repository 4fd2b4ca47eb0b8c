"""The fit of a model to recordings: least squares under the estimated noise."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.errors import BadInput
from pyport.fitting.two_axes import Difference, from_products
from pyport.models.model import Model, Term
from pyport.noise.coefficients import solve
from pyport.noise.covariance import Covariance
from pyport.noise.equal import equal
from pyport.noise.estimate import Frame, estimate, frame
from pyport.recordings.schema import Recordings, Stack, group, stack, term_columns
from pyport.recordings.sky import with_nights
from pyport.threads import one_thread

#: How readings count: by the noise that is estimated with the fit, or all alike.
WEIGHTS: dict[str, Callable[[Array, Array, Frame], Covariance]] = {
    "robust": estimate,
    "equal": equal,
}


@dataclass(frozen=True)
class Coefficients:
    """The fitted coefficients of one term for one group of rows."""

    term: Term  #: what they are of
    labels: tuple[str, ...]  #: values of the labels that the term is split by
    #: `value`, `sigma`: in internal units, shape (k,), what the model gave included; NaN where the
    #: data leave them open.
    value: Array
    sigma: Array


@dataclass(frozen=True)
class Fit:
    """A fitted model."""

    #: `recordings`, `model`, `stack`: what was fitted to what.
    recordings: Recordings
    model: Model
    stack: Stack
    coefficients: tuple[Coefficients, ...]  #: of every term and group
    covariance: Array  #: of all coefficients in their order, shape (P, P)
    noise: Covariance  #: the covariance of the readings that they were estimated under
    #: `residual`, `weight`: what is left of each number [rad] and its robust weight, shape (m,).
    residual: Array
    weight: Array
    condition: float  #: condition number of the design, columns scaled to unit length
    #: Terms that act on both axes, with what each axis alone says of their coefficients.
    two_axes: tuple[tuple[Term, Difference], ...] = ()


@one_thread
def fit(
    recordings: Recordings,
    model: Model,
    refit: Collection[str] | None = None,
    weights: str = "robust",
) -> Fit:
    """Fit a model's terms to recordings.

    The noise is estimated with it: scatter and its tails, drift, departures of sessions and
    sources. Sigmas hold all of them. With `weights` "equal" all readings count alike instead.

    Raises `BadInput`: there are fewer measured offsets than coefficients.
    """
    recordings, model = with_nights(recordings), model.on(recordings.at.mount)
    data = stack(recordings)
    value = data.value - data.spread(*model.offsets(recordings.at))
    terms = model.fitted(refit)
    columns, owners = _expanded(recordings, data, terms)
    if len(value) < columns.shape[1]:
        raise BadInput(
            f"{len(value)} measured offsets cannot determine {columns.shape[1]} coefficients",
            recordings.file,
        )
    noise = WEIGHTS[weights](value, columns, frame(recordings, data))
    solution = solve(noise, columns, value)
    sigma = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
    values, sigma = (np.where(solution.known, one, np.nan) for one in (solution.values, sigma))
    found = []
    start = 0
    for term, labels in owners:
        stop = start + len(term.effect.coefficients)
        given = np.array(term.given(labels))
        found.append(Coefficients(term, labels, values[start:stop] + given, sigma[start:stop]))
        start = stop
    left = value - columns @ np.nan_to_num(values)
    white = noise.whiten(np.concatenate([columns, value[:, None]], axis=1))
    across = noise.whiten(columns * ~data.is_y[:, None])
    compared = _two_axes(white, across, int(np.count_nonzero(noise.weights > 0)), owners)
    return Fit(
        recordings,
        model,
        data,
        tuple(found),
        solution.covariance,
        noise,
        left,
        noise.weights,
        solution.condition,
        tuple(compared),
    )


def _two_axes(
    white: Array, across: Array, rows: int, owners: list[tuple[Term, tuple[str, ...]]]
) -> Iterator[tuple[Term, Difference]]:
    """Yield what each axis alone says of the terms that act on both.

    `white` (n, P + 1) holds the whitened columns and, last, the data, `across` (n, P) what the
    columns do in cross-elevation alone; `rows` is the number of readings.
    """
    of_column = np.repeat(
        [id(term) for term, _ in owners], [len(term.effect.coefficients) for term, _ in owners]
    )
    columns, data = white[:, :-1], white[:, -1]
    for term in {id(term): term for term, _ in owners}.values():
        own = of_column == id(term)
        one, other = across[:, own], columns[:, own] - across[:, own]
        power = (one**2).sum(axis=0), (other**2).sum(axis=0)
        if not (np.any(power[0] > 0) and np.any(power[1] > 1e-12 * power[0])):
            continue
        apart = np.concatenate([columns[:, ~own], one, other], axis=1)
        found = from_products(
            apart.T @ apart, apart.T @ data, float(data @ data), int(own.sum()), rows
        )
        if found is not None:
            yield term, found


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
