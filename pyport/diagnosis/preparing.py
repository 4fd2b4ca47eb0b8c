"""Preparing: recordings, model and candidates, brought into the form that the search works on."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis import candidates as listing
from pyport.diagnosis.candidates import Blocks, Candidate
from pyport.diagnosis.case import Chosen, Problem
from pyport.fitting.fit import expanded, in_sessions
from pyport.models.model import Model, Term
from pyport.noise.estimation.frame import frame
from pyport.noise.pointings import pointings
from pyport.recordings.schema import Recordings, Stack, group, stack
from pyport.runs.stages import stage
from pyport.thresholds import FEWEST


@stage("preparing columns")
def prepare(
    recordings: Recordings, model: Model, refit: Collection[str] | None = None, seed: int = 0
) -> Problem:
    """Bring recordings and a model into the form that the search works on.

    Parameters
    ----------
    recordings, model
        The measurements, and the model whose gaps are looked for.
    refit
        Ids of the model's effects that are fitted together with every
        candidate; None for all of them.
    seed
        Of the draws of noise.
    """
    terms = model.fitted(refit)
    recordings = in_sessions(recordings, terms)
    data = stack(recordings)
    residual = data.value - data.spread(*model.offsets(recordings.at))
    base_columns, base = _base(recordings, data, terms)
    found, candidates, untestable = listing.design(recordings, data, beside=base_columns)
    given = frame(recordings, data)
    departing = any(one.of == "session" for one in given.departures)
    if departing:
        candidates = listing.but_of_every_session(candidates)
    first = base_columns.shape[1]
    own = any(term.of_session for term in terms)
    block_of_row, names = group(recordings, ("antenna", "session"))
    # Among sessions that depart at random what each has of its own is no effect but their scatter,
    # and sessions of a few readings have nothing to themselves.
    if (departing or FEWEST * len(names) > len(data)) and not own:
        block_of_row, names = group(recordings, ("antenna",))
    return Problem(
        recordings=recordings,
        model=model,
        stack=data,
        base=tuple(base),
        candidates=_shifted(candidates, first),
        untestable=tuple(untestable),
        data=np.concatenate([base_columns, found, residual[:, None]], axis=1),
        blocks=Blocks(
            np.array([n[0] for n in names]), np.array([n[1] if len(n) > 1 else "" for n in names])
        ),
        block=block_of_row[data.row],
        session=group(recordings, ("session",))[0][data.row],
        pointing=pointings(recordings)[data.row],
        scan=_scans(recordings, data),
        frame=given,
        seed=seed,
    )


def _scans(recordings: Recordings, data: Stack) -> Codes:
    """Give each scan a number; where no time is known every pointing is one of its own."""
    if "time" not in recordings.at:
        return np.arange(len(data))
    time = np.nan_to_num(np.asarray(recordings.at.column("time"), float), nan=-1.0)
    session, _ = group(recordings, ("session",))
    keys = np.stack([session[data.row], time[data.row], data.is_y])
    return np.unique(keys, axis=1, return_inverse=True)[1].ravel()


def _shifted(candidates: list[Candidate], by: int) -> tuple[Candidate, ...]:
    return tuple(replace(one, columns=one.columns + by) for one in candidates)


def _base(recordings: Recordings, data: Stack, terms: Sequence[Term]) -> tuple[Array, list[Chosen]]:
    """Return the columns of the refitted terms; labels beyond the blocks split the columns."""
    arrays: list[Array] = [np.zeros((len(data), 0))]
    found: list[Chosen] = []
    start = 0
    for term in terms:
        other = tuple(label for label in term.per if label not in ("antenna", "session"))
        columns, owners = expanded(recordings, data, [replace(term, per=other)])
        arrays.append(columns)
        scope = " and ".join(label for label in ("antenna", "session") if label in term.per)
        width = columns.shape[1]
        coefficients = tuple(range(len(term.effect.coefficients))) * len(owners)
        candidate = Candidate(term.effect, np.arange(start, start + width), coefficients)
        found.append(Chosen(candidate, scope or "all"))
        start += width
    return np.concatenate(arrays, axis=1), found
