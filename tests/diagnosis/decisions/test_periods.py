"""Which periods are looked for, what a wandering phase is allowed, and what is stated of both."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import ONE_ANTENNA, Columns

from pyport.angles import ARCSEC
from pyport.diagnosis.naming import waves
from pyport.diagnosis.shapes import oscillations, periods
from pyport.effects.empirical.oscillations import oscillation
from pyport.thresholds import PERIODS_FREE

HOUR = 3600.0


def observed(hours, step_s=60.0, sessions=1):
    """Return the case of sessions of some length, a day apart."""
    within = np.arange(0.0, hours * HOUR + 1, step_s)
    time = 1.2e9 + np.concatenate([86400 * n + within for n in range(sessions)])
    rows = np.arange(len(time))
    return SimpleNamespace(
        recordings=SimpleNamespace(at=Columns(len(time), time=time)),
        stack=SimpleNamespace(row=rows, is_y=rows < 0),
        blocks=ONE_ANTENNA,
        session=np.repeat(np.arange(sessions), len(within)),
    )


def scanned(*args, **options):
    """Return what a search for periods meets of such sessions."""
    return periods.scan_of(observed(*args, **options), reversing=False)


@pytest.mark.parametrize(
    ("step_s", "shortest_s"), [(60, 1200), (300, 1200), (400, 1200), (420, 1260), (600, 1800)]
)
def test_the_shortest_period_is_twenty_minutes_or_three_steps(step_s, shortest_s):
    """Whichever is longer; sessions are long enough for either."""
    assert scanned(12, step_s).shortest == pytest.approx(shortest_s)


@pytest.mark.parametrize(
    ("hours", "sessions", "longest_h"),
    [(1.3, 1, None), (1.4, 1, 0.7), (8, 1, 4), (12, 1, 6), (0.6, 4, None), (8, 4, 8)],
)
def test_a_single_session_holds_two_periods(hours, sessions, longest_h):
    """Of several each may hold one; nothing is looked for below twice the shortest period."""
    scan = scanned(hours, sessions=sessions)

    assert (scan and scan.longest) == (longest_h and pytest.approx(longest_h * HOUR))


@pytest.mark.parametrize(("period_h", "stretches"), [(0.5, 8), (1, 4), (2, 2), (3, 1), (6, 1)])
def test_a_wandering_phase_is_free_in_three_periods(period_h, stretches):
    """Sessions of twelve hours are cut into stretches as long, as nearly as they go into one."""
    scan = scanned(12)
    stretch, count = periods.stretches_of(scan, period_h * HOUR, PERIODS_FREE)

    assert count == stretches
    assert np.ptp(np.bincount(stretch)) <= 1


@pytest.mark.parametrize("hours", [2, 4, 8])
def test_a_wandering_period_is_another_from_a_tenth_on(hours):
    """A choice among the logarithm of the longest over the shortest, in tenths."""
    scan = scanned(hours)
    flat = periods.View(
        0.0, np.zeros(len(scan.time)), np.log([scan.shortest, scan.longest]), np.ones((2, 2))
    )
    (found,) = periods.peaks_of(scan, [flat])

    choices = 10 * np.log(hours * HOUR / 2 / 1200)
    assert next(one for one in found if one.wanders).choices == pytest.approx(choices, abs=0.5)


@pytest.mark.parametrize(
    ("longest_h", "above", "proposed"),
    [(4, -np.inf, False), (6, -np.inf, True), (6, 99, True), (6, 101, False)],
)
def test_where_a_longer_period_is_best_nothing_is_proposed(monkeypatch, longest_h, above, proposed):
    """What takes days must not be given to a shorter period; each share of the drift is tried.

    Nor is what is worth less than is asked.
    """
    best = periods.Peak(5 * HOUR, 100.0, 1.0, wanders=False)
    shares = []
    scan = SimpleNamespace(longest=longest_h * HOUR)
    monkeypatch.setattr(oscillations, "_ways", lambda _: (False,))
    monkeypatch.setattr(oscillations, "scan_of", lambda *_, **__: scan)
    monkeypatch.setattr(oscillations, "_with_drift", lambda _, share, __: shares.append(share))
    monkeypatch.setattr(oscillations, "view_of", lambda *_: SimpleNamespace(lack=0.0))
    monkeypatch.setattr(oscillations, "peaks_of", lambda _, views: [[best]] * len(views))
    monkeypatch.setattr(oscillations, "_refined", lambda *_: ("an oscillation", 100.0))

    assert (oscillations.proposed(None, None, (), above) is not None) == proposed
    assert max(shares) == 1
    assert min(shares) <= 0.3


@pytest.mark.parametrize("gain", [8.0, 40.0, 200.0])
def test_a_held_phase_has_the_evidence_of_its_likeliest_variance(monkeypatch, gain):
    """Of four amplitudes; a high peak is met more often than among independent periods."""
    scan = scanned(8)
    monkeypatch.setattr(periods, "_gains", lambda *_: (np.array([1 / HOUR]), np.array([gain]), 4))
    found = periods._held(scan, None)

    assert found.evidence == pytest.approx(gain - 4 - 4 * np.log(gain / 4))
    assert found.choices == pytest.approx(scan.coherent * (gain / 2) ** 0.5)


def test_the_best_period_is_the_top_of_a_parabola():
    """Its sigma is where twice the log of the likelihood has fallen by one."""
    waves = SimpleNamespace(fit=lambda period: (50 - ((period - 1000.3) / 4) ** 2, None, None))
    top, sigma, _ = oscillations.top(waves, np.linspace(950, 1050, 11))

    assert (top, sigma) == pytest.approx((1000.3, 4.0), rel=1e-6)


def test_a_phase_is_forgotten_in_its_quality_over_pi_periods():
    """Amplitudes of stretches hang together by that, and those of a fit have that covariance."""
    setup = observed(12)
    period = 2 * HOUR
    free, mixes = oscillations._wandered(
        setup, periods.scan_of(setup, reversing=False), oscillation(period, 1.2e9, [(1.2e9, 1.3e9)])
    )
    middle = np.mean(free.member["stretches_s"], axis=1)
    apart = np.abs(middle[:, None] - middle) / period
    for mix, quality in zip(mixes, oscillations.QUALITIES, strict=True):
        wanted = np.kron(np.exp(-np.pi / quality * apart), np.eye(2))
        rest = np.random.default_rng(0).normal(size=(90, 2 * len(mix)))
        waves = SimpleNamespace(
            columns=lambda _, rest=rest: (None, rest), left=rest[:, 0], mixes=[mix]
        )

        assert mix @ mix.T == pytest.approx(wanted)
        assert oscillations._Waves.fit(waves, period)[1] == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("value", "held", "stated"),
    [
        ((3.0, 4.0), True, (5.0, 0.5, np.degrees(np.arctan2(4, 3)), np.degrees(0.1))),
        ((-4.0, 3.0), True, (5.0, 0.5, np.degrees(np.arctan2(3, -4)), np.degrees(0.1))),
        ((3.0, 4.0, 0.0, 5.0), False, ((25 - 0.5) ** 0.5, 0.5 / 2**0.5)),
    ],
)
def test_an_amplitude_is_stated_with_its_phase_where_one_holds(value, held, stated):
    """Of stretches the root mean square, less what errors of half an arcsecond add to it."""
    covariance = (0.5 * ARCSEC) ** 2 * np.eye(len(value))
    found = waves.of_axis("el", ARCSEC * np.array(value), covariance, held=held)

    assert [number for one in found for number in (one.value, one.sigma)] == pytest.approx(stated)
