"""Places: displacements read off leans, and a survey that tells them from the mounts' own."""

import numpy as np
import pytest
from diagnosis.arrays.made_array import array, case, names

from pyport.angles import ARCMIN
from pyport.diagnosis.arrays.places import metres_per_radian
from pyport.diagnosis.arrays.report import report
from pyport.effects import Site
from pyport.errors import BadInput
from pyport.recordings.files import Survey

EAST_M = np.array([0, 300, -400, 900, 2500, 5200, 9000, -1500, -4000, -7500, 150, -800.0])
SURVEY = Survey("survey.csv", tuple(names(len(EAST_M))), EAST_M)


@pytest.mark.parametrize(
    ("both_axes", "sessions", "decs_deg"),
    [(False, 1, (40.0,)), (False, 3, (40.0,)), (True, 2, (40.0, -10.0, 65.0))],
)
def test_displacements_come_back_in_metres(both_axes, sessions, decs_deg):
    """Antennas stand where they were put, within their errors, on one axis or both."""
    made = array(EAST_M, both_axes=both_axes, sessions=sessions, decs_deg=decs_deg)[0]
    places = report(*case(made)).places

    miss = places.east_m - (EAST_M - np.median(EAST_M))
    miss -= miss.mean()

    assert places.antennas == tuple(names(len(EAST_M)))
    assert np.sqrt(np.mean((miss / places.sigma_m) ** 2)) < 1.6
    assert np.all(places.sigma_m < 1500)


@pytest.mark.slow
def test_a_survey_names_the_site():
    """Leans that grow with distance are the wrong site, and each mount's own lean is told."""
    made = array(EAST_M, lean=0.5, seed=1)[0]
    found = report(*case(made), SURVEY).comparison

    assert found.is_the_site
    assert abs(found.slope - 1) < 3 * found.slope_sigma
    assert found.correlation > 0.93
    assert found.delta_bic > 10
    assert found.lean_m / metres_per_radian(Site(0.6)) / ARCMIN == pytest.approx(0.5, rel=0.7)
    assert found.unseen_m[1] < found.unseen_m[0] / 2
    assert np.mean(np.abs(found.misses) < 2) > 0.8


def test_leaning_mounts_are_no_site():
    """Leans that have nothing to do with the places are not called a wrong site."""
    for seed in range(6):
        made = array(np.zeros(len(EAST_M)), lean=2.0, seed=seed, sessions=1)[0]

        assert not report(*case(made), SURVEY).comparison.is_the_site


@pytest.mark.slow
def test_errors_cover_the_scatter_over_many_arrays():
    """The slope is off by its sigma, neither much more nor much less."""
    pulls = []
    for seed in range(12):
        made = array(EAST_M, lean=0.6, seed=seed, sessions=1)[0]
        found = report(*case(made), SURVEY).comparison
        pulls.append((found.slope - 1) / found.slope_sigma)

    assert 0.4 < np.sqrt(np.mean(np.square(pulls))) < 1.8


def test_an_antenna_told_poorly_is_not_used():
    """Errors alone decide, before any survey is looked at."""
    made = array(EAST_M, sessions=2, seed=3)[0]
    antenna, rng = made.at.column("antenna"), np.random.default_rng(0)
    made.y[antenna == "A04"] += 12 * ARCMIN * rng.normal(size=(antenna == "A04").sum())
    found = report(*case(made), SURVEY)

    assert [
        n for n, u in zip(found.places.antennas, found.places.usable, strict=True) if not u
    ] == ["A04"]
    assert "A04" not in found.comparison.antennas


def test_a_survey_of_other_antennas_is_refused():
    """A survey that holds none of the antennas cannot be compared with."""
    made = array(EAST_M, sessions=1)[0]
    with pytest.raises(BadInput, match="none of the recorded antennas"):
        report(*case(made), Survey("survey.csv", ("X1", "X2"), np.array([0.0, 1.0])))


def test_recordings_of_one_antenna_are_no_array():
    """A single telescope has no array's report, and a survey of it is refused."""
    made = array(EAST_M[:1], sessions=2)[0]
    problem, fit = case(made)

    assert report(problem, fit) is None
    with pytest.raises(BadInput, match="too few antennas"):
        report(problem, fit, SURVEY)
