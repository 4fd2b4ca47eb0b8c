"""The columns that a look works on: the model's and every effect's, weighed, for one antenna."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array, separation
from pyport.diagnosis import candidates as listing
from pyport.diagnosis.candidates import Candidate, Untestable
from pyport.effects.base import Coefficient
from pyport.fitting.fit import expanded
from pyport.least_squares import robust
from pyport.models.model import Model, Term
from pyport.recordings.schema import Recordings, Stack, stack
from pyport.thresholds import FIRST_REACH

#: Height of a cell; cells of a band are as wide as to be of one area [deg].
CELL_DEG = 15.0
HOLES = 3


@dataclass(frozen=True)
class Hole:
    """A direction [deg] far from every recording, and how far."""

    az_deg: float
    el_deg: float
    distance_deg: float


@dataclass(frozen=True)
class Coverage:
    """Cells of equal area above an elevation [deg], how many hold a recording, and the holes."""

    lowest_deg: float
    cells: int
    covered: int
    holes: tuple[Hole, ...]


def coverage(az: Array, el: Array, lowest_deg: float) -> Coverage:
    """Return the coverage of the sky above an elevation.

    `az`, `el`: where recordings were taken [rad], shape (n,).
    `lowest_deg`: sky below this does not count.
    """
    centres = cells(lowest_deg)
    nearest = np.array([separation(a, e, az, el).min() for a, e in centres])
    covered = [bool(np.any(_inside(a, e, lowest_deg, az, el))) for a, e in centres]
    holes = []
    for _ in range(HOLES):
        far = int(np.argmax(nearest))
        if nearest[far] < CELL_DEG * DEG:
            break
        az_deg, el_deg = (float(angle / DEG) for angle in centres[far])
        holes.append(Hole(az_deg, el_deg, float(nearest[far] / DEG)))
        to_hole = separation(centres[far, 0], centres[far, 1], centres[:, 0], centres[:, 1])
        nearest = np.minimum(nearest, to_hole)
    return Coverage(lowest_deg, len(centres), sum(covered), tuple(holes))


def cells(lowest_deg: float) -> Array:
    """Return the centres (azimuth, elevation) [rad] of cells of nearly equal area, (cells, 2)."""
    found = []
    height = _height(lowest_deg)
    for band in range(round((90 - lowest_deg) / height)):
        el = lowest_deg + (band + 0.5) * height
        count = _around(el)
        found += [((n + 0.5) * 360 / count, el) for n in range(count)]
    return np.array(found) * DEG


def _height(lowest_deg: float) -> float:
    """Return the height of a band of cells [deg], so that whole bands reach the zenith."""
    return (90 - lowest_deg) / max(1, round((90 - lowest_deg) / CELL_DEG))


def _around(el_deg: float) -> int:
    return max(1, round(360 * np.cos(el_deg * DEG) / CELL_DEG))


def _inside(
    az: float, el: float, lowest_deg: float, azimuths: Array, elevations: Array
) -> NDArray[np.bool_]:
    """Tell which recordings lie in the cell about a centre."""
    count = _around(el / DEG)
    across = np.abs((azimuths - az + np.pi) % (2 * np.pi) - np.pi) <= np.pi / count
    return across & (np.abs(elevations - el) <= _height(lowest_deg) / 2 * DEG + 1e-9)


@dataclass(frozen=True)
class Column:
    """A column of the model: its term, which coefficient, and the labels of its group."""

    term: Term
    coefficient: int
    labels: tuple[str, ...]

    @property
    def of(self) -> Coefficient:
        """Return what its coefficient is."""
        return self.term.effect.coefficients[self.coefficient]

    @property
    def name(self) -> str:
        """Return the coefficient's name, with its group in brackets."""
        labels = " ".join(filter(None, self.labels))
        return self.of.name + (f"[{labels}]" if labels else "")


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
    base, owners = expanded(recordings, data, model.fitted())
    columns = (
        Column(term, k, labels)
        for term, labels in owners
        for k in range(len(term.effect.coefficients))
    )
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


def _noise(
    recordings: Recordings, data: Stack, base: Array, model: Model, given: float | None
) -> tuple[Array, str]:
    if given is not None:
        return np.full(len(data), given), "as given"
    recorded = data.spread(recordings.sigma_x, recordings.sigma_y)
    trusted = bool(np.isfinite(recorded).all())
    sigma = recorded.copy() if trusted else np.ones(len(data))
    value = data.value - data.spread(*model.offsets(recordings.at))
    enlarged = not trusted
    for axis in (data.is_y, ~data.is_y):
        if not axis.any():
            continue
        columns = base[axis] / sigma[axis, None]
        weighed = value[axis] / sigma[axis]
        left = robust.weights(columns, weighed, FIRST_REACH).residual
        rank = np.linalg.matrix_rank(columns) if columns.size else 0
        spare = max(1, len(left) - rank)
        scatter = robust.scale(left) * np.sqrt(len(left) / spare)
        enlarged |= scatter > 1
        sigma[axis] *= max(scatter, 1.0 if trusted else 1e-12)
    if not trusted:
        return sigma, "the scatter that the model leaves"
    own = "the file's own errors"
    return sigma, f"{own}, enlarged to the scatter that the model leaves" if enlarged else own
