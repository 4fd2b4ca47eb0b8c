"""The published table against the routines, by the program's own diagnosis."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.formats import models
from pyport.recordings.files import read
from pyport.steering.published import write_recordings


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Return the published extracts as recordings."""
    path = tmp_path_factory.mktemp("published") / "published.csv"
    write_recordings(path)
    return read(path)


@pytest.mark.slow
def test_diagnosis_names_the_missing_term(recordings):
    """Beside the routines the table holds refraction, 58 arcsec at 45 deg, and nothing else."""
    found = diagnose(recordings, models.load("rt32-3model"), refit=[])
    first = found.findings[0]

    assert len(found.findings) == 1
    assert first.effect == "refraction"
    assert first.parameters[0].value == pytest.approx(57.98, abs=0.05)
    assert 0 < first.parameters[0].sigma < 0.05


def test_what_is_left_is_the_rounding_of_the_print(recordings):
    """Before, an offset is off by 358 mdeg; after, nearly all lie within half a millidegree."""
    found = diagnose(recordings, models.load("rt32-3model"), refit=[])
    before, after = (np.abs(found.left(fit)) / ARCSEC for fit in (found.before, found.after))

    assert before.max() > 1280
    assert np.mean(after < 1.8) > 0.98
    assert after.max() < 4


def test_refraction_is_found_with_all_parameters_refitted_too(recordings):
    """The twelve parameters cannot hide it: it is named though most of it could be absorbed."""
    found = diagnose(recordings, models.load("rt32-3model"))

    assert found.findings[0].effect == "refraction"
