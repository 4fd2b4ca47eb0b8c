"""Steps between drifts: found at their moment, named by what is left of them beside the noise."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis.made import LATITUDE, recordings

from pyport.angles import ARCSEC
from pyport.diagnosis import joint
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming import scene as scenes
from pyport.diagnosis.naming import verdict
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching import refining, settling
from pyport.diagnosis.searching import search as searching
from pyport.diagnosis.weighing import plain_view, weigh
from pyport.effects import CATALOGUE
from pyport.effects.empirical.epochs import epoch_step
from pyport.formats.models import load
from pyport.mounts import KINDS

NIGHTS, EACH = 6, 50
NIGHT = np.repeat(np.arange(NIGHTS), EACH)
TIME_S = 1.2e9 + 86400 * NIGHT + np.tile(np.linspace(0, 8 * 3600, EACH), NIGHTS)
#: The last row before the step, in the fourth night.
LAST = 170


def drifting(seed):
    """Return a drift of unit scatter and a memory of an hour in each axis, shape (2, n)."""
    rng = np.random.default_rng([7, seed])
    fresh, drift = rng.standard_normal((2, len(NIGHT))), np.zeros((2, len(NIGHT)))
    for n, gap in enumerate(np.diff(TIME_S, prepend=-np.inf)):
        kept = np.exp(-gap / 3600) if n and NIGHT[n] == NIGHT[n - 1] else 0.0
        drift[:, n] = kept * drift[:, n - 1] + np.sqrt(1 - kept**2) * fresh[:, n]
    return drift


@cache
def told(step_arcsec, seed, nights_arcsec=0.0):
    """Diagnose six nights whose noise, 3 arcsec, drifts, 3 arcsec, and offsets may hide a step."""
    drift, after = 3 * drifting(seed), np.arange(len(NIGHT)) > LAST
    drift += np.random.default_rng([9, seed]).normal(0, nights_arcsec, (2, NIGHTS))[:, NIGHT]
    made = recordings(
        len(NIGHT),
        seed,
        noise_arcsec=3.0,
        x=lambda _: drift[0] + step_arcsec * after,
        y=lambda _: drift[1] - step_arcsec * after,
        time=TIME_S,
        session=np.array([f"night {n}" for n in NIGHT]),
    )
    return diagnose(made, load("altaz"))


def since(done):
    """Return the first row after the first change that was found."""
    choice = done.after.choices[done.findings[0].choice]
    return int(np.searchsorted(TIME_S, choice.candidate.effect.parameter))


@pytest.mark.parametrize(("step_arcsec", "seed"), [(10, 0), (10, 2), (12, 0), (15, 3), (25, 2)])
def test_a_step_within_a_drifting_night_is_found_at_its_row(step_arcsec, seed):
    """And named: no other change leaves as little to the noise."""
    found = told(step_arcsec, seed).findings

    assert [one.effect for one in found] == ["epoch_offset"]
    assert found[0].verdict == "named"
    assert found[0].members == ("epoch_offset",)
    assert since(told(step_arcsec, seed)) == LAST + 1


@pytest.mark.parametrize(("step_arcsec", "seed"), [(15, 0), (20, 3), (30, 2)])
def test_nights_apart_from_all_others_hide_no_step_within_a_night(step_arcsec, seed):
    """What single nights depart by, 8 arcsec, the noise does; a step within one it does not."""
    done = told(step_arcsec, seed, 8.0)

    assert [one.effect for one in done.findings] == ["epoch_offset"]
    assert abs(since(done) - LAST - 1) <= 1


@pytest.mark.parametrize(("step_arcsec", "seed"), [(40, 0), (60, 2), (100, 0)])
def test_a_large_step_makes_no_outliers(step_arcsec, seed):
    """The readings after it are no mistakes: the step comes before them."""
    done = told(step_arcsec, seed)

    assert since(done) == LAST + 1
    assert done.weighed.used.reshape(2, -1)[:, LAST + 1].all()


ROWS = np.arange(120)


def seconds_of(time):
    """Return a moment in seconds since 1970."""
    return np.datetime64(time.rstrip("Z"), "s").astype(float)


def displaced(rows, since, until, **night):
    """Return the finding of one night of 3 arcsec of noise in which the zeros were displaced."""
    inside = (np.arange(rows) >= since) & (np.arange(rows) < until)
    made = recordings(
        rows, 0, noise_arcsec=3.0, x=lambda _: 20.0 * inside, y=lambda _: -20.0 * inside
    )
    night = night or {"time": 1.2e9 + 120.0 * ROWS[:rows]}
    (found,) = diagnose(replace(made, at=replace(made.at, columns=night)), load("altaz")).findings
    return found


@pytest.mark.parametrize(("since", "until"), [(20, 32), (50, 95)])
def test_what_moved_and_came_back_is_one_finding(since, until):
    """From its first moment to its last, with the size that it had in between."""
    found = displaced(120, since, until)
    moments = [1.2e9 + 120 * (n - 0.5) for n in (since, until)]

    assert found.variant.startswith("step and back, from ")
    seconds = [seconds_of(one) for one in (found.where.since, found.where.until)]
    assert seconds == pytest.approx(moments, abs=120)
    first, last = map(seconds_of, found.where.between)
    assert first <= moments[0] <= last
    for one, size in zip(found.parameters, (20, -20), strict=True):
        assert one.value == pytest.approx(size, abs=4 * one.sigma)


def test_what_came_back_without_times_is_between_rows():
    """In the file's numbers of rows: the first is 1. In how many nights nothing says."""
    found = displaced(60, 20, 32, order=ROWS[:60])

    assert (found.verdict, found.variant) == ("unknown", "step and back, rows 21 to 32")


