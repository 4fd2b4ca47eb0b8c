"""A simulated campaign, made once."""

import numpy as np
import pytest

from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.rt32_campaign import rt32_campaign
from pyport.recordings import read
from pyport.studies.rt32 import METHODS, box_step, fit_rt32
from pyport.studies.rt32.fit import honest_sigmas


@pytest.fixture(scope="session")
def case():
    """Return the two campaigns and the truth about them."""
    return rt32_campaign(0)


@pytest.fixture(scope="session")
def campaign(case, tmp_path_factory):
    """Return the campaigns as a user reads them."""
    path = tmp_path_factory.mktemp("rt32") / "campaign.csv"
    write_recordings(case, path)
    return read(path)


@pytest.fixture(scope="session")
def errors(case):
    """Return what each offset is off by [arcsec]."""
    return np.array(case.truth["error_arcsec"])


@pytest.fixture(scope="session")
def fits(campaign):
    """Return the fit by each method, the step of the box offset subtracted, and honest sigmas."""
    found = {m: fit_rt32(campaign, method=m, box=box_step(campaign)) for m in METHODS}
    return {method: (fit, honest_sigmas(fit)) for method, fit in found.items()}


@pytest.fixture(scope="session")
def document(fits):
    """Return the fit by the document's method."""
    return fits["document"][0]


@pytest.fixture(scope="session")
def honest(fits):
    """Return its sigmas by sessions."""
    return fits["document"][1]


@pytest.fixture(scope="session")
def short(tmp_path_factory):
    """Return the file of a shorter campaign."""
    path = tmp_path_factory.mktemp("rt32") / "short.csv"
    write_recordings(rt32_campaign(1, 1200), path)
    return path
