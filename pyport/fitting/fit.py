"""The fit of a model to recordings: least squares under the estimated noise."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import IO

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.errors import BadInput
from pyport.fitting.two_axes import Difference, from_products
from pyport.models.complete import Left, Solved, complete
from pyport.models.conditions import undetermined
from pyport.models.model import Model, Term
from pyport.mounts import ALTAZ
from pyport.noise.coefficients import equal, solve
from pyport.noise.covariance import Covariance
from pyport.noise.estimation.estimate import estimate
from pyport.noise.estimation.frame import Frame, frame
from pyport.recordings.schema import Recordings, Stack, group, stack, term_columns
from pyport.recordings.sky import with_nights, with_sessions
from pyport.runs.workers import one_thread


def completed(fit: Fit) -> Model:
    """Return the model with the fitted values in its terms; see `pyport.models`."""
    solved, start = [], 0
    for one in fit.coefficients:
        known = np.isfinite(one.value)
        change = np.where(known, one.value - np.array(one.term.given(one.labels)), 0.0)
        places = range(start, start + len(known))
        sigma = np.where(known, one.sigma, 0.0)
        solved.append(Solved(one.term, one.labels, change, sigma, places, known.tolist()))
        start += len(known)
    left = Left(fit.residual, fit.noise.used, fit.stack)
    return complete(fit.model, fit.recordings, solved, fit.covariance, by="fit", left=left)


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
    #: All coefficients in their order, less what the model gave, shape (P,): the shortest of those
    #: that the data do not distinguish.
    shortest: Array
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
    model = model.on(recordings.at.mount)
    terms = model.fitted(refit)
    recordings = in_sessions(recordings, terms)
    data = stack(recordings)
    value = data.value - data.spread(*model.offsets(recordings.at))
    columns, owners = expanded(recordings, data, terms)
    known = np.concatenate([np.zeros(0), *(term.effect.precision for term, _ in owners)])
    if wrong := undetermined(len(value), int((known == 0).sum())):
        raise BadInput(wrong, recordings.file)
    noise = WEIGHTS[weights](value, columns[:, known == 0], frame(recordings, data))
    solution = solve(noise, columns, value, known)
    sigma = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
    values, sigma = (np.where(solution.known, one, np.nan) for one in (solution.values, sigma))
    found = []
    start = 0
    for term, labels in owners:
        stop = start + len(term.effect.coefficients)
        given = np.array(term.given(labels))
        found.append(Coefficients(term, labels, values[start:stop] + given, sigma[start:stop]))
        start = stop
    left = value - columns @ solution.values
    white = noise.whiten(np.concatenate([columns, value[:, None]], axis=1))
    across = noise.whiten(columns * ~data.is_y[:, None])
    compared = _two_axes(white, across, int(noise.used.sum()), owners)
    return Fit(
        recordings,
        model,
        data,
        tuple(found),
        solution.values,
        solution.covariance,
        noise,
        left,
        noise.weights,
        solution.condition,
        tuple(compared),
    )


def in_sessions(recordings: Recordings, terms: Collection[Term]) -> Recordings:
    """Return recordings with the sessions that noise departs by, nights where none are recorded.

    Labels of hardly a row each are none, unless a term has coefficients for each of them.
    """
    own = any(term.of_session for term in terms)
    return (with_nights if own else with_sessions)(recordings)


def _two_axes(
    white: Array, across: Array, rows: int, owners: list[tuple[Term, tuple[str, ...]]]
) -> Iterator[tuple[Term, Difference]]:
    """Yield what each axis alone says of the terms that act on both.

    `white` (n, P + 1) holds the whitened columns and, last, the data, `across` (n, P) what the
    columns do in cross-elevation alone; `rows` is the number of readings that are no outliers.
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


