"""Which periods are looked for, what a wandering phase is allowed, and what is stated of both."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import ONE_ANTENNA, rows_with

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis.naming import waves
from pyport.diagnosis.shapes import oscillations, periods, scans, wave_fits
from pyport.effects.empirical.oscillations import oscillation
from pyport.thresholds import PERIODS_FREE

HOUR = 3600.0
YEAR = 365.25 * 86400


def observed(hours, step_s=60.0, sessions=1):
    """Return the case of sessions of some length, a day apart."""
    within = np.arange(0.0, hours * HOUR + 1, step_s)
    time = 1.2e9 + np.concatenate([86400 * n + within for n in range(sessions)])
    rows = np.arange(len(time))
    return SimpleNamespace(
        recordings=SimpleNamespace(at=rows_with(len(time), time=time)),
        stack=SimpleNamespace(row=rows, is_y=rows < 0),
        blocks=ONE_ANTENNA,
        pointing=rows,
        session=np.repeat(np.arange(sessions), len(within)),
    )


def scanned(*args, **options):
    """Return what a search for periods meets of such sessions."""
    return scans.scan_of(observed(*args, **options), reversing=False)


@pytest.mark.parametrize(
    ("step_s", "shortest_s"), [(20, 200), (60, 200), (70, 210), (420, 1260), (600, 1800)]
)
def test_the_shortest_period_is_that_of_a_worm_or_three_steps(step_s, shortest_s):
    """Whichever is longer; sessions are long enough for either."""
    assert scanned(12, step_s).shortest == pytest.approx(shortest_s)


def test_exposures_of_one_visit_are_one_moment():
    """Three of a star within a minute show no wave of three exposures."""
    problem = observed(12, 100.0)
    problem.pointing = np.arange(len(problem.session)) // 3

    assert scans.scan_of(problem, reversing=False).shortest == pytest.approx(900)


@pytest.mark.parametrize(
    ("hours", "sessions", "longest_h"),
    [(0.2, 1, None), (0.25, 1, 0.125), (8, 1, 4), (12, 1, 6), (0.1, 4, None), (8, 4, 8)],
)
def test_a_single_session_holds_two_periods(hours, sessions, longest_h):
    """Of several each may hold one; nothing is looked for below twice the shortest period."""
    scan = scanned(hours, 10.0, sessions=sessions)

    assert (scan and scan.longest) == (longest_h and pytest.approx(longest_h * HOUR))


@pytest.mark.parametrize(
    ("sessions", "direction_deg", "longest_h"),
    [(4, None, 8), (4, 0.0, 4), (1, None, 4), (1, 0.0, 4)],
)
def test_a_session_that_stands_alone_holds_two_periods(sessions, direction_deg, longest_h):
    """As each does where the phase wanders."""
    scan = scanned(8, sessions=sessions)
    shown = [
        scan.shows(scans.Peak(times * longest_h * HOUR, 0.0, 1.0, direction_deg))
        for times in (0.99, 1.01)
    ]

    assert shown == [True, False]


@pytest.mark.parametrize(("is_y", "lines_deg"), [(0, [0.0]), (1, [90.0])])
def test_an_axis_alone_is_the_line(is_y, lines_deg):
    """Nothing is said of the axis that was not measured."""
    scan = scanned(8, sessions=4)

    assert replace(scan, is_y=np.full_like(scan.is_y, is_y)).lines_deg.tolist() == lines_deg


@pytest.mark.parametrize("direction_deg", [0.0, 22.5, 90.0, 157.5])
def test_a_wandering_wave_has_one_line(direction_deg):
    """Both axes swing together along it, and the search meets it."""
    scan = scanned(8, sessions=4)
    time = np.tile(scan.time, 2)
    is_y = np.repeat([0, 1], len(scan.time))
    both = replace(scan, time=time, session=np.tile(scan.session, 2), is_y=is_y)
    along = np.array([np.cos(direction_deg * DEG), np.sin(direction_deg * DEG)])[is_y]
    wave = along * np.sin(2 * np.pi * time / HOUR + both.session**2)
    flat = scans.View(0.0, wave, np.log([both.shortest, both.longest]), np.ones((8, 2)) * 240)
    (found,) = periods.peaks_of(both, [flat])
    best = next(one for one in found if one.wanders)

    assert best.direction_deg == direction_deg
    assert best.period == pytest.approx(HOUR, rel=0.05)
    assert best.choices == pytest.approx(8 * 10 * np.log(8 * HOUR / 200), abs=4)
    # Where nothing swings, the smallest size costs least: two amplitudes in each of four nights.
    (nothing,) = periods.peaks_of(both, [replace(flat, pull=0 * wave)])
    lost = next(one for one in nothing if one.wanders).evidence
    assert lost == pytest.approx(-2 * 4 * np.log1p(0.02))


@pytest.mark.parametrize(("period_h", "stretches"), [(0.5, 8), (1, 4), (2, 2), (3, 1), (6, 1)])
def test_a_wandering_phase_is_free_in_three_periods(period_h, stretches):
    """Sessions of twelve hours are cut into stretches as long, as nearly as they go into one."""
    scan = scanned(12)
    stretch, count = scans.stretches_of(scan, period_h * HOUR, PERIODS_FREE)

    assert count == stretches
    assert np.ptp(np.bincount(stretch)) <= 1


def test_stretches_without_readings_are_not_counted():
    """One reading decades before its session makes one stretch more, not millions."""
    scan = scanned(12)
    early = replace(scan, begin=scan.begin - 50 * YEAR, length=scan.length + 50 * YEAR)
    early = replace(
        early, time=np.append(scan.time, -50 * YEAR), session=np.append(scan.session, 0)
    )
    stretch, count = scans.stretches_of(early, HOUR, PERIODS_FREE)

    assert stretch[-1] == 0
    assert set(stretch) == set(range(count))
    assert count <= 6


@pytest.mark.parametrize("hours", [2, 4, 8])
def test_a_wandering_period_is_another_from_a_tenth_on(hours):
    """A choice among the logarithm of the longest over the shortest, in tenths."""
    scan = scanned(hours)
    flat = scans.View(
        0.0, np.zeros(len(scan.time)), np.log([scan.shortest, scan.longest]), np.ones((2, 2))
    )
    (found,) = periods.peaks_of(scan, [flat])

    choices = 10 * np.log(hours * HOUR / 2 / 200)
    assert next(one for one in found if one.wanders).choices == pytest.approx(choices, abs=0.5)


@pytest.mark.parametrize(
    ("longest_h", "above", "proposed"),
    [(4, -np.inf, False), (6, -np.inf, True), (6, 99, True), (6, 101, False)],
)
def test_where_a_longer_period_is_best_nothing_is_proposed(monkeypatch, longest_h, above, proposed):
    """What takes days must not be given to a shorter period; each share of the drift is tried.

    Nor is what is worth less than is asked.
    """
    best = scans.Peak(5 * HOUR, 100.0, 1.0)
    shares = []
    scan = replace(scanned(8), longest=longest_h * HOUR)
    monkeypatch.setattr(oscillations, "_ways", lambda _: (False,))
    monkeypatch.setattr(oscillations, "scan_of", lambda *_, **__: scan)
    monkeypatch.setattr(oscillations, "_with_drift", lambda _, share, __: shares.append(share))
    monkeypatch.setattr(oscillations, "view_of", lambda *_: SimpleNamespace(lack=0.0))
    monkeypatch.setattr(oscillations, "peaks_of", lambda _, views: [[best]] * len(views))
    monkeypatch.setattr(oscillations, "_refined", lambda *_: ("an oscillation", 100.0))

    assert (oscillations.proposed(None, None, (), above) is not None) == proposed
    assert max(shares) == 1
    assert min(shares) <= 0.3


@pytest.mark.parametrize(("more", "harmonics"), [(5.8, 1), (6.2, 8)])
def test_what_is_no_sine_must_be_convincingly_better(monkeypatch, more, harmonics):
    """It has seven harmonics more: a sine whose phase holds nearly is one."""
    scan = scanned(8)
    peaks = [scans.Peak(HOUR, 100.0, 1.0), scans.Peak(HOUR, 100.0 + more, 1.0, harmonics=8)]
    monkeypatch.setattr(oscillations, "_ways", lambda _: (False,))
    monkeypatch.setattr(oscillations, "scan_of", lambda *_, **__: scan)
    monkeypatch.setattr(oscillations, "_with_drift", lambda *_: None)
    monkeypatch.setattr(oscillations, "view_of", lambda *_: SimpleNamespace(lack=0.0))
    monkeypatch.setattr(oscillations, "peaks_of", lambda _, views: [peaks] * len(views))
    monkeypatch.setattr(oscillations, "_refined", lambda *of: (of[4].harmonics, of[4].evidence))

    assert oscillations.proposed(None, None, ()) == harmonics


@pytest.mark.parametrize("gain", [8.0, 40.0, 200.0])
def test_a_held_phase_has_the_evidence_of_its_likeliest_variance(gain):
    """Of four amplitudes; a high peak is met more often than among independent periods."""
    scan = scanned(8)
    found = periods.highest(scan, np.array([1 / HOUR]), np.array([gain]), 4)

    assert found.evidence == pytest.approx(gain - 4 - 4 * np.log(gain / 4))
    assert found.choices == pytest.approx(scan.coherent * (gain / 2) ** 0.5)


def test_the_best_period_is_the_top_of_a_parabola():
    """Its sigma is where twice the log of the likelihood has fallen by one."""
    top, sigma, _ = wave_fits.top(
        lambda period: 50 - ((period - 1000.3) / 4) ** 2, np.linspace(950, 1050, 11)
    )

    assert (top, sigma) == pytest.approx((1000.3, 4.0), rel=1e-6)


def test_a_phase_is_forgotten_in_its_quality_over_pi_periods():
    """Amplitudes of stretches hang together by that, and those of a fit have that covariance."""
    problem = observed(12)
    period = 2 * HOUR
    effect = oscillation(period, 1.2e9, [(1.2e9, 1.3e9)], direction_deg=30.0)
    free, mixes = wave_fits._wandered(problem, scans.scan_of(problem, reversing=False), effect)
    middle = np.mean(free.member["stretches_s"], axis=1)
    apart = np.abs(middle[:, None] - middle) / period
    for mix, quality in zip(mixes, wave_fits.QUALITIES, strict=True):
        wanted = np.kron(np.exp(-np.pi / quality * apart), np.eye(2))
        rest = np.random.default_rng(0).normal(size=(90, len(mix)))
        waves = SimpleNamespace(
            columns=lambda _, rest=rest: (None, rest), left=rest[:, 0], mixes=[mix]
        )

        assert mix @ mix.T == pytest.approx(wanted)
        assert wave_fits._Waves.fit(waves, period)[1] == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("value", "stated"),
    [
        ((3.0, 4.0), (5.0, 0.5, np.degrees(np.arctan2(4, 3)), np.degrees(0.1))),
        ((-4.0, 3.0), (5.0, 0.5, np.degrees(np.arctan2(3, -4)), np.degrees(0.1))),
    ],
)
def test_an_amplitude_is_stated_with_its_phase_where_one_holds(value, stated):
    """With errors of half an arcsecond."""
    found = waves.of_axis("el", ARCSEC * np.array(value), (0.5 * ARCSEC) ** 2 * np.eye(2))

    assert [number for one in found for number in (one.value, one.sigma)] == pytest.approx(stated)


def test_a_wandering_amplitude_is_stated_along_its_line():
    """The root mean square of stretches, less what errors of half an arcsecond add to it."""
    size, sigma = waves._wandering(np.array([3.0, 4.0, 0.0, 5.0]), 0.5**2 * np.eye(4))
    line, across, along = waves._along(60.0, 3.0, 10 * ARCSEC, ARCSEC)

    assert (size, sigma) == pytest.approx(((25 - 0.5) ** 0.5, 0.5 / 2**0.5))
    assert (line.value, line.sigma) == (60.0, 3.0)
    assert (across.value, along.value) == pytest.approx((5.0, 10 * 0.75**0.5))
    turned = 10 * 3 * DEG
    assert (across.sigma, along.sigma) == pytest.approx(
        (np.hypot(0.5, turned * 0.75**0.5), np.hypot(0.75**0.5, turned * 0.5))
    )
