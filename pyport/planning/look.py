"""A look at recordings: coverage of the sky, what can be distinguished, what to observe next."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis.candidates import Untestable
from pyport.errors import BadInput
from pyport.models.model import Model
from pyport.planning.design import Coverage, Design, coverage, design
from pyport.planning.separate import Separation, separate, sigmas
from pyport.planning.suggest import (
    Direction,
    Promise,
    directions,
    of_sources,
    suggest,
    within_reach,
)
from pyport.recordings.schema import Recordings
from pyport.runs.workers import one_thread

#: Of more recordings than this as many are looked at, chosen at random.
MOST = 4000
#: Elevations that are suggested unless lower or higher ones were observed [deg].
LOWEST_DEG, HIGHEST_DEG = 10.0, 85.0
#: A noise of more arcseconds, or one over as many, is a slip of the pen.
MOST_NOISE = 1e9


@dataclass(frozen=True)
class Known:
    """A coefficient of the model: its error, and how many times the other terms enlarge it."""

    name: str
    sigma: float
    unit: str
    inflation: float


@dataclass(frozen=True)
class Look:
    """What recordings could show before anything is fitted to them.

    `antenna` is the one that was looked at, of `antennas`; `noise` [rad] the
    median one-sigma error, `how` where it is taken from.
    """

    recordings: Recordings
    model: Model
    antenna: str
    antennas: int
    noise: float
    how: str
    coverage: Coverage
    known: tuple[Known, ...]
    condition: float
    separation: Separation
    untestable: tuple[Untestable, ...]
    next: tuple[Direction, ...]
    promises: tuple[Promise, ...]

    @property
    def elevations(self) -> tuple[float, float]:
        """Return the lowest and the highest elevation observed [deg]."""
        el = self.recordings.at.el / DEG
        return float(el.min()), float(el.max())


@one_thread
def look(
    recordings: Recordings,
    model: Model,
    *,
    noise_arcsec: float | None = None,
    count: int = 6,
    elevations: tuple[float, float] | None = None,
    sources: bool = False,
) -> Look:
    """Return what recordings could show: coverage, separable effects, what to observe next.

    `recordings`, `model`: what was observed, and the model that would be fitted. Of an array, the
      antenna with the most recordings is looked at.
    `noise_arcsec`: one-sigma error of an offset; None for the scatter that the model leaves, or the
      file's own errors where those are larger.
    `count`: how many directions to suggest.
    `elevations`: lowest and highest elevation [deg] that may be suggested.
    `sources`: suggest the recorded sources at other hour angles, not just directions.

    Raises `BadInput`: no instrument has such a noise.
    """
    antenna, antennas = busiest(recordings)
    model = model.on(recordings.at.mount)
    own = recordings.take(recordings.label("antenna").astype(str) == antenna)
    if noise_arcsec is not None and not 1 / MOST_NOISE < noise_arcsec < MOST_NOISE:
        wanted = f"expected between {1 / MOST_NOISE:g} and {MOST_NOISE:g}"
        raise BadInput(f"the noise is {noise_arcsec:g} arcsec, {wanted}")
    noise = None if noise_arcsec is None else noise_arcsec * ARCSEC
    made = thinned(own, model, noise)
    found = separate(made)
    el = own.at.el / DEG
    low, high = elevations or (
        float(min(LOWEST_DEG, max(el.min(), 1.0))),
        float(max(HIGHEST_DEG, el.max())),
    )
    recorded = of_sources(own, low, high) if sources else None
    targets = within_reach(own.at, directions(low, high) if recorded is None else recorded)
    ahead, promises = suggest(made, found.pairs, targets, count)
    known, condition = _known(made)
    return Look(
        recordings=own,
        model=model,
        antenna=antenna,
        antennas=antennas,
        noise=float(np.median(made.noise) * np.sqrt(len(own) / len(made.recordings))),
        how=made.how,
        coverage=coverage(own.at.az, own.at.el, low),
        known=known,
        condition=condition,
        separation=found,
        untestable=made.untestable,
        next=ahead,
        promises=promises,
    )


def thinned(recordings: Recordings, model: Model, noise: float | None) -> Design:
    """Return the design of recordings, of many that of a choice which weighs as much."""
    share = MOST / max(len(recordings), MOST)
    if share < 1:
        chosen = np.sort(np.random.default_rng(0).permutation(len(recordings))[:MOST])
        recordings = recordings.take(chosen)
    made = design(recordings, model, noise)
    return replace(made, noise=made.noise * np.sqrt(share))


def busiest(recordings: Recordings) -> tuple[str, int]:
    """Return the antenna with the most recordings, and how many antennas there are."""
    names, counts = np.unique(recordings.label("antenna").astype(str), return_counts=True)
    return str(names[np.argmax(counts)]), len(names)


def _known(made: Design) -> tuple[tuple[Known, ...], float]:
    """Return the errors of the model's coefficients, and the condition number."""
    columns = made.model
    sigma, condition = sigmas(columns)
    length = np.linalg.norm(columns, axis=0)
    found = []
    for n, column in enumerate(made.columns):
        found.append(
            Known(
                column.name,
                float(sigma[n] / abs(column.of.scale)),
                column.of.unit,
                float(sigma[n] * length[n]) if np.isfinite(sigma[n]) else math.inf,
            )
        )
    return tuple(found), condition
