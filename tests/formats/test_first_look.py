"""Real files are read as they are: what they hold comes out right."""

import numpy as np
import pytest
from samples import sample

from pyport.angles import ARCSEC, DEG
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.recordings import read
from pyport.recordings.raw import FileOptions

LMT = FileOptions(
    {"latitude_deg": "19", "longitude_deg": "-97.3"},
    (
        *("date_utc", "ut_h", "obsnum", "source", "az_deg", "el_deg"),
        *("d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec"),
    ),
)


def test_one_telescope_two_formats():
    """TPOINT's file and the Field System's of the same night hold the same offsets."""
    tpoint = read(sample("auxtel/AT_point_data_20220406_tw004_corr.dat"))
    field_system = read(sample("field_system/auxtel2022.xtr"))

    np.testing.assert_allclose(tpoint.x, field_system.x, atol=1e-6 * DEG)
    np.testing.assert_allclose(tpoint.y, field_system.y, atol=1e-6 * DEG)


def test_a_file_without_names_takes_them_from_outside():
    """On-sky arcseconds, and the Field System's degrees made of them, are the same."""
    table = read(sample("lmt/PointingData.csv"), LMT)
    field_system = read(sample("field_system/lmt.xtr"))

    np.testing.assert_allclose(table.x, field_system.x, atol=1e-7 * DEG)
    np.testing.assert_allclose(table.sigma_x, field_system.sigma_x, atol=1e-7 * DEG)
    assert np.ptp(table.at.column("time")) == pytest.approx(2 * 86400, rel=0.2)
    assert table.at.site.longitude == pytest.approx(-97.3 * DEG)


def test_masked_stars_are_counted():
    """All of the 130 stars are there: fitted or excluded."""
    corrected = read(sample("auxtel/AT_point_data_20210609_tw003_corr.dat"))

    assert (len(corrected), len(corrected.set_aside)) == (100, 30)


def test_the_classical_fit_agrees_with_the_published_one():
    """AN and AW of the published TPOINT fit, each with its sign, to two arcsec in its drift."""
    done = fit(read(sample("auxtel/AT_point_data_20220406_tw004_corr.dat")), load("altaz"))
    values = {
        coefficient.name: one.value[n] / ARCSEC
        for one in done.coefficients
        for n, coefficient in enumerate(one.term.effect.coefficients)
    }
    sigmas = {
        coefficient.name: one.sigma[n] / ARCSEC
        for one in done.coefficients
        for n, coefficient in enumerate(one.term.effect.coefficients)
    }

    for name, published in (("tilt_north", 39.16), ("tilt_east", -70.89)):
        assert abs(values[name] - published) < 2 * sigmas[name]
        assert sigmas[name] < 2
    assert values["azimuth_zero"] == pytest.approx(-292.0, abs=10)