def expanded(
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


def off_by(
    recordings: Recordings, stack: Stack, left: Array, used: NDArray[np.bool_]
) -> tuple[tuple[int, str], ...]:
    """Return the line of each outlier among m readings and what is the matter with it.

    `left` (m,) is what is left of the readings [rad], `used` (m,) is false for an outlier.
    """
    names = recordings.at.mount.names
    return tuple(
        (
            int(recordings.line[stack.row[n]]),
            f"{names[int(stack.is_y[n])]} off by {left[n] / ARCSEC:.1f} arcsec",
        )
        for n in np.flatnonzero(~used)
    )


#: Labels that residuals are summed up by.
LABELS = ("source", "session")
#: More groups than this go into the JSON only.
MOST_PRINTED = 40


def by_label(fit: Fit, label: str) -> list[dict[str, object]]:
    """Return count, mean and rms of both axes for every value of a label, largest rms first.

    Arcseconds; outliers without weight do not count. Empty where there is no such label.
    """
    values = fit.recordings.label(label).astype(str)
    if len(np.unique(values)) < 2:
        return []
    groups: list[dict[str, object]] = []
    for value in np.unique(values):
        group: dict[str, object] = {label: str(value)}
        rows = (values[fit.stack.row] == value) & fit.noise.used
        for axis, is_y in (("xel", False), ("el", True)):
            left = fit.residual[rows & (fit.stack.is_y == is_y)] / ARCSEC
            group[f"{axis}_offsets"] = len(left)
            group[f"{axis}_mean_arcsec"] = float(left.mean()) if len(left) else None
            group[f"{axis}_rms_arcsec"] = float(np.sqrt(np.mean(left**2))) if len(left) else None
        groups.append(group)
    return sorted(groups, key=lambda group: -_rms(group))


def _rms(group: dict[str, object]) -> float:
    across, along = (group[f"{axis}_rms_arcsec"] for axis in ("xel", "el"))
    return math.hypot(*(one if isinstance(one, float) else 0.0 for one in (across, along)))


def leftover_text(fit: Fit) -> Iterator[str]:
    """Yield tables of the residuals by label, for labels with a handful of values."""
    mount = fit.recordings.at.mount
    axes = "across and along elevation" if mount is ALTAZ else f"in {' and in '.join(mount.names)}"
    for label in LABELS:
        groups = by_label(fit, label)
        if not groups or len(groups) > MOST_PRINTED:
            continue
        width = max(len(str(group[label])) for group in groups)
        yield ""
        yield f"residuals by {label}: offsets, mean and rms [arcsec] {axes}"
        for one in groups:
            cells = [_cell(one, axis) for axis in ("xel", "el")]
            yield f"  {one[label]!s:{max(width, 8)}s} {'   '.join(cells)}"


def _cell(group: dict[str, object], axis: str) -> str:
    number = group[f"{axis}_offsets"]
    mean, rms = group[f"{axis}_mean_arcsec"], group[f"{axis}_rms_arcsec"]
    if mean is None or rms is None:
        return f"{0:4d} {'':8s} {'':7s}"
    return f"{number:4d} {mean:+8.2f} {rms:7.2f}"


def write_rows(fit: Fit, file: IO[str]) -> None:
    """Write a line for every measured offset: what is left of it, and its weight."""
    at = fit.recordings.at
    labels = [name for name in ("antenna", *LABELS) if name in at]
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["line", "axis", *labels, "az_deg", "el_deg", "residual_arcsec", "weight"])
    for n in np.lexsort((fit.stack.is_y, fit.stack.row)):
        row = fit.stack.row[n]
        writer.writerow(
            [
                int(fit.recordings.line[row]),
                "el" if fit.stack.is_y[n] else "xel",
                *(at.column(name)[row] for name in labels),
                f"{at.az[row] / DEG:.6f}",
                f"{at.el[row] / DEG:.6f}",
                f"{fit.residual[n] / ARCSEC:.3f}",
                f"{fit.weight[n]:.4f}",
            ]
        )
