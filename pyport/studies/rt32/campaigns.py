"""The two campaigns, and the step of the box offset between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG
from pyport.errors import BadInput
from pyport.recordings.schema import Recordings

#: 2004-01-01, after which the box offset was another [s, UTC since 1970].
_CHANGED_S = 1072915200.0

#: How much larger the box offset was before, and its error as the document has it [deg].
BOX_STEP_DEG, BOX_STEP_SIGMA_DEG = 0.017, 0.001


@dataclass(frozen=True)
class BoxStep:
    """What is done about the beam's having been moved."""

    earlier: NDArray[np.bool_]  #: which recordings were made before, shape (n,)
    step: float | None  #: the box offset before less that after [rad]; None to fit it


def box_step(recordings: Recordings, choice: str = "known") -> BoxStep:
    """Return the step to subtract, or to fit, where recordings lie on both sides of it.

    `recordings`: with times, or else they are taken to be of one campaign.
    `choice`: "known" for the document's 0.017 deg, "fit", or degrees as text.
    Raises `BadInput`: the choice is none of these.
    """
    if choice == "fit":
        step = None
    else:
        try:
            step = BOX_STEP_DEG * DEG if choice == "known" else float(choice) * DEG
        except ValueError:
            raise BadInput(
                f"the step of the box offset is {choice!r}, expected known, fit or degrees"
            ) from None
    earlier = np.zeros(len(recordings), bool)
    if "time" in recordings.at:
        earlier = np.asarray(recordings.at.column("time"), float) < _CHANGED_S
    if earlier.all():
        earlier = ~earlier
    return BoxStep(earlier, step)
