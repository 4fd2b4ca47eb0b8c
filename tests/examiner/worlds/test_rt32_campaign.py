"""The stand-in for the RT32's unpublished offsets is as large and as bad as they were."""

import numpy as np
import pytest

from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.kinds import make_case
from pyport.examiner.worlds.rt32_campaign import rt32_campaign


@pytest.fixture(scope="module")
def case():
    """Return a campaign."""
    return rt32_campaign(3)


def test_counts_and_seasons_are_the_documents(case):
    """2758 altitude and 2857 azimuth offsets, from March to June 2003 and January to May 2004."""
    altitude = np.isfinite(case.columns["d_el_deg"])
    day = np.array([str(one)[:10] for one in case.columns["time_utc"]], "datetime64[D]")

    assert altitude.sum() == 2758
    assert np.isfinite(case.columns["d_az_deg"]).sum() == 2857
    assert day.min() >= np.datetime64("2003-03-15")
    assert day.max() <= np.datetime64("2004-05-06")
    assert not ((day > np.datetime64("2003-06-12")) & (day < np.datetime64("2004-01-29"))).any()


def test_two_thirds_lie_within_the_level_at_the_published_rms(case):
    """Errors below 0.007 deg are about 3700 and have an rms of about 12.8 arcsec."""
    error = np.abs(case.truth["error_arcsec"])
    small = error[error < 0.007 * 3600]

    assert 3500 < len(small) < 3950
    assert np.sqrt(np.mean(small**2)) == pytest.approx(12.8, abs=0.5)


def test_the_file_says_that_it_is_simulated(case, tmp_path):
    """The first line that any reader sees is the warning."""
    write_recordings(case, tmp_path / "campaign.csv")

    assert "no telescope measured this" in (tmp_path / "campaign.csv").open().readline()


def test_it_can_be_asked_for_by_name():
    """`trials make --kind rt32-campaign` gives the same campaign."""
    asked, made = make_case("rt32-campaign", 3, rows=200), rt32_campaign(3, 200)

    np.testing.assert_array_equal(asked.columns["d_az_deg"], made.columns["d_az_deg"])
