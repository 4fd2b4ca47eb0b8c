"""Checks before a name is spoken: one strength everywhere, and the size that physics fixes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.case import Problem, WhitenedData
from pyport.diagnosis.identify import agrees
from pyport.diagnosis.joint import Joint, contribution
from pyport.least_squares.gram import Gram
from pyport.thresholds import REFUTES, SAME_STRENGTH


@dataclass(frozen=True)
class Check:
    """A check, whether it was passed, and its outcome in words."""

    passed: bool
    words: str


def halves(setup: Problem, weighed: WhitenedData, joint: Joint, choice: int) -> list[Check]:
    """Compare an effect's strength in halves of the data, with everything else refitted.

    The fitted curve of the effect gets a second coefficient that acts in one
    half only; one means the same strength, so the second must come out zero.
    """
    curve = contribution(setup, joint, choice)
    found = []
    for label, mask in _halves(setup).items():
        if np.abs(curve[mask]).max(initial=0) == 0 or np.abs(curve[~mask]).max(initial=0) == 0:
            continue
        others = setup.expanded([c for n, c in enumerate(joint.choices) if n != choice])
        columns = np.concatenate(
            [others, curve[:, None], (curve * mask)[:, None], setup.residual[:, None]], axis=1
        )
        white = weighed.covariance.whiten(columns)
        found.append(_compare(white, label))
    return [check for check in found if check is not None]


def _compare(white: Array, label: str) -> Check | None:
    from pyport.least_squares.gram import Part

    gram = Gram.of(white, np.zeros(len(white), np.intp), 1)
    size = white.shape[1] - 1
    solution = gram.solve([Part(np.arange(size), np.zeros(1, np.intp))])
    if not solution.known[-2:].all():
        return None
    extra, sigma = solution.values[-1], float(np.sqrt(solution.covariance[-1, -1]))
    differs = abs(extra) > REFUTES * sigma and abs(extra) > SAME_STRENGTH
    words = f"strength in {label}: {1 + extra:+.2f} +- {sigma:.2f} of the rest's"
    return Check(not differs, words)


def _halves(setup: Problem) -> dict[str, NDArray[np.bool_]]:
    """Return the halves that the readings can be split into."""
    at, row = setup.recordings.at, setup.stack.row
    found = {
        "the upper half in elevation": (at.el > np.median(at.el))[row],
        "the eastern half of the sky": (np.sin(at.az) > 0)[row],
    }
    if "time" in at:
        time = np.asarray(at.column("time"), float)
        if np.isfinite(time).all() and np.ptp(time) > 0:
            found["the later half"] = (time > np.median(time))[row]
    if setup.stack.is_y.any() and not setup.stack.is_y.all():
        found["elevation"] = setup.stack.is_y
    return found


def known(value: float, sigma: float, expected: float, what: str) -> Check:
    """Compare a coefficient with the value that physics fixes."""
    words = f"{what} = {value:.4g} +- {sigma:.2g}, physics says {expected:.4g}"
    return Check(agrees(value, sigma, expected), words)