def test_what_stays_has_no_end():
    """The second moment must earn its price."""
    found = displaced(120, 70, 120)

    assert found.variant.startswith("step, since ")
    assert found.where.until is None


def steps_of(id_, sessions):
    """Return the steps that are tried of an effect in 120 readings of some sessions."""
    night = ROWS * sessions // 120
    made = recordings(
        120,
        0,
        noise_arcsec=3.0,
        x=lambda _: 20.0 * ((ROWS >= 50) & (ROWS < 70)),
        time=1.2e9 + 120.0 * ROWS + 86400.0 * night,
        session=night.astype(str),
    )
    problem = prepare(made, load("altaz"))
    noise = weigh(problem).covariance
    step = epoch_step(1.2e9, CATALOGUE[id_])
    return refining._steps(problem, plain_view(problem, noise, ()), step)


@pytest.mark.parametrize(("arcsec", "least", "most"), [(5.0, 2, 30), (60.0, 1, 1)])
def test_how_well_a_moment_is_known_goes_with_the_size_of_the_step(arcsec, least, most):
    """Between more recordings where it is small; between two where it is large."""
    made = recordings(
        120,
        0,
        noise_arcsec=3.0,
        y=lambda _: arcsec * (ROWS >= 70),
        time=1.2e9 + 120.0 * ROWS,
        session=np.full(120, "night"),
    )
    problem = prepare(made, load("altaz"))
    plain = next(one for one in problem.candidates if one.effect.id == "epoch_offset")
    step = epoch_step(1.2e9 + 120 * 69.5, CATALOGUE["epoch_offset"])
    problem, one = problem.with_member(Chosen(plain, "all"), step)
    noise = weigh(problem, (one,)).covariance
    first, last = refining.began_between(problem, noise, (), one)
    rows = (last - first) / 120

    assert first <= step.parameter <= last
    assert least <= rows <= most


def test_a_step_pays_for_each_moment():
    """To step back is a choice among all readings, twice the log of how many they are."""
    prices = {one.came_back: price for one, price in steps_of("epoch_offset", 2)}

    assert prices[True] == pytest.approx(3 * prices[False])
    assert prices[False] == pytest.approx(np.log(240), abs=0.1)


def test_only_zeros_come_back_and_in_the_same_session():
    """Of sessions that scatter some are always between others."""
    assert not any(one.came_back for one, _ in steps_of("epoch_tilt", 2))
    back = [(one.parameter, one.until) for one, _ in steps_of("epoch_offset", 2) if one.came_back]
    began, ended = ((np.array(each) - 1.2e9) / 86400 for each in zip(*back, strict=True))

    # The nights are 0.00 to 0.08 and 1.08 to 1.17; a moment between them is 0.58.
    assert len(back) > 1
    np.testing.assert_array_equal(began > 0.5, ended > 0.6)


@pytest.mark.parametrize("start", [25, 30, 36])
def test_both_moments_of_what_came_back_are_moved(start):
    """Beside the best step back the first moment is chosen anew."""
    left = 5.0 * ((np.arange(80) >= 30) & (np.arange(80) < 50))
    shown = refining._Shown.of(np.ones((80, 1)), np.zeros((80, 1)), left)

    assert refining._back(shown, np.arange(8, 73), start, np.zeros(80, int)) == (30, 50)


@cache
def found_with_drifts():
    """Return the scene of a step, its place among the choices, and its turn."""
    outcome, _ = settling.settled(searching.search(told(12, 1).problem))
    fit = joint.fit(outcome.problem, outcome.weighed, outcome.chosen)
    where = scenes.scene(outcome.problem, outcome, fit)
    return where, len(outcome.problem.base), outcome.steps[0]


def drawn(evidence):
    """Return the stability of a step of so much evidence."""
    where, place, step = found_with_drifts()
    winner = replace(step.winner, evidence=evidence)
    return verdict.stability(where, place, replace(step, winner=winner), ())


