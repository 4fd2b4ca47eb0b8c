"""Oscillations: found with their period where a drift could draw them, and only there."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC
from pyport.diagnosis import holdout
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.folds import folds
from pyport.diagnosis.naming import waves
from pyport.diagnosis.naming.finding import Parameter
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching import contenders, winner
from pyport.diagnosis.searching.confirmed_changes import Changes
from pyport.diagnosis.shapes import oscillations, periods, scans, wave_fits
from pyport.diagnosis.weighing import weigh
from pyport.effects.circumstances import OVER
from pyport.effects.empirical.oscillations import OSCILLATION, oscillation
from pyport.formats.models import load
from pyport.mounts import KINDS
from pyport.thresholds import CONVINCING

HOUR = 3600.0
PERIOD_S = 1.0 * HOUR
#: Four nights of eight hours, days apart.
NIGHT = np.repeat(np.arange(4), 120)
TIME = (
    1.2e9
    + np.array([0.0, 5.31, 7.13, 12.47])[NIGHT] * 86400
    + np.tile(np.linspace(0, 8 * HOUR, 120), 4)
)


def wandering(seed, share, period_s=None, memory_s=HOUR):
    """Return a hand that turns, if a period is given, and forgets where it was; its shadow."""
    rng = np.random.default_rng(seed)
    hand, out = 0.0, []
    for step in np.diff(TIME, prepend=TIME[0] - 1e9):
        turn = np.exp((2j * np.pi / period_s if period_s else 0.0) * step - step / memory_s)
        hand = turn * hand + np.sqrt(1 - abs(turn) ** 2) * (rng.normal() + 1j * rng.normal())
        out.append(share * hand.real)
    return lambda _: np.array(out)


#: Offsets in elevation [arcsec] beside a scatter of 5 arcsec.
SWINGS = {
    "held": lambda _: 5 * np.sin(2 * np.pi * (TIME % PERIOD_S) / PERIOD_S + 1),
    "wandering": wandering(2, 5.0, PERIOD_S, memory_s=2 * PERIOD_S),
}
NOTHING = {
    "white": None,
    "drift of an hour": wandering(2, 7.0),
    "drift of ten minutes": wandering(2, 7.0, memory_s=600.0),
    "walk": wandering(4, 12.0, memory_s=300 * HOUR),
    "a step": lambda _: 9.0 * (NIGHT > 1),
    "a swing of days": lambda _: 6 * np.sin(2 * np.pi * TIME / (2.7 * 86400)),
}


def made(y=None, **columns):
    """Return 480 pointings of four nights."""
    session = np.array([f"night {n}" for n in NIGHT])
    return recordings(480, 5, y=y, time=TIME, session=session, **columns)


def case(y=None, **columns):
    """Return the case of some recordings."""
    return prepare(made(y, **columns), load("altaz"), seed=1)


@pytest.fixture(scope="module", params=SWINGS)
def swinging(request):
    """Return the kind of an oscillation, the case it is hidden in, and what is proposed."""
    problem = case(SWINGS[request.param])
    one = oscillations.proposed(problem, weigh(problem).covariance, ())
    assert one is not None
    return request.param, problem, one


def test_the_period_is_found(swinging):
    """To a few per cent where the phase wanders, much better where it holds; its kind is known."""
    kind, _, one = swinging
    effect = one.candidate.effect

    assert effect.id == OSCILLATION
    assert effect.changes_with == ("stretch" if kind == "wandering" else "time")
    near = 0.06 if kind == "wandering" else 2e-4
    assert effect.parameter == pytest.approx(PERIOD_S, rel=near)
    assert one.candidate.choices > (1 if kind == "wandering" else 300)


def test_what_is_left_out_chooses_no_period(swinging):
    """Readings of no weight may say what they like, and are predicted by the others."""
    _, problem, one = swinging
    covariance = weigh(problem).covariance
    problem, _ = problem.with_member(one, one.candidate.effect)
    hidden = np.arange(len(problem.residual)) % 10 == 3
    seen = replace(covariance, weights=np.where(hidden, 0.0, covariance.weights))
    data = np.where(hidden, 0.01, problem.residual)
    absurd = replace(problem, data=np.column_stack([problem.whole[:, :-1], data]), added=None)
    effect = one.candidate.effect
    fresh, other = (oscillations.again(each, seen, (), effect) for each in (problem, absurd))

    assert fresh.parameter == pytest.approx(other.parameter, rel=1e-5)
    assert fresh.parameter == pytest.approx(PERIOD_S, rel=0.1)


def test_a_wandering_phase_is_predicted_between_its_readings():
    """Pointings are dealt out, for a block of time may hold a stretch; what is left is less."""
    problem = case(SWINGS["wandering"])
    one = oscillations.proposed(problem, weigh(problem).covariance, ())
    problem = problem.with_member(one, one.candidate.effect)[0]
    weighed = weigh(problem, (one,), searching=False)
    partition = folds(problem, weighed, (one,))
    left = [holdout.residuals(problem, weighed, some, partition) for some in ((), (one,))]
    before, after = (np.sqrt(np.mean(some[problem.stack.is_y] ** 2)) for some in left)

    assert partition.scheme == "leave pointings out, ten folds"
    assert after < 0.92 * before


@pytest.mark.parametrize("kind", NOTHING)
def test_nothing_else_is_an_oscillation(kind):
    """Drifts of any memory, steps and what takes days are no oscillation within a session."""
    problem = case(NOTHING[kind])

    assert oscillations.proposed(problem, weigh(problem).covariance, ()) is None


@pytest.mark.parametrize(
    ("kind", "times", "passed"),
    [
        ("pulses", 3, False),
        ("pulses", 2, False),
        ("square", 1, True),
        ("held", 1, True),
        ("wandering", 1, True),
    ],
)
def test_an_overtone_of_something_slower_keeps_no_name(kind, times, passed):
    """Pulses of a tenth of an hour repeat after two and three times the periods of overtones."""
    bent = {
        "pulses": lambda _: 12.0 * (TIME / PERIOD_S % 1 < 0.1),
        "square": lambda _: 6.0 * (TIME / PERIOD_S % 1 < 0.4),
    }
    problem = case((bent | SWINGS)[kind])
    near = oscillation(PERIOD_S / times)
    place = np.arange(problem.size, problem.size + 4)
    one = Chosen(Candidate(near, place, (0, 1, 2, 3)), "all")
    problem = problem.with_member(one, one.candidate.effect)[0]
    scene = SimpleNamespace(
        problem=problem, weighed=weigh(problem, (one,)), outcome=SimpleNamespace(chosen=(one,))
    )
    check = waves.own_period(scene, one)

    assert check.passed == passed
    assert f"every {times} periods" in check.words or passed


@pytest.mark.parametrize(
    ("minutes", "sigma", "count", "passed"),
    [
        (361.5, 0.8, 3, False),
        (363.5, 0.8, 3, True),
        (476.0, 23.0, 3, False),
        (288.0, 0.1, 3, False),
        (240.0, 0.1, 3, True),
        (361.5, 0.8, 1, True),
    ],
)
def test_an_overtone_of_the_day_keeps_no_name(monkeypatch, minutes, sigma, count, passed):
    """Down to a fifth of it, within four sigma, where more nights than one have it in common."""
    monkeypatch.setattr(waves, "nights", lambda _: count)
    period = Parameter("period", minutes, sigma, "min")

    assert waves.of_a_day(None, oscillation(minutes * 60), period).passed == passed
    free = oscillation(minutes * 60, 0.0, [(0.0, 7200.0)], direction_deg=30.0)
    assert waves.of_a_day(None, free, period).passed


def test_one_is_enough(swinging):
    """Beside an oscillation no other is looked for."""
    _, problem, one = swinging

    assert (
        oscillations.proposed(problem, weigh(problem).covariance, (Chosen(one.candidate, "all"),))
        is None
    )


@pytest.mark.parametrize(
    "columns",
    [
        {"antenna": np.array(["C00", "C01"])[np.arange(480) % 2]},
        {"time": np.where(np.arange(480) % 3, np.nan, TIME)},
        {"time": 1.2e9 + np.arange(480.0)},
    ],
    ids=["an array", "unknown times", "eight minutes"],
)
def test_where_no_period_could_be_seen(columns):
    """Nothing is looked for."""
    problem = prepare(recordings(480, 5, **{"time": TIME, **columns}), load("altaz"), seed=1)

    assert scans.scan_of(problem, reversing=False) is None


def test_a_worm_that_turns_in_eight_minutes_is_found():
    """In ninety stars of two hours, its size and period stated."""
    rng = np.random.default_rng(8)
    time = 1.2e9 + np.cumsum(rng.uniform(60, 105, 90))
    worm = 10 * np.sin(2 * np.pi * time / 480.0)
    given = recordings(90, 8, time=time, session=np.array(["night"] * 90))
    given = replace(given, x=given.x + worm * np.cos(given.at.el) * ARCSEC)
    (found,) = diagnose(given, load("altaz")).findings

    assert (found.verdict, found.effect) == ("named", OSCILLATION)
    assert float(found.variant.split()[1]) == pytest.approx(8.0, rel=0.02)


def test_a_single_session_holds_two_periods():
    """A longer one is a drift."""
    night = np.array(["night"] * 480)
    time = 1.2e9 + np.linspace(0, 10 * HOUR, 480)
    problem = prepare(recordings(480, 5, time=time, session=night), load("altaz"), seed=1)

    assert scans.scan_of(problem, reversing=False).longest == pytest.approx(5 * HOUR)


@pytest.mark.parametrize(("sure", "wins"), [(6.5, True), (5.5, False)])
def test_an_oscillation_is_confirmed_by_odds_of_twenty_to_one(monkeypatch, sure, wins):
    """As every change with time, its period paid for."""
    asked = []
    monkeypatch.setattr(contenders, "confirmed", lambda *given: asked.append(given[-1]) or sure)
    problem = case(SWINGS["held"])
    proposal = oscillations.proposed(problem, weigh(problem).covariance, ())
    found = contenders.waves_of(problem, (), proposal)

    assert [one.trial.evidence for one in found] == ([sure] if wins else [])
    independent = 2 * np.log(scans.scan_of(problem, reversing=False).coherent)
    assert len(asked) == 1
    assert independent + 2 < asked[0] < independent + 6


def test_an_oscillation_that_loses_to_a_step_is_told_from_it(monkeypatch):
    """Its columns stand in the case of the step, where its name is resampled."""
    both = lambda at: SWINGS["held"](at) + 9.0 * (NIGHT > 1)  # noqa: E731
    problem = case(both)
    weighed = weigh(problem)
    beside = weighed.evidence.beside([problem.part(one) for one in problem.base])
    trials = winner.trials_of(problem, beside)
    monkeypatch.setattr(
        contenders,
        "confirmed",
        lambda _, __, one, ___: {"epoch_offset": 50.0, OSCILLATION: 20.0}.get(
            one.candidate.effect.id, 0.0
        ),
    )
    changes = Changes(problem, weighed.covariance, (), trials)
    wins = winner.winner_of(
        problem, weighed, (), trials, lambda *_: 0.0, beside=beside, banned=(), changes=changes
    )
    (rival,) = (one for one in wins.rivals if one.candidate.effect.id == OSCILLATION)
    own = problem.stack.columns(rival.candidate.effect, problem.recordings.at)

    assert wins.chosen.candidate.effect.id == "epoch_offset"
    np.testing.assert_array_equal(
        wins.problem.picked(rival.candidate.columns), own[:, list(rival.candidate.coefficients)]
    )
    assert wins.beside.share(wins.trial, rival) < 0.5


@pytest.mark.parametrize(
    ("half", "double", "line"),
    [
        (0.0, 0.0, True),
        (49.0, 0.0, True),
        (51.0, 0.0, False),
        (0.0, 51.0, False),
        (0.0, 49.0, True),
    ],
)
def test_waves_of_other_periods_explain_little_of_an_oscillation(monkeypatch, half, double, line):
    """Else it is noise over a range of periods; where the phase holds nothing is asked."""
    evidence = {30.0: half, 60.0: 100.0, 120.0: double}
    fits = SimpleNamespace(fit=lambda period: (evidence[period],))
    monkeypatch.setattr(wave_fits, "_waves", lambda *_: fits)

    assert wave_fits.is_line(None, None, (), oscillation(60.0, 0.0, [(0.0, 180.0)])) == line
    assert wave_fits.is_line(None, None, (), oscillation(60.0, 0.0))


@pytest.mark.parametrize(("line", "waves"), [(True, 1), (False, 0)])
def test_what_is_no_line_is_no_wave(monkeypatch, swinging, line, waves):
    """Whatever its evidence: the noise has power there."""
    _, problem, one = swinging
    monkeypatch.setattr(contenders, "is_line", lambda *_: line)

    assert len(contenders.waves_of(problem, (), one)) == waves


@pytest.mark.parametrize("seed", [1, 3, 7])
def test_readings_repeated_at_a_multiple_of_a_period_show_no_wave(seed):
    """A phase that holds is a constant there, which drifts know; a free one gained hundreds."""
    n = np.arange(900)
    time = 1.2e9 + n // 3 * 7200.0 + n % 3 * 5.0
    problem = prepare(recordings(900, seed, time=time, session=np.full(900, "s")), load("altaz"))
    covariance = weigh(problem).covariance
    scan = scans.scan_of(problem, reversing=False)
    (peaks,) = periods.peaks_of(scan, [scans.view_of(problem, scan, covariance, ())])

    assert max(one.worth for one in peaks) < CONVINCING


def test_a_period_of_months_is_found():
    """In sessions of a hundred days, ten of them in as many years."""
    time = 1e9 + np.repeat(np.arange(10) * 365.25, 40) * 86400
    time += np.tile(np.arange(40) * 2.5, 10) * 86400
    period = 21 * 86400.0
    session = np.char.add("s", np.repeat(np.arange(10), 40).astype(str))
    swing = lambda _: 5 * np.sin(2 * np.pi * time / period)  # noqa: E731 - a wave
    problem = prepare(recordings(400, 5, time=time, session=session, y=swing), load("altaz"))
    one = oscillations.proposed(problem, weigh(problem).covariance, ())

    assert one.candidate.effect.parameter == pytest.approx(period, rel=0.01)


def test_nights_at_equal_intervals_leave_the_period_open():
    """How many periods went by between them is not known: that is part of the error."""
    equal = 1.2e9 + NIGHT * 4 * 86400.0 + (TIME - TIME[120 * NIGHT]) / 8
    sigma = {}
    for name, time in (("equal", equal), ("unequal", TIME)):
        swing = lambda _, time=time: 5 * np.sin(2 * np.pi * (time % 1800.0) / 1800.0)  # noqa: E731
        problem = prepare(recordings(480, 5, y=swing, time=time), load("altaz"), seed=1)
        effect = oscillation(1800.0)
        sigma[name] = wave_fits.likeliest_period(problem, weigh(problem).covariance, (), effect)[1]

    assert sigma["unequal"] < 0.001 * 1800 < 0.01 * 1800 < sigma["equal"]


@pytest.mark.parametrize("seed", [0, 4, 11])
def test_of_periods_that_nights_leave_open_the_likeliest_is_found(seed):
    """Nine days apart they fit a wave of five sigma to any of eight periods, nearly as well.

    To find the best of them each has to be met at its top, which the sums of a search miss by a
    twentieth.
    """
    night, rng = np.repeat(np.arange(5), 60), np.random.default_rng(seed)
    time = 1.2e9 + night * 9 * 86400 + np.sort(rng.uniform(0, 14 * 3600, (5, 60))).ravel()
    wave = lambda _: 12 * np.sin(2 * np.pi * (time - 1.2e9) / 2700)  # noqa: E731
    session = np.char.add("s", night.astype(str))
    given = recordings(300, seed, x=wave, time=time, session=session)
    problem = prepare(given, load("altaz"), seed=1)
    one = oscillations.proposed(problem, weigh(problem).covariance, ())

    assert wave_fits.period_of(one.candidate.effect) == pytest.approx(2700, abs=0.5)


def test_the_error_of_a_period_holds_what_else_it_may_be(monkeypatch):
    """By its odds: of two as likely a half of their distance squared, however many are tried."""
    tops = {1800.0: (1800.0, 1.0, 50.0), 1830.0: (1830.0, 1.0, 50.0), 1900.0: (1900.0, 1.0, 0.0)}
    waves = SimpleNamespace(scan=SimpleNamespace(time=np.array([0.0, 1e6])))
    monkeypatch.setattr(wave_fits, "_waves", lambda *_: waves)
    monkeypatch.setattr(wave_fits, "view_of", lambda *_: None)
    monkeypatch.setattr(wave_fits, "near_best", lambda *_: [1830.0, *([1900.0] * 10)])
    monkeypatch.setattr(wave_fits, "top", lambda _, grid: tops[round(float(grid[5]), 6)])
    period, sigma, evidence = wave_fits.likeliest_period(None, None, (), oscillation(1800.0))

    assert (period, evidence) == (1800.0, 50.0)
    assert sigma == pytest.approx(np.hypot(1.0, 30 / np.sqrt(2)), rel=1e-6)


@pytest.mark.slow
def test_nothing_is_said_of_an_axis_that_was_not_measured():
    """A wandering wave of elevations alone has an amplitude there, and no line."""
    given = made(SWINGS["wandering"])
    found = diagnose(replace(given, x=np.full(len(given.x), np.nan)), load("altaz"), seed=1)

    assert found.findings[0].effect == OSCILLATION
    assert [one.name for one in found.findings[0].parameters] == ["period", "amplitude_el"]


@pytest.mark.slow
def test_period_amplitude_and_phase_are_reported():
    """Each with its error; the sentence says them."""
    found = diagnose(made(SWINGS["held"]), load("altaz"), seed=1).findings[0]
    told = {one.name: one for one in found.parameters}
    since = np.datetime64(found.variant.partition("since ")[2].rstrip("Z"), "s").astype(float)
    phase = np.degrees(2 * np.pi * (since % PERIOD_S) / PERIOD_S + 1)

    assert (found.effect, found.verdict) == (OSCILLATION, "named")
    assert set(told) == {"period", "amplitude_xel", "phase_xel", "amplitude_el", "phase_el"}
    true = {"period": PERIOD_S / 60, "amplitude_el": 5.0, "amplitude_xel": 0.0}
    for name, value in true.items():
        assert abs(told[name].value - value) < 4 * told[name].sigma, name
    off = (told["phase_el"].value - phase + 180) % 360 - 180
    assert abs(off) < 4 * told["phase_el"].sigma < 40
    assert "period 59.99" in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize("reversing", [False, True])
def test_where_a_mount_turns_over_a_wave_may_keep_its_sign_or_change_it(monkeypatch, reversing):
    """What shakes the sky keeps it, what the second axis does changes it with the pier's side."""
    rng = np.random.default_rng(3)
    over = rng.random(480) < 0.5
    side = np.where(over, -1.0, 1.0) if reversing else 1.0
    wave = side * 5 * np.sin(2 * np.pi * TIME / PERIOD_S + 1)
    given = made(pier_side=np.where(over, OVER, "east"))
    x, y = 5 * rng.normal(size=(2, 480)) * ARCSEC
    given = replace(given, at=replace(given.at, mount=KINDS["german"]), x=x, y=y + wave * ARCSEC)
    problem = prepare(given, load("equatorial"), seed=1)
    one = oscillations.proposed(problem, weigh(problem).covariance, ())
    x, y = problem.stack.columns(one.candidate.effect, problem.recordings.at)[:, 2:].T

    assert one.candidate.effect.member["period_s"] == pytest.approx(PERIOD_S, rel=0.01)
    assert ("reversing" in one.candidate.effect.member) == reversing
    assert one.candidate.choices >= 2 * round(scans.scan_of(problem, reversing=False).coherent)
    of_y = problem.stack.is_y
    both = np.stack([x[of_y], y[of_y]], axis=1)
    left = wave - both @ np.linalg.lstsq(both, wave, rcond=None)[0]
    assert left.std() < 0.2 * wave.std()
    monkeypatch.setattr(oscillations, "_ways", lambda _: (reversing,))
    alone = oscillations.proposed(problem, weigh(problem).covariance, ())
    assert one.candidate.choices == pytest.approx(2 * alone.candidate.choices, abs=1)
