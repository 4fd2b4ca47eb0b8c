"""Real recordings: the GMRT of June 2003 as an array, beside its survey."""

import numpy as np
import pytest
from diagnosis.arrays.made_array import case
from samples import sample

from pyport.angles import ARCMIN
from pyport.diagnosis.arrays.repeat import medians
from pyport.diagnosis.arrays.report import SCAN, report
from pyport.diagnosis.arrays.words import predict
from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.recordings import read
from pyport.recordings.files import read_survey
from pyport.studies.gmrt import array as gmrt_array


@pytest.fixture(scope="module")
def june():
    """Return what the three days of Cyg A say of the array."""
    return report(*case(read(gmrt_array.TOGETHER), gmrt_array.MODEL))


@pytest.mark.slow
def test_scans_have_a_tag_that_changes_and_play_that_repeats(june):
    """Each day's play is what the other days' say, while the day's tag is its own."""
    tags = {one.name: one.tag for one in june.sessions}
    days = june.repeats[SCAN]

    assert len(days) == len(tags) == 3
    for day in days:
        assert day.correlation > 0.9
        assert day.left < day.size / 2
        # the same tag when play comes from the other days
        assert day.common / june.rate == pytest.approx(tags[day.session][0], abs=0.5)
    values = [value for value, _ in tags.values()]
    assert np.ptp(values) > 20 * max(sigma for _, sigma in tags.values())


def test_antenna_days_are_predicted_twice_as_well(june):
    """From other days and other antennas the median antenna's rms falls by two or more."""
    for session in june.unseen.sessions:
        assert medians(june.unseen.of(session)).factor > 2
    assert medians(june.unseen.of("2003-06-01")).factor > 3


@pytest.mark.slow
@pytest.mark.parametrize("name", gmrt_array.PLACED)
def test_antennas_stand_where_they_were_surveyed(name):
    """Recordings alone place the antennas, all 12 km of an arm, to a kilometre or two."""
    survey = read_survey(sample("gmrt/antennas_enu.csv"))
    found = report(*case(read(name), gmrt_array.MODEL), survey).comparison

    assert found.correlation >= 0.93
    assert abs(found.slope - 1) <= 0.15
    assert found.is_the_site
    assert len(found.antennas) > 24
    assert np.mean(np.abs(found.misses) <= 2) > 0.9


@pytest.mark.slow
def test_the_crab_follows_from_cygnus(june):
    """At another declination the parts predict better than the paper's form fits the day itself."""
    crab = diagnose(read("gmrt-2003-05-31"), load(gmrt_array.MODEL))
    one = medians(predict(june, crab.problem, crab.after).days)

    assert one.after < ARCMIN
    assert one.after < one.fitted_before / 2
