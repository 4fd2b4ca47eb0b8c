"""What is wrong with the fits of a diagnosis, and what is said where it finds nothing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pyport.diagnosis.guards import smallest_seen
from pyport.diagnosis.joint import Joint
from pyport.fitting.soundness import doubts
from pyport.thresholds import FAMILY_ERROR, MOST_FINDINGS

if TYPE_CHECKING:
    from pyport.diagnosis.diagnose import Diagnosis


def warnings(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence for everything that a user should know before trusting the numbers."""
    alone = list(_of(diagnosis, diagnosis.before))
    found = [f"fit of the model: {one}" for one in alone]
    if diagnosis.findings:
        both = (one for one in _of(diagnosis, diagnosis.after) if one not in alone)
        found += [f"fit with what was found: {one}" for one in both]
    if len(diagnosis.steps) >= MOST_FINDINGS:
        found.append(
            f"the search did not come to its end: it stopped at {MOST_FINDINGS} effects, and more "
            "may be left"
        )
    return found


def _of(diagnosis: Diagnosis, fit: Joint) -> Iterator[str]:
    """Yield what is wrong with one fit."""
    solution = fit.solution
    known = solution.known
    if not known.all():
        of_choice = np.repeat(np.arange(len(fit.choices)), np.diff(fit.starts))
        names = [fit.choices[n].candidate.effect.id for n in np.unique(of_choice[~known])]
        yield (
            f"{int((~known).sum())} of {len(known)} coefficients are not determined, of "
            f"{', '.join(dict.fromkeys(names))}"
        )
    yield from doubts(
        condition=solution.condition,
        covariance=solution.covariance[np.ix_(known, known)],
        numbers=int(diagnosis.weighed.used.sum()),
        rank=solution.rank,
    )


def nothing(diagnosis: Diagnosis) -> str:
    """Return what is said where no finding is: what was looked for, and how little was to be seen.

    No finding is no all-clear: few recordings show large effects only, and what is left may not
    look like noise though nothing that was tried predicts unseen data better.
    """
    seen = smallest_seen(diagnosis.detection_limits)
    more = "" if seen is None else f"; {seen}"
    if diagnosis.too_few is not None:
        return f"{diagnosis.too_few.sentence}{more}"
    if diagnosis.p_value > FAMILY_ERROR:
        return f"Nothing is missing that these recordings could show{more}"
    return (
        "What is left does not look like the noise that was assumed, but nothing that was tried "
        "predicts unseen data better"
    )
