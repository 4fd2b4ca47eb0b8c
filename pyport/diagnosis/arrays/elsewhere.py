"""Recordings of another source or another time, predicted from an array's lasting parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pyport.diagnosis.arrays.blocks import Block, blocks
from pyport.diagnosis.arrays.repeat import Unseen, unseen
from pyport.diagnosis.arrays.report import ArrayReport, shared_shapes
from pyport.diagnosis.case import Problem
from pyport.diagnosis.joint import Joint
from pyport.threads import one_thread


@one_thread
def predict(known: ArrayReport, setup: Problem, fit: Joint) -> Unseen:
    """Predict other recordings of an array from recordings that are known.

    Own parts come from the known recordings alone, what a session's antennas
    share from its other antennas; zeros are fitted anew, on either side of
    every step that was found in the other recordings.

    Parameters
    ----------
    known
        What is known of the array.
    setup, fit
        The case of the recordings to predict, by the same model, and the fit of all found in it.
    """
    taken, stem = set(known.parts.sessions), setup.recordings.file.stem
    fitted, others = (
        _renamed(blocks(setup, fit, some), taken, stem) for some in (known.form, known.shapes)
    )
    return unseen(
        [*known.fitted, *fitted],
        [*known.blocks, *others],
        known.shapes,
        shared_shapes(known.shapes),
        sessions={one.session for one in others},
    )


def _renamed(some: Sequence[Block], taken: set[str], stem: str) -> list[Block]:
    """Return blocks whose sessions are called unlike those taken."""
    return [
        replace(one, session=f"{stem} {one.session}".strip()) if one.session in taken else one
        for one in some
    ]
