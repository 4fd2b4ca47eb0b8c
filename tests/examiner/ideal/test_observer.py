"""The ideal observer: its gain is that of dense algebra, its power that of the normal."""

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.examiner.ideal import efficiency, observer
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.mount import Stand


def drawn(n=80, form=None, **noise):
    """Return a case of n elevations a minute apart, whose cause has a form along elevation."""
    rng = np.random.default_rng(0)
    az, el = rng.uniform(0, 360, n), rng.uniform(15, 80, n)
    start = np.datetime64("2024-01-01T00:00:00.000")
    form = np.sin(4 * az * DEG) if form is None else form
    columns = {
        "az_deg": az,
        "el_deg": el,
        "time_utc": np.array([f"{start + np.timedelta64(60 * k, 's')}" for k in range(n)]),
        "d_el_deg": np.zeros(n),
    }
    known = {"xel_arcsec": 5.0, "el_arcsec": 4.0, "drift_share": 0.0, "memory_s": 1800.0}
    known |= {"outlier_share": 0.0} | noise
    none = np.zeros(n)
    base = Stand().columns(az * DEG, el * DEG)
    return Case(columns, {}, {"noise": known}, (none, form * 2 * ARCSEC), (none, none), base)


def dense(case, share=0.0, memory_s=1800.0):
    """Return the gain by the inverse of the covariance."""
    n = len(case.columns["el_deg"])
    along = case.base[1]
    time = 60.0 * np.arange(n)
    cov = (1 - share + 0.04 / 12) * np.eye(n)
    cov += share * np.exp(-np.abs(time[:, None] - time) / memory_s)
    inverse = np.linalg.inv(cov * (4 * ARCSEC) ** 2)
    curve = case.signature[1]
    with_model = curve @ inverse @ along
    normal = np.linalg.pinv(along.T @ inverse @ along, rcond=1e-12, hermitian=True)
    return curve @ inverse @ curve - with_model @ normal @ with_model


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_gain_is_that_of_dense_algebra(share):
    """The model projected out, under white noise and a drift."""
    case = drawn(drift_share=share)

    assert observer.gain(case) == pytest.approx(dense(case, share), rel=1e-6)


def test_what_the_model_draws_has_no_gain():
    """A constant of elevation is the elevation zero."""
    assert observer.gain(drawn(form=np.ones(80))) == pytest.approx(0.0, abs=1e-6)


def test_outliers_have_no_gain():
    """They are known and left out."""
    plain = observer.gain(drawn())

    assert observer.gain(drawn(outlier_share=0.05)) == pytest.approx(0.95 * plain)


def test_the_gain_of_white_noise_is_rho_squared_a_reading():
    """Where all rows measured the axis that the cause acts on."""
    made = Spec("one", "one", "refraction", 0.5, 200, "white").make(3)
    count = np.isfinite(made.columns["d_el_deg"]).sum()
    shown = made.truth["effects"][0]["rho_el"] ** 2 * count

    assert observer.gain(made) == pytest.approx(shown, rel=0.02)


@pytest.mark.parametrize("causes", [1, 40])
def test_without_a_cause_it_detects_as_often_as_it_may(causes):
    """Each of the forms has its part of the family's error."""
    each = observer.detection(0.0, 0.01, causes)

    assert 1 - (1 - each) ** causes == pytest.approx(0.01)


def test_power_is_that_of_a_normal():
    """Where the size is the reach one half is detected; looking elsewhere has its price."""
    reach = 2.5758293035489004

    assert observer.detection(reach**2, 0.01, 1) == pytest.approx(0.5, abs=1e-6)
    assert observer.detection(reach**2, 0.01, 40) < 0.25
    assert observer.detection(100.0, 0.01, 40) > 0.999


def test_a_table_has_a_cell_for_rows_and_loudness():
    """Ratios where something was possible, and cause by cause."""
    one = {"effect": "refraction", "rho": 0.5, "rows": 100, "possible": 0.8}
    some = [
        one | {"detected": True, "named": True},
        one | {"detected": True, "named": False},
        one | {"rho": 0.25, "possible": 0.1, "detected": False, "named": False},
    ]
    lines = efficiency.text(some).splitlines()

    assert lines[1].split() == ["100", "0.25", "1", "0.1", "0", "0", "-", "-"]
    assert lines[2].split() == ["100", "0.5", "2", "1.6", "2", "1", "1.25", "0.62"]
    assert lines[4].split()[:3] == ["refraction", "3", "1.7"]


@pytest.mark.slow
def test_a_case_is_examined_from_its_seed():
    """What was said stands beside what could have been."""
    (drawn_,) = efficiency.cases(["refraction"], [1.0], [60], 1, 5)
    found = efficiency.examine(drawn_)

    assert 0 <= found["possible"] <= 1
    assert found["gain"] > 0
    assert (found["effect"], found["rows"]) == ("refraction", 60)
