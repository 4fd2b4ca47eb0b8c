"""The columns that a look works on: the model's and every effect's, weighed, for one antenna."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.diagnosis import candidates as listing
from pyport.diagnosis.candidates import Candidate, Untestable
from pyport.least_squares import robust
from pyport.models.model import Model, Term
from pyport.recordings.schema import Recordings, Stack, group, stack, term_columns


@dataclass(frozen=True)
class Column:
    """A column of the model: its term, which coefficient, and the labels of its group."""

    term: Term
    coefficient: int
    labels: tuple[str, ...]


@dataclass(frozen=True)
class Design:
    """What one antenna's recordings could show."""

    #: `recordings`, `stack`: the antenna's recordings and their m measured numbers.
    recordings: Recordings
    stack: Stack
    noise: Array  #: one-sigma noise of each number [rad], shape (m,)
    how: str  #: where the noise is taken from, in words
    #: `base`, `columns`: columns of the model, shape (m, P), and what each is.
    base: Array
    columns: tuple[Column, ...]
    #: `others`, `candidates`, `untestable`: columns of all effects, shape (m, K), what they are,
    #: and what cannot be seen.
    others: Array
    candidates: tuple[Candidate, ...]
    untestable: tuple[Untestable, ...]

    def of(self, candidate: Candidate) -> Array:
        """Return a candidate's columns, each divided by the noise, shape (m, k)."""
        return self.others[:, candidate.columns] / self.noise[:, None]

    @property
    def model(self) -> Array:
        """Return the model's columns, each divided by the noise, shape (m, P)."""
        return self.base / self.noise[:, None]


def design(recordings: Recordings, model: Model, noise: float | None = None) -> Design:
    """Return the columns of a model and of the catalogue for recordings of one antenna.

    `recordings`, `model`: what was observed, and what would be fitted to it.
    `noise`: one-sigma error of an offset [rad]; None for the scatter that the model leaves, or the
      file's own errors where those are larger.
    """
    data = stack(recordings)
    base, columns = _base(recordings, data, model)
    others, candidates, untestable = listing.design(recordings, data)
    sigma, how = _noise(recordings, data, base, model, noise)
    return Design(
        recordings,
        data,
        sigma,
        how,
        base,
        tuple(columns),
        others,
        tuple(candidates),
        tuple(untestable),
    )


def _base(recordings: Recordings, data: Stack, model: Model) -> tuple[Array, list[Column]]:
    arrays, found = [np.zeros((len(data), 0))], []
    for term in model.fitted():
        basis = term_columns(data, term.effect, recordings)
        codes, names = group(recordings, term.per)
        for code, labels in enumerate(names):
            arrays.append(basis * (codes[data.row] == code)[:, None])
            found += [Column(term, k, labels) for k in range(basis.shape[1])]
    return np.concatenate(arrays, axis=1), found


def _noise(
    recordings: Recordings, data: Stack, base: Array, model: Model, given: float | None
) -> tuple[Array, str]:
    if given is not None:
        return np.full(len(data), given), "as given"
    told = data.spread(recordings.sigma_x, recordings.sigma_y)
    trusted = bool(np.isfinite(told).all())
    sigma = told.copy() if trusted else np.ones(len(data))
    value = data.value - data.spread(*model.offsets(recordings.at))
    enlarged = not trusted
    for axis in (data.is_y, ~data.is_y):
        if not axis.any():
            continue
        columns = base[axis] / sigma[axis, None]
        weighed = value[axis] / sigma[axis]
        left = weighed - columns @ np.linalg.lstsq(columns, weighed, rcond=1e-9)[0]
        rank = np.linalg.matrix_rank(columns) if columns.size else 0
        spare = max(1, len(left) - rank)
        scatter = robust.scale(left) * np.sqrt(len(left) / spare)
        enlarged |= scatter > 1
        sigma[axis] *= max(scatter, 1.0 if trusted else 1e-12)
    if not trusted:
        return sigma, "the scatter that the model leaves"
    own = "the file's own errors"
    return sigma, f"{own}, enlarged to the scatter that the model leaves" if enlarged else own
