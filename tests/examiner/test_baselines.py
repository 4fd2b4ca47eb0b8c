"""Baselines answer in the form of a report: the term that was put in, at its size."""

import numpy as np
import pytest

from pyport.examiner import baselines, scores
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.sealed.record.published import check_report
from pyport.examiner.worlds.kinds import make_case


@pytest.fixture(params=[*baselines.METHODS])
def method(request):
    """Return the name of each baseline, the lasso where scikit-learn is installed."""
    if request.param == "lasso":
        pytest.importorskip("sklearn")
    return request.param


def recorded(tmp_path, *kind, **options):
    """Write a case's recordings and return its file."""
    path = tmp_path / "recordings.csv"
    write_recordings(make_case(*kind, rows=300, noise="white", **options), path)
    return path


@pytest.mark.slow
def test_a_loud_cause_of_the_list_comes_first(tmp_path, method):
    """Its name, alone in its class, in a report that can be judged."""
    path = recorded(tmp_path, "one", 5, effect="elevation_encoder_harmonics", rho=2.0)
    report = check_report(baselines.answer(method, path), path)

    assert report["findings"][0]["class"] == ["elevation_encoder_harmonics"]
    assert report["mismatch"]


def test_white_noise_alone_is_left_alone(tmp_path, method):
    """What both take noise for is what it is here."""
    report = baselines.answer(method, recorded(tmp_path, "null", 8))

    assert not report["mismatch"]


def measured(tmp_path, along):
    """Write 200 pointings of two sessions with 0.3 arcsec of noise; `along` adds to elevation."""
    rng = np.random.default_rng(4)
    az, el = rng.uniform(0, 360, 200), rng.uniform(15, 80, 200)
    session = np.arange(200) // 100
    model = scores.altaz(np.radians(az), np.radians(el)) @ rng.normal(0, 60, 7)
    x, y = (model + rng.normal(0, 0.3, (200, 2))).T
    y = y + along(np.radians(el), session)
    lines = ["time_utc,session,az_deg,el_deg,d_xel_arcsec,d_el_arcsec"]
    for n, row in enumerate(zip(az, el, x, y, strict=True)):
        time = f"2004-01-0{1 + session[n]}T{n % 100 // 10:02}:{n % 10:02}:00Z"
        lines.append(",".join([time, f"S{session[n]}", *(f"{one:.6f}" for one in row)]))
    path = tmp_path / "recordings.csv"
    path.write_text("\n".join([*lines, ""]))
    return path


def test_a_step_says_since_when(tmp_path):
    """The moment is where the later session starts."""
    path = measured(tmp_path, lambda _, session: 5.0 * session)
    first = baselines.answer("bic", path)["findings"][0]

    assert (first["effect"], first["where"]) == (
        "epoch_offset",
        {"since": "2004-01-02T00:00:00Z"},
    )


def test_sizes_are_those_of_least_squares_in_arcsec(tmp_path):
    """Refraction of 30 arcsec beside the seven terms that are fitted anyway."""
    path = measured(tmp_path, lambda el, _: 30 / np.tan(el))
    first = baselines.answer("bic", path)["findings"][0]
    (size,) = first["parameters"]

    assert first["effect"] == "refraction"
    assert abs(size["value"] - 30) < 4 * size["sigma"] < 2


def test_recordings_without_directions_have_no_answer(tmp_path, method):
    """It is said why."""
    path = tmp_path / "recordings.csv"
    path.write_text("ha_deg,dec_deg,d_el_arcsec\n1,2,3\n")

    assert "no az_deg and el_deg" in baselines.answer(method, path)["examined"]["failed"]
