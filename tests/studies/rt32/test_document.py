"""The document's figures beside a fit's, and what was put in beside what was found."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.angles import ARCSEC, DEG
from pyport.pointing import printed
from pyport.studies.rt32 import document as figures

pytestmark = pytest.mark.slow


def test_the_counts_and_the_rms_of_the_document_exclude_each_other():
    """Errors that get rarer with size have a larger rms than the document's within its level."""
    rows = sum(figures.ROWS)
    least = figures.least_rms(
        0.007 * DEG, figures.FITTED / rows, 0.01 * DEG, sum(figures.SMALL_ROWS) / rows
    )

    assert rows == 5615
    assert least > figures.RMS + 0.3 * ARCSEC


@given(st.lists(st.tuples(st.floats(0.05, 3), st.floats(0.1, 1)), min_size=1, max_size=4))
def test_no_errors_that_get_rarer_with_size_beat_the_bound(parts):
    """Mixtures of uniform errors, the building blocks of all such, have the least rms or more."""
    level, wider = 1.0, 1.4
    ends, shares = np.array(parts).T
    shares = shares / shares.sum()
    inside, within = (shares @ np.minimum(1, size / ends) for size in (level, wider))
    reach = np.minimum(ends, level)
    square = shares @ (reach**3 / 3 / ends) / inside

    assert np.sqrt(square) >= figures.least_rms(level, inside, wider, within) - 1e-12


def test_beside_the_document(document):
    """Counts, rms and correlations stand beside the document's own."""
    text = figures.beside(document)

    assert "3684 of 5615 (66%)" in text
    assert f"{document.inside.sum()} of 5615" in text
    assert "2376 of 2758 (86%)" in text
    first, second = (re.search(rf"{name}.*?(0\.\d\d, 0\.\d\d.*)", text)[1] for name in ("p4", "p8"))
    size = np.abs(document.correlation)
    assert first == f"{size[0, 2]:.2f}, {size[0, 3]:.2f}"
    assert second == f"{size[1, 6]:.2f}, {size[1, 7]:.2f}, {size[6, 7]:.2f}"


def test_what_was_put_in_stands_beside_what_was_found(document, honest, errors):
    """One line a campaign, with points, rms and the largest miss of Model3."""
    made = (document, honest, errors * ARCSEC)
    text = figures.recovered([made, made])
    line = text.splitlines()[2].split()
    miss = np.abs(document.values - printed()) / honest

    assert int(line[1]) == (np.abs(errors) <= 25.2).sum()
    assert int(line[2]) == document.inside.sum()
    assert float(line[4]) == pytest.approx(document.rms / ARCSEC, abs=0.006)
    assert float(line[6]) == pytest.approx(miss.max(), abs=0.006)
    assert f"at most {miss.max():.1f}" in text
    assert text.splitlines()[3].split()[1:] == line[1:]


def test_squares_of_azimuth_offsets_weigh_as_cos_h(document):
    """On the sky that is one over cos H, for the azimuth alone."""
    el = document.recordings.at.el[document.stack.row]
    is_y = document.stack.is_y

    np.testing.assert_array_equal(document.prior[is_y], 1)
    np.testing.assert_allclose(document.prior[~is_y] * np.cos(el[~is_y]), 1)
