"""The oracle's own spread: how far apart its answers are when nothing that matters changes.

Two changes do not matter: computing with more digits (the build in which every REAL*4 is REAL*8),
and moving azimuth or altitude to the next REAL*4. A port that keeps more digits than the Fortran
cannot be held to anything narrower than what these answers span.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np

from pyport.parity.answers import of_oracle
from pyport.parity.points import Points, Real4


def spread(oracle: ModuleType, at: Points, answers: Real4) -> Real4:
    """Return the least and the greatest answer, shape (2, n, 5), NaN left out, among

    - the reference's `answers`;
    - the promoted build's at the same points, rounded to REAL*4;
    - the reference's with azimuth or altitude one ulp up or down.
    """  # noqa: D400 - the sentence goes on as a list
    low, high = np.float32(-np.inf), np.float32(np.inf)
    all_answers = [answers, of_oracle(oracle, at, promoted=True)]
    for side in (low, high):
        with np.errstate(over="ignore"):  # beyond the largest REAL*4 comes infinity
            az, alt = np.nextafter(at.az, side), np.nextafter(at.alt, side)
        all_answers += [of_oracle(oracle, at.moved(az=az)), of_oracle(oracle, at.moved(alt=alt))]
    return np.stack([np.fmin.reduce(all_answers), np.fmax.reduce(all_answers)])
