"""What the noise does is said with its size; what was derived or dropped is said too."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import LATITUDE, recordings

from pyport import page
from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming.noise_remarks import NoiseRemarks, by_elevation, drifts, sentences
from pyport.diagnosis.naming.remarks import _hides
from pyport.diagnosis.searching.settling import Dropped
from pyport.fitting.fit import fit
from pyport.fitting.soundness import rms_of
from pyport.fitting.table import as_json, text
from pyport.formats.models import load
from pyport.recordings.schema import Stack
from pyport.recordings.sky import with_sessions
from pyport.report.folder import text as in_words
from pyport.report.made import report_of
from pyport.report.typed import as_json as told


@pytest.fixture(scope="module")
def wandering():
    """Diagnose twelve nights whose elevation zero scatters by 20 arcsec."""
    night = np.arange(360) // 30
    zero = 20 * np.random.default_rng(7).normal(size=12)
    made = recordings(
        360,
        3,
        noise_arcsec=3,
        y=lambda _: zero[night],
        session=np.char.add("n", night.astype(str)),
        time=1.2e9 + 86400.0 * night + 300.0 * (np.arange(360) % 30),
    )
    return diagnose(made, load("altaz"))


@pytest.mark.slow
def test_what_nights_do_is_a_size(wandering):
    """Terminal, report and page give the standard deviation among the nights."""
    found = told(report_of(wandering))["noise"]["departures"]
    zeros = [one for one in found if one["term"] == "zero in elevation"]

    assert zeros[0]["sigma_arcsec"] == pytest.approx(20, rel=0.6)
    assert len(zeros[0]["labels"]) == 12
    drawn = 20 * np.random.default_rng(7).normal(size=12)
    most = int(np.abs(drawn - drawn.mean()).argmax())
    assert zeros[0]["most_label"] == f"n{most}"
    assert zeros[0]["most_arcsec"] == pytest.approx(drawn[most] - drawn.mean(), abs=4)
    said = "Night-to-night scatter of the zero in elevation"
    assert said in " ".join(in_words(report_of(wandering)).split())
    assert any(said in one for one in page.of_diagnosis(wandering)[1].noise)
    assert "nights differ in the zero in elevation by " in told(report_of(wandering))["verdict"]


def shifted_on_the_sky(at, east, north):
    """Return cross-elevation and elevation of shifts in right ascension and declination."""
    dec = np.arcsin(
        np.sin(LATITUDE) * np.sin(at.el) + np.cos(LATITUDE) * np.cos(at.el) * np.cos(at.az)
    )
    sin_q = -np.sin(at.az) * np.cos(LATITUDE) / np.cos(dec)
    cos_q = (np.sin(LATITUDE) - np.sin(dec) * np.sin(at.el)) / (np.cos(dec) * np.cos(at.el))
    return -east * cos_q + north * sin_q, east * sin_q + north * cos_q


@pytest.mark.slow
def test_what_all_sources_are_off_by_is_said_where_nothing_is_found():
    """No finding, for any could be the one that is right; and no all-clear either."""
    rng = np.random.default_rng(3)
    source, places = np.arange(300) % 30, 8 * rng.standard_normal((2, 30))
    made = recordings(
        300,
        5,
        noise_arcsec=3,
        x=lambda at: shifted_on_the_sky(at, *places[:, source])[0],
        y=lambda at: shifted_on_the_sky(at, *places[:, source])[1],
        source=np.char.add("Q", source.astype(str)),
    )
    found = told(report_of(diagnose(made, load("altaz"))))

    assert not found["findings"]
    assert "sources differ in the place in the catalogue by " in found["verdict"]


@pytest.mark.parametrize(("column", "said"), [("temperature_c", False), ("sensor_7", True)])
def test_that_no_weather_is_recorded_is_said_of_drifts(column, said):
    """What they follow cannot be found then."""
    diagnosis = SimpleNamespace(
        weighed=SimpleNamespace(
            covariance=SimpleNamespace(noises=[SimpleNamespace(within=0.0, between=1.0)])
        ),
        problem=SimpleNamespace(
            recordings=SimpleNamespace(at=SimpleNamespace(columns={column: np.zeros(9)}))
        ),
    )
    drifting = [{"axis": "elevation", "rms_arcsec": 5.0}]
    noise = NoiseRemarks([], drifting, [], [], [])

    assert ("no weather is recorded" in _hides(diagnosis, noise)) == said


@pytest.mark.slow
@pytest.mark.parametrize("stated", [5.0, 3.5, 2.0, 1.0])
def test_scatter_far_beyond_the_recorded_errors_is_said(stated):
    """Where nothing is found, too: it is no all-clear."""
    made = recordings(200, 4, noise_arcsec=5.0)
    error = np.full(200, stated * ARCSEC)
    found = diagnose(replace(made, sigma_x=error, sigma_y=error), load("altaz"))
    told = " ".join(in_words(report_of(found)).split())
    times = re.findall(r"but offsets in [a-z-]+ scatter by ([0-9.]+) times their", told)

    assert found.findings == ()
    assert len(times) == (2 if stated <= 2 else 0)
    assert [float(one) for one in times] == pytest.approx([5 / stated] * len(times), rel=0.15)


@pytest.mark.slow
def test_what_drifts_is_said_with_its_memory(drifting):
    """In arcseconds and hours, with the nights furthest from usual; the steady axis is not.

    Eight nights do not distinguish twelve hours from a walk, which would drift further later on.
    """
    (one,) = told(report_of(drifting))["noise"]["drifts"]
    (said,) = [words for words in report_of(drifting).noise.sentences if "drifts" in words]

    assert one["axis"] == "elevation"
    assert one["rms_arcsec"] == pytest.approx(10, rel=0.3)
    assert 0.3 * 12 < one["memory_s"] / 3600 < 3 * 12
    assert -20 < one["lowest_arcsec"] < -3 < 3 < one["highest_arcsec"] < 20
    assert told(report_of(drifting))["noise"]["el_arcsec"] == pytest.approx(10, rel=0.4)
    assert said.startswith("Elevation drifts with date: ")
    assert f"({one['lowest_session']}) to " in said


@pytest.mark.slow
@pytest.mark.parametrize(("excess", "reported"), [(0.25, True), (0.23, True), (0.19, False)])
def test_a_drift_that_widens_the_scatter_by_a_tenth_is_reported(excess, reported):
    """Whose variance is 0.21 of that of the scatter from pointing to pointing."""
    covariance = SimpleNamespace(
        drifted=lambda left: left,
        shown=[SimpleNamespace(within=1.0, between=0.0, time_s=3600.0)],
        used=np.ones(40, bool),
        precision=np.ones(40),
    )
    problem = SimpleNamespace(
        blocks=SimpleNamespace(antennas=1),
        recordings=SimpleNamespace(
            meta={}, at=SimpleNamespace(mount=SimpleNamespace(names=("cross-elevation",)))
        ),
        parts=[SimpleNamespace(rows=np.arange(40), is_y=0)],
        session_names=np.repeat(["a", "b"], 20),
    )
    diagnosis = SimpleNamespace(problem=problem, weighed=SimpleNamespace(covariance=covariance))
    found = drifts(diagnosis, np.sqrt(excess) * np.resize([1.0, -1.0], 40))

    assert bool(found) == reported


def test_what_moves_once_is_a_drift_of_its_size():
    """By what it moved: the noise is that of a walk, much of which only longer recordings show."""
    night = np.arange(420) // 60
    time = 1.2e9 + 80 * 3600.0 * night + 600.0 * (np.arange(420) % 60)
    creeps = np.clip((time - time[180]) / np.ptp(time[180:]), 0, None)
    made = recordings(
        420,
        5,
        noise_arcsec=4,
        y=lambda _: 9 * creeps,
        session=np.char.add("n", night.astype(str)),
        time=time,
    )
    report = told(report_of(diagnose(made, load("altaz"))))

    (one,) = report["noise"]["drifts"]
    assert one["rms_arcsec"] == pytest.approx(9 * np.std(creeps), rel=0.3)
    assert one["highest_session"] == "n6"
    assert "elevation drifts by" in report["verdict"]


@pytest.fixture(scope="module")
def drifting():
    """Diagnose eight nights whose elevation zero wanders by 10 arcsec, with a memory of 12 h."""
    rng = np.random.default_rng(3)
    night = np.arange(400) // 50
    time = 86400.0 * night + 500.0 * (np.arange(400) % 50)
    zero = [10 * rng.normal()]
    for gap in np.diff(time):
        kept = np.exp(-gap / 43200)
        zero.append(kept * zero[-1] + 10 * np.sqrt(1 - kept**2) * rng.normal())
    made = recordings(
        400,
        3,
        noise_arcsec=2,
        y=lambda _: np.array(zero),
        session=np.char.add("n", night.astype(str)),
        time=1.2e9 + time,
    )
    return diagnose(made, load("altaz"))


@pytest.mark.slow
def test_scatter_that_grows_toward_the_horizon_is_said():
    """As one over sin E, by so much; even scatter is not worth a word."""
    rng = np.random.default_rng(5)
    more = lambda at: 6 * rng.normal(size=600) / np.sin(at.el)  # noqa: E731 - noise, drawn once
    uneven = diagnose(recordings(600, 3, noise_arcsec=0.1, x=more, y=more), load("altaz"))
    even = diagnose(recordings(600, 3), load("altaz"))

    for one in by_elevation(uneven):
        assert one["low_arcsec"] > 2 * one["high_arcsec"]
        assert one["low_el_deg"] < one["high_el_deg"]
    assert {one["axis"] for one in by_elevation(uneven)} == {"cross-elevation", "elevation"}
    assert not by_elevation(even)


@pytest.mark.parametrize(
    ("rows", "labels", "kept"),
    [(120, 60, True), (120, 61, False), (120, 120, False), (1, 1, True), (30, 16, False)],
)
def test_sessions_of_fewer_than_two_rows_are_none(rows, labels, kept):
    """Nights between gaps in time take their place, unless these are as short."""
    time = 1e9 + 86400 * (np.arange(rows) // 40) + 60.0 * np.arange(rows)
    session = np.char.add("scan ", (np.arange(rows) * labels // rows).astype(str))
    made = recordings(rows, 3, time=time, session=session)
    found = with_sessions(made)
    said = sentences(NoiseRemarks((), (), (), (), ()), found.meta)
    short = [one for one in said if "too short" in one]

    assert np.array_equal(found.at.columns.get("session"), session) == kept
    assert bool(short) == (not kept)
    if not kept:
        assert short[0].endswith(f"{labels} in {rows} rows")
        assert ("session" in found.at) == (rows > 40)
    daily = {**made.at.columns, "time": 1e9 + 86400.0 * np.arange(rows)}
    alone = with_sessions(replace(made, at=replace(made.at, columns=daily)))
    assert ("session" in alone.at) == kept


@pytest.mark.slow
def test_what_was_derived_is_said():
    """Nights from gaps, the order from the rows: the reader knows that nobody recorded them."""
    made = recordings(120, 3)
    columns = dict(made.at.columns)
    del columns["session"]
    gaps = diagnose(replace(made, at=replace(made.at, columns=columns)), load("altaz"))
    del columns["time"]
    order = diagnose(replace(made, at=replace(made.at, columns=columns)), load("altaz"))

    assert any("taken from gaps of more than 6 h" in one for one in report_of(gaps).noise.sentences)
    assert any("the order of the rows" in one for one in report_of(order).noise.sentences)


def test_what_was_dropped_is_listed(wandering):
    """Effect and reason, on the terminal and on the page."""
    reason = "data left out are predicted worse with it, by 2 per cent"
    done = replace(wandering, dropped=(Dropped("epoch_tilt", "s1", reason),))

    assert f"Looked at and dropped: epoch_tilt (s1): {reason}." in " ".join(
        in_words(report_of(done)).split()
    )
    assert page.of_diagnosis(done)[1].dropped == (("epoch tilt, s1", reason),)


def test_the_sky_rms_is_that_of_pointings():
    """Three and four in one pointing are five on the sky; what has one axis does not count."""
    data = Stack(np.array([0, 1, 0, 2]), np.array([False, False, True, True]), np.zeros(4))
    left, used = np.array([3.0, 100.0, 4.0, 100.0]), np.ones(4, bool)

    across, _, sky = rms_of(data, left, used)
    assert sky == (pytest.approx(5.0), 1)
    assert rms_of(data, left, np.array([True, True, False, True]))[2] is None
    assert across == (pytest.approx(np.hypot(3, 100) / 2**0.5), 2)
    assert rms_of(data, left, ~used)[1] is None


@pytest.mark.slow
def test_both_commands_say_the_same_rms_in_the_same_words():
    """One definition per axis and on the sky, named where it is printed."""
    made = recordings(200, 8)
    done, fitted = diagnose(made, load("altaz")), fit(made, load("altaz"))
    report, ours = told(report_of(done))["fit"], as_json(fitted)["rms"]

    assert report["rms_on_sky"] == ours["on_sky"]
    assert "as TPOINT's sky rms" in " ".join(in_words(report_of(done)).split())
    assert "as TPOINT's sky rms" in text(fitted)
    for axis in ("xel", "el", "sky"):
        assert report["before"][f"rms_{axis}_arcsec"] == pytest.approx(
            ours[f"{axis}_arcsec"], rel=0.01
        )
    assert rms_of(fitted.stack, fitted.residual, fitted.noise.used)[2][0] == pytest.approx(
        np.sqrt(2) * 5 * ARCSEC, rel=0.15
    )