@pytest.mark.parametrize(
    ("evidence", "least", "most"), [(100.0, 38, 40), (15.0, 30, 39), (8.0, 14, 28), (3.0, 0, 9)]
)
def test_what_the_noise_cannot_do_decides_whether_a_step_comes_back(evidence, least, most):
    """Not its gain, most of which the noise could have had."""
    found = drawn(evidence)

    assert least <= found.kept <= most
    assert (found.weak > 0) == (evidence < 100)


def drifts_of(step):
    """Return the trials of drifts in a turn."""
    return [one for one in step.trials if one.candidate.effect.id == "drift"]


@pytest.mark.parametrize(("odds", "kept", "instead"), [(50.0, False, True), (-50.0, True, False)])
def test_only_what_the_noise_cannot_do_competes_with_a_step(monkeypatch, odds, kept, instead):
    """However much another change gains beside the noise that is left."""
    monkeypatch.setattr(verdict, "confirmed", lambda *_: odds)
    monkeypatch.setattr(verdict, "_rivals", lambda step, _: drifts_of(step)[:1])
    found = drawn(20.0)

    assert (found.kept >= 30) == kept
    assert (found.names.get("drift", 0) >= 30) == instead


def test_draws_in_which_the_noise_does_as_well_are_told():
    """As neither the name nor another."""
    found = drawn(8.0)

    assert f"not beyond what noise can do in {found.weak}" in found.counts
    assert found.kept + found.weak + sum(found.names.values()) + found.nameless == found.draws


def test_only_steps_have_a_moment_to_move():
    """Other numbers of an effect, the order of a harmonic or an edge, are none."""
    problem = told(12, 0).problem
    harmonic = next(
        one
        for one in problem.candidates
        if one.effect.parameter is not None and not one.effect.is_change
    )

    assert refining.past_outliers(problem, None, Chosen(harmonic, "all")) == (problem, [])


@pytest.mark.slow
def test_a_clock_that_is_late_from_a_night_on_is_no_tilt():
    """One second, half a tilt to the east and half a zero of azimuth, named with its size."""
    found = late(np.arange(300) >= 160, nights(300, 160))

    assert (found.effect, found.verdict) == ("epoch_clock", "named")
    assert found.parameters[0].value == pytest.approx(1, abs=3 * found.parameters[0].sigma)
    assert found.parameters[0].unit == "s"


@pytest.mark.slow
def test_a_clock_that_loses_through_eight_nights_is_no_step():
    """A second in each of them, though the last night is later than the first by a week."""
    night = np.arange(480) // 60
    time = 1.2e9 + 86400 * night + 120.0 * np.arange(480)
    found = late((time - time[0]) / 86400, {"session": night.astype(str), "time": time})

    assert (found.effect, found.variant, found.verdict) == ("clock_rate", "set once", "named")
    assert found.parameters[0].value == pytest.approx(1, abs=3 * found.parameters[0].sigma)
    assert found.parameters[0].unit == "s/d"


def late(seconds, labels):
    """Return the only finding in recordings (n,) with a clock that is late by some seconds (n,)."""
    shift = 15 * seconds
    made = recordings(
        len(shift),
        4,
        x=lambda at: (
            shift
            * (np.sin(LATITUDE) * np.cos(at.el) - np.cos(LATITUDE) * np.sin(at.el) * np.cos(at.az))
        ),
        y=lambda at: shift * np.cos(LATITUDE) * np.sin(at.az),
        **labels,
    )
    (found,) = diagnose(made, load("altaz")).findings
    return found


def reset(mount, size_arcsec=15.0):
    """Return recordings of two nights before a first angle's zero was set anew and two after."""
    made = recordings(300, 5, noise_arcsec=3.0, **nights(300, 160))
    at = replace(made.at, mount=KINDS[mount])
    x, y = 3 * ARCSEC * np.random.default_rng(5).normal(size=(2, 300))
    off = size_arcsec * ARCSEC * (np.arange(300) >= 160)
    return replace(made, at=at, x=x + off * np.cos(at.axes.el), y=y)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mount", "name"), [("altaz", "epoch_azimuth_zero"), ("fork", "epoch_hour_angle_zero")]
)
def test_a_zero_that_is_set_anew_is_named_with_its_size(mount, name):
    """It falls with the cosine of the second angle, as no offset of the beam does."""
    made = reset(mount)
    (found,) = diagnose(made, load("altaz").on(made.at.mount)).findings

    assert found.effect == name
    assert found.parameters[0].value == pytest.approx(15, abs=3 * found.parameters[0].sigma)


def nights(rows, first):
    """Return sessions and times of two nights before a row and of two behind it."""
    night = np.digitize(np.arange(rows), [first // 2, first, (first + rows) // 2])
    time = 1.2e9 + 86400 * night + 120.0 * np.arange(rows)
    return {"session": np.char.add("n", night.astype(str)), "time": time}
