"""What is wrong with the fits of a diagnosis, if anything is."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pyport.diagnosis.joint import Joint
from pyport.diagnosis.search import MOST_FINDINGS
from pyport.fitting.soundness import doubts

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
