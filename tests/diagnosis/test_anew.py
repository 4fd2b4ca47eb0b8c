"""What is left out has no part in any choice: member, moment, edge."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis import holdout
from pyport.diagnosis.folds import folds
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching.changes import columns_anew
from pyport.diagnosis.searching.search import search
from pyport.formats.models import load

HIDDEN = {
    "subreflector_jump": lambda at: 9 * (at.el > (45 + 8 * np.cos(at.az)) * DEG),
    "elevation_harmonics": lambda at: 7 * np.sin(5 * at.az),
}


@pytest.fixture(scope="module", params=list(HIDDEN))
def outcome(request):
    """Return the end of a search of which one effect is chosen."""
    made = recordings(400, 7, y=HIDDEN[request.param])
    found = search(prepare(made, load("altaz"), seed=1))
    assert request.param in {one.candidate.effect.id for one in found.chosen}
    return found


@pytest.mark.slow
def test_what_is_left_out_chooses_nothing(outcome):
    """Readings of no weight may say what they like."""
    problem, weighed = outcome.problem, outcome.weighed
    hidden = problem.session == 2
    covariance = replace(weighed.covariance, weights=np.where(hidden, 0.0, weighed.weights))
    data = np.where(hidden, 4000 * ARCSEC, problem.residual)
    absurd = replace(
        problem, data=np.column_stack([problem.whole[:, :-1], data]), added=None, memory={}
    )
    as_it_is = columns_anew(problem, covariance, outcome.chosen)
    beside_absurd = columns_anew(absurd, covariance, outcome.chosen)

    for one, other in zip(as_it_is, beside_absurd, strict=True):
        np.testing.assert_array_equal(one.columns, other.columns)


def test_predictions_are_made_with_what_the_others_choose(outcome):
    """No better than with what all chose, and near it where the effect is there."""
    problem, weighed = outcome.problem, outcome.weighed
    partition = folds(problem, weighed, outcome.chosen)
    left = holdout.residuals(problem, weighed, outcome.chosen, partition)
    found = np.sqrt(np.nanmean(left**2))
    alone = np.sqrt(np.nanmean(holdout.residuals(problem, weighed, (), partition) ** 2))

    assert 4.5 * ARCSEC < found < alone
