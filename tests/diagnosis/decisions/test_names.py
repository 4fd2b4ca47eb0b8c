"""Names: class, known sizes, halves, stability, and what takes a name away."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import beside, candidate, problem_with, rows_with, step, trial

from pyport.angles import ARCSEC
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.naming import classes, guards, scene
from pyport.diagnosis.naming import verdict as resampling
from pyport.diagnosis.naming.finding import Evidence, Finding, Stability, Where
from pyport.diagnosis.naming.nights import goes_with_the_hour, nights
from pyport.diagnosis.naming.verdict import judged
from pyport.effects import CATALOGUE, Coefficient
from pyport.effects.empirical import driven, drivers
from pyport.effects.empirical.epochs import epoch_step
from pyport.effects.telescope import encoders


def members(rivals, winner=None, **alike):
    """Return the class of a winner, refraction, among rivals."""
    winner = winner or trial("refraction", 100.0, gain=1000.0)
    return classes.name(winner, [winner, *rivals], beside(**alike)).members


@pytest.mark.parametrize(
    ("evidence", "inside"), [(93.0, True), (92.1, True), (91.9, False), (86.0, False)]
)
def test_a_rival_within_odds_of_fifty_to_one_stays_in_the_class(evidence, inside):
    """Eight behind the winner, in twice the log of the odds, is the end of the class."""
    found = members([trial("sag_sine", evidence, gain=900.0)])

    assert ("sag_sine" in found) == inside


@pytest.mark.parametrize(("evidence", "inside"), [(2.9, True), (2.7, False)])
def test_what_explains_nothing_joins_no_class(evidence, inside):
    """A rival that does not pay for its choice among four names, however weak the winner."""
    others = [trial(name, -3.0) for name in ("refraction", "skew", "tilt")]
    found = members([trial("sag_sine", evidence), *others], trial("refraction", 4.0))

    assert ("sag_sine" in found) == inside


@pytest.mark.parametrize(("evidence", "other"), [(93.0, True), (91.0, False)])
@pytest.mark.parametrize(
    ("term", "condition", "told"),
    [
        ("sag_cosine", "pressure_hpa", "sag_cosine follows pressure_hpa"),
        ("tilt", "yoke_temp_c", "tilt follows yoke_temp_c"),
        ("tilt", "sun_el_deg", "tilt follows sun_el_deg"),
        ("tilt", "the same", None),
    ],
)
@pytest.mark.parametrize("own", ["pressure_hpa", "the time of day"])
def test_of_driven_terms_another_term_and_another_condition_count(
    own, term, condition, told, evidence, other
):
    """Within odds of fifty to one; the same term of the same condition is no other."""

    def follows(what, which):
        effect = driven.driven(what, drivers.driver_of(which, 0.0))
        return Candidate(effect, np.arange(1), (0,), 24)

    winner = trial(of=follows("tilt", own), evidence=100.0)
    rival = trial(of=follows(term, own if told is None else condition), evidence=evidence)

    found = classes.name(winner, [winner, rival], beside())
    assert found.members == ("driven_term",)
    assert found.others == ((told,) if other and told else ())


@pytest.mark.parametrize(("evidence", "orders"), [(93.0, (4.0,)), (91.0, ())])
def test_how_often_a_wave_goes_round_may_be_open(evidence, orders):
    """Within odds of fifty to one, for the same effect alone; its name stays."""

    def wave(make, k):
        return Candidate(make(k), np.arange(1), (0,), 8)

    winner = trial(of=wave(encoders.elevation_encoder_harmonics, 5), evidence=100.0)
    rival = trial(of=wave(encoders.elevation_encoder_harmonics, 4), evidence=evidence)
    other, more = (trial(of=wave(encoders.azimuth_harmonics, k), evidence=97.0) for k in (3, 7))
    found = classes.name(winner, [winner, rival, other, more], beside())

    assert found.members == ("elevation_encoder_harmonics", "azimuth_harmonics")
    assert (found.orders, found.others) == (orders, ())


@pytest.mark.parametrize(
    ("share", "inside"), [(0.96, True), (0.91, True), (0.89, False), (0.5, False)]
)
def test_curves_alike_by_a_cosine_of_95_hundredths_are_one_class(share, inside):
    """A rival far behind stays when it draws the winner's curve with little more left."""
    found = members([trial("sag_sine", 50.0, gain=980.0)], sag_sine=share)

    assert ("sag_sine" in found) == inside


@pytest.mark.parametrize(
    ("gain", "behind", "inside"),
    [
        (1000.0, 45.0, True),
        (1000.0, 58.0, True),
        (1000.0, 62.0, False),
        (1000.0, 100.0, False),
        # Of a strong effect two per cent are more than sixty.
        (10000.0, 150.0, True),
        (10000.0, 195.0, True),
        (10000.0, 205.0, False),
        (10000.0, 350.0, False),
    ],
)
def test_of_curves_alike_the_one_that_leaves_more_is_excluded(gain, behind, inside):
    """By sixty, or by two per cent of a strong effect's gain: shapes are of first order."""
    winner = trial("refraction", 100.0, gain=gain)
    found = members([trial("sag_sine", 50.0, gain=gain - behind)], winner, sag_sine=0.97)

    assert ("sag_sine" in found) == inside


@pytest.mark.parametrize(("dof", "inside"), [(2, True), (3, False)])
def test_many_coefficients_are_no_likeness(dof, inside):
    """More than twice the winner's can draw any curve."""
    found = members([trial("sag_sine", 50.0, gain=980.0, dof=dof)], sag_sine=0.97)

    assert ("sag_sine" in found) == inside


def test_another_scope_is_no_likeness():
    """A curve of each antenna is not the curve that all share."""
    rival = trial("sag_sine", 50.0, gain=980.0, scope="antenna")

    assert members([rival], sag_sine=0.97) == ("refraction",)


@pytest.mark.parametrize(("share", "inside"), [(0.995, True), (0.985, False), (0.6, False)])
def test_the_same_curve_is_in_the_class_whatever_size_physics_allows(share, inside):
    """From a squared cosine of 0.99 on; below, an effect of wrong known size is passed over."""
    rival = trial("annual_aberration", 98.0, gain=990.0, value=500 * ARCSEC, sigma=0.1 * ARCSEC)

    assert ("annual_aberration" in members([rival], annual_aberration=share)) == inside


def test_the_runner_up_is_the_best_outside_of_the_class():
    """Of those outside, the one with the most evidence."""
    winner = trial("refraction", 100.0, gain=1000.0)
    rivals = [trial("skew", 20.0), trial("sag_sine", 30.0), trial("tilt", 95.0)]
    found = classes.name(winner, [winner, *rivals], beside())

    assert found.members == ("refraction", "tilt")
    assert found.runner_up.candidate.effect.id == "sag_sine"


def known_size(value_arcsec, sigma_arcsec):
    """Return a trial of an effect that physics fixes at 20 arcsec."""
    of = candidate("refraction")
    fixed = replace(of.effect, coefficients=(Coefficient("k", expected=20.0),))
    return trial(
        of=replace(of, effect=fixed), value=value_arcsec * ARCSEC, sigma=sigma_arcsec * ARCSEC
    )


@pytest.mark.parametrize(
    ("value", "sigma", "fits"),
    [
        # 4 sigma and a tenth of the size: 2 + 4 sigma.
        (25.8, 1.0, True),
        (26.2, 1.0, False),
        (14.2, 1.0, True),
        (13.8, 1.0, False),
        (21.9, 0.001, True),
        (22.1, 0.001, False),
        (20.9, 0.001, True),
        (23.9, 0.001, False),
        (29.0, 1.0, False),
        (23.5, 1.0, True),
        # With a sigma above half of its size it cannot have been seen.
        (20.0, 9.5, True),
        (20.0, 10.5, False),
        (20.0, 6.0, True),
        (20.0, 19.0, False),
    ],
)
def test_a_size_that_physics_fixes_must_come_out(value, sigma, fits):
    """Within four sigma and a tenth of it, of a sigma that is at most half of it."""
    assert classes.fits_physics(known_size(value, sigma)) == fits


@pytest.mark.parametrize(
    ("value", "sigma", "seen"),
    [
        (38.0, 1.0, True),
        (42.0, 1.0, False),
        (70.0, 1.0, False),
        (11.0, 1.0, True),
        (9.0, 1.0, False),
        (22.0, 1.0, True),
        (30.0, 1.0, True),
        (-20.0, 1.0, False),
        (20.0, 9.5, True),
        (20.0, 10.5, False),
    ],
)
def test_other_causes_may_bend_a_known_size_by_a_factor_of_two(value, sigma, seen):
    """With its sign, and seen: the sigma at most half of it."""
    assert classes.seen(known_size(value, sigma)) == seen


@pytest.mark.parametrize(
    ("extra", "sigma", "passed"),
    [
        # More than four sigma, and more than half of the strength.
        (0.6, 0.16, True),
        (0.6, 0.145, False),
        (0.6, 0.22, True),
        (0.6, 0.1, False),
        (0.45, 0.01, True),
        (0.55, 0.01, False),
        (0.3, 0.01, True),
        (0.9, 0.01, False),
    ],
)
def test_strengths_in_two_halves_refute_a_name(monkeypatch, extra, sigma, passed):
    """A second coefficient in one half must come out zero within four sigma, or small."""
    curve = np.full(2, np.sqrt(2) / sigma)
    monkeypatch.setattr(scene, "contribution", lambda *_: curve)
    monkeypatch.setattr(scene, "_halves", lambda _: {"the later half": np.array([False, True])})
    monkeypatch.setattr(scene, "_sessions", lambda _: {})
    problem = SimpleNamespace(
        expanded=lambda _: np.zeros((2, 0)), residual=curve * [1.0, 1.0 + extra]
    )
    weighed = SimpleNamespace(covariance=SimpleNamespace(whiten=lambda columns: columns))
    (check,) = scene.halves(problem, weighed, SimpleNamespace(choices=[None]), 0)

    assert check.passed == passed
    assert check.words == (
        f"strength in the later half: {1 + extra:+.2f} +- {sigma:.2f} of the rest's"
    )


def test_of_the_sessions_the_one_that_differs_most_is_reported(monkeypatch):
    """By its sigmas, and one alone: the second has three times the strength of the others."""
    session = np.repeat(["a", "b", "c"], 4)
    sessions = {one: session == one for one in "abc"}
    curve = np.tile([10.0, -10.0], 6)
    monkeypatch.setattr(scene, "contribution", lambda *_: curve)
    monkeypatch.setattr(scene, "_halves", lambda _: {})
    monkeypatch.setattr(scene, "_sessions", lambda _: sessions)
    problem = SimpleNamespace(
        expanded=lambda _: np.zeros((12, 0)), residual=curve * np.where(session == "b", 3.0, 1.0)
    )
    weighed = SimpleNamespace(covariance=SimpleNamespace(whiten=lambda columns: columns))
    (check,) = scene.halves(problem, weighed, SimpleNamespace(choices=[None]), 0)

    assert not check.passed
    assert check.words.startswith("strength in b: +3.00 +- ")


NAMED = Finding(
    *("refraction", ("refraction",), "named", "what was left out", Where(("el",)), ()),
    *(Evidence(1e-9, 50.0, None, None), 1e-5, 1e-5),
)


@pytest.mark.parametrize(
    ("kept", "names", "verdict"),
    [
        (33, {"skew": 7}, "named"),
        (32, {"skew": 8}, "named"),
        (31, {"skew": 9}, "ambiguous"),
        (18, {"skew": 22}, "ambiguous"),
        # Without any name in more than half of the draws there is nothing to name.
        (21, {}, "ambiguous"),
        (19, {}, "unknown"),
        (12, {}, "unknown"),
        (28, {}, "ambiguous"),
    ],
)
def test_a_name_must_come_back(kept, names, verdict):
    """In eight tenths of the draws to stand; where mostly none does it is unknown."""
    assert judged(NAMED, Stability("sessions", 40, kept, names)).verdict == verdict


@pytest.mark.parametrize(("count", "joins"), [(3, False), (4, True), (7, True), (2, False)])
def test_a_name_that_came_back_in_a_tenth_joins(count, joins):
    """Four draws of forty."""
    found = judged(NAMED, Stability("sessions", 40, 30 - count, {"tilt": 10, "skew": count}))

    assert ("skew" in found.members) == joins


@pytest.mark.parametrize(
    ("others", "verdict"), [(5, "ambiguous"), (6, "unknown"), (3, "ambiguous")]
)
def test_seven_names_are_no_name(others, verdict):
    """A class holds six at most."""
    names = ("skew", "tilt", "sag_sine", "sag_cosine", "drift", "temperature")
    found = judged(NAMED, Stability("sessions", 40, 10, dict.fromkeys(names[:others], 5)))

    assert found.verdict == verdict


@pytest.mark.parametrize(
    ("behind", "competes"), [(55.0, True), (65.0, False), (35.0, True), (110.0, False)]
)
def test_a_rival_out_of_reach_does_not_compete(behind, competes):
    """Sixty behind, it cannot come first in any draw."""
    turn = step(trial("refraction", 200.0), trials=[trial("sag_sine", 200.0 - behind)])

    assert bool(resampling._rivals(turn, {"refraction"})) == competes


def test_the_four_nearest_names_compete():
    """Once each, the best member of a family, and none that is taken or has no name."""
    names = ("skew", "tilt", "sag_sine", "sag_cosine", "collimation", "tilt", "azimuth_zero")
    trials = [trial(name, 190.0 - n) for n, name in enumerate(names)]
    turn = step(trial("refraction", 200.0), trials=trials)
    found = resampling._rivals(turn, {"refraction", "skew"})

    assert [one.candidate.effect.id for one in found] == list(names[1:5])


def of_sessions(count, times):
    """Return as much of a problem as resampling looks at: 60 rows in some sessions."""
    rows = np.arange(60)
    at = rows_with(60, **({"time": 1e9 + 60.0 * rows} if times else {}))
    return problem_with(
        session=rows * count // 60,
        pointing=rows,
        recordings=SimpleNamespace(at=at),
        stack=SimpleNamespace(row=rows),
    )


@pytest.mark.parametrize(
    ("sessions", "effect", "times", "drawn", "units"),
    [
        (12, "refraction", True, "sessions", 12),
        (10, "refraction", True, "sessions", 10),
        (9, "refraction", True, "blocks of time", None),
        (6, "refraction", True, "blocks of time", None),
        (12, "epoch_tilt", True, "blocks of time", None),
        (2, "refraction", True, "blocks of time", None),
        (2, "refraction", False, "pointings", 40),
    ],
)
def test_what_is_drawn_with_replacement(sessions, effect, times, drawn, units):
    """Ten sessions whole; fewer, or for a change, blocks of time; pointings without times."""
    own = SimpleNamespace(candidate=candidate(effect), scope="all")
    words, unit = resampling._units(of_sessions(sessions, times), own)

    assert words == drawn
    assert len(np.unique(unit)) == (units or len(np.unique(unit)))
    if drawn == "blocks of time":
        assert 40 <= len(np.unique(unit)) <= 40 + sessions


def test_evidence_on_resampled_data_is_that_of_the_blocks():
    """What one column gains beside the model, twice the drawn products, half with an excess."""
    rng = np.random.default_rng(0)
    model, one, data = rng.normal(size=(200, 1)), rng.normal(size=(200, 1)), rng.normal(size=200)
    one += 2 * model
    data = data + one[:, 0]
    columns = np.concatenate([model, one, data[:, None]], axis=1)
    products = columns.T @ columns
    (plain,) = resampling._worths(products, [slice(1, 2)], [1.0])
    (twice,) = resampling._worths(2 * products, [slice(1, 2)], [1.0])
    (shared,) = resampling._worths(2 * products, [slice(1, 2)], [2.0])

    left = one[:, 0] - model[:, 0] * (model[:, 0] @ one[:, 0]) / (model[:, 0] @ model[:, 0])
    rest = data - model[:, 0] * (model[:, 0] @ data) / (model[:, 0] @ model[:, 0])
    gain = (left @ rest) ** 2 / (left @ left)

    assert gain - 8 < plain < gain
    assert twice - plain == pytest.approx(gain, rel=0.02)
    assert shared == pytest.approx(plain, abs=1e-9)


def scene_of(times, values=None, sessions=None, **more):
    """Return as much of a scene as guards look at."""
    times = np.asarray(times, float)
    rows = np.arange(len(times))
    at = rows_with(len(times), time=times, temperature_c=values)
    case = problem_with(
        recordings=SimpleNamespace(at=at, label=lambda _: more["labels"]),
        session=np.zeros(len(times), int) if sessions is None else np.asarray(sessions),
        pointing=rows,
        stack=SimpleNamespace(row=rows, is_y=np.ones(len(times), bool)),
        residual=more.get("residual"),
    )
    return SimpleNamespace(
        problem=case,
        weighed=SimpleNamespace(used=np.ones(len(times), bool)),
        floor=np.ones(len(times)),
        neglected=more.get("neglected", 0.0),
        joint=SimpleNamespace(
            solution=SimpleNamespace(rank=more.get("rank", 7)), predicted=np.zeros(len(times))
        ),
    )


@pytest.mark.parametrize(
    ("effect", "seen", "refused"),
    [
        ("azimuth_eccentricity", 0.9, True),
        ("azimuth_eccentricity", 1.1, False),
        ("epoch_offset", 0.9, False),
    ],
)
def test_what_is_smaller_than_what_terms_lose_has_no_name(effect, seen, refused):
    """Whatever lasts: products of the model's terms do not change with time."""
    scene = scene_of(np.arange(40), sessions=np.arange(40) // 20, neglected=1.0)
    found = guards.refusal(scene, candidate(effect).effect, np.resize([seen, -seen, 0.0], 40))

    assert (found is not None) == refused
    assert not refused or "only add up" in found.reason


@pytest.mark.parametrize(
    ("rows", "rank", "enough_"),
    [(27, 7, True), (26, 7, False), (35, 7, True), (20, 7, False), (40, 20, True), (39, 20, False)],
)
def test_twenty_numbers_beyond_the_coefficients_are_enough(rows, rank, enough_):
    """Fewer, and nothing that was found keeps a name, nor is anything looked for."""
    scene = scene_of(np.arange(rows), rank=rank)
    found = guards._too_few(scene, np.ones(rows))

    assert (found is None) == enough_
    assert (guards.lacking(rows, rank) == 0) == enough_
    assert enough_ or "too few" in found.reason


@pytest.mark.parametrize(("carried", "enough_"), [(4, True), (3, False), (2, False), (6, True)])
def test_four_pointings_must_carry_an_effect(carried, enough_):
    """The effective number of pointings in the weight of its curve."""
    seen = np.zeros(60)
    seen[:carried] = 1.0
    found = guards._too_few(scene_of(np.arange(60)), seen)

    assert (found is None) == enough_
    assert guards.carriers(scene_of(np.arange(60)), seen) == pytest.approx(carried)


@pytest.mark.parametrize(("numbers", "known"), [(15, True), (14, False), (12, False), (22, True)])
def test_eight_numbers_tell_the_scatter_that_a_limit_needs(numbers, known):
    """Beyond seven coefficients; fewer, and the scatter may be near zero by chance."""
    assert guards.TooFew(numbers, numbers, 7).scatter_known == known


HOURS = 3600.0


@pytest.mark.parametrize(("rows", "counted"), [(4, 2), (3, 1), (2, 1), (7, 2)])
def test_a_night_has_four_pointings(rows, counted):
    """A run with fewer is no night."""
    first = 1e9 + 600.0 * np.arange(10)
    second = first[-1] + 86400 + 600.0 * np.arange(rows)

    assert nights(scene_of(np.concatenate([first, second]))) == counted


def test_a_pointing_that_is_recorded_often_makes_no_night():
    """Four readings of it are one pointing."""
    times = 1e9 + np.append(600.0 * np.arange(10), np.full(4, 90000.0))
    scene = scene_of(times)
    scene.problem.pointing = np.append(np.arange(10), np.full(4, 10))

    assert nights(scene) == 1


def test_what_is_lacking_is_said_in_pointings():
    """Of one axis each brings one number, of two it brings two."""
    one, both = scene_of(np.arange(16)), scene_of(np.arange(16))
    both.problem.stack.is_y = np.arange(16) % 2 == 1
    told = [guards._too_few(scene, np.ones(16)).decide_by for scene in (one, both)]

    assert told == ["record at least 11 more pointings", "record at least 6 more pointings"]


@pytest.mark.parametrize(("days", "counted"), [(0.3, 1), (1.2, 1), (1.8, 2), (3.4, 3)])
def test_a_run_without_a_gap_counts_by_days(days, counted):
    """Of recordings that go on day and night each day is one."""
    times = 1e9 + np.linspace(0, days * 86400, 200)

    assert nights(scene_of(times)) == counted


@pytest.mark.parametrize(
    ("noise", "went"), [(0.1, True), (0.3, True), (0.36, False), (0.6, False), (0.25, True)]
)
def test_what_a_cubic_in_time_draws_went_with_the_hour(noise, went):
    """Nine tenths of its variance."""
    phase = np.linspace(-1, 1, 400)
    smooth = (5 * phase**3 - 3 * phase) / 2 + phase
    other = np.cos(40 * np.pi * phase)
    values = smooth / smooth.std() + noise * other / other.std()

    assert goes_with_the_hour(scene_of(1e9 + 9 * HOURS * phase, values), "temperature_c") == went


def test_a_quartic_is_more_than_one_night_does():
    """Rise, fall and turn are drawn; one turn more is not."""
    phase = np.linspace(-1, 1, 400)
    quartic = np.polynomial.legendre.legval(phase, [0, 0, 0, 0, 1])
    cubic = np.polynomial.legendre.legval(phase, [0, 0, 0, 1])

    assert goes_with_the_hour(scene_of(1e9 + 9 * HOURS * phase, cubic), "temperature_c")
    assert not goes_with_the_hour(scene_of(1e9 + 9 * HOURS * phase, quartic), "temperature_c")


@pytest.mark.parametrize(
    ("size", "sigma", "back"),
    [
        # Seen from two sigmas on.
        (0.9, 0.42, True),
        (0.9, 0.47, False),
        (0.9, 0.3, True),
        (0.9, 0.8, False),
        # Alike within three sigma, or a half.
        (1.45, 0.01, True),
        (1.55, 0.01, False),
        (1.3, 0.01, True),
        (1.9, 0.01, False),
        (1.85, 0.3, True),
        (1.95, 0.3, False),
        (1.7, 0.3, True),
        (2.7, 0.3, False),
    ],
)
def test_a_curve_comes_back_in_a_second_night(size, sigma, back):
    """With about its size in all nights: seen, and not of another strength."""
    rows = 20
    times = np.concatenate([1e9 + 600.0 * np.arange(rows), 1e9 + 86400 + 600.0 * np.arange(rows)])
    seen = np.full(2 * rows, 1 / np.sqrt(rows) / sigma)
    first = np.arange(2 * rows) < rows
    # The first night has it as it is, the second by `size`; both with the same sigma.
    scene = scene_of(times, residual=np.where(first, 0.0, (size - 1) * seen))
    if sigma > 0.4:
        # The first night is surer, so that the second alone decides.
        seen = np.where(first, 5 * seen, seen)
        scene = scene_of(times, residual=np.where(first, 0.0, (size - 1) * seen))

    assert guards.comes_back(scene, np.ones(2 * rows, bool), seen) == back


@pytest.mark.parametrize(
    ("effect", "nights", "sessions", "refused"),
    [
        ("epoch_tilt", 1, 1, True),
        ("epoch_tilt", 2, 1, False),
        ("epoch_tilt", 1, 2, False),
        ("refraction", 1, 1, False),
    ],
)
def test_a_change_needs_a_second_session(effect, nights, sessions, refused):
    """Or a second night."""
    times = 1e9 + 600.0 * np.arange(20) + 86400.0 * (np.arange(20) * nights // 20)
    scene = scene_of(times, sessions=np.arange(20) * sessions // 20)

    assert (guards._one_session(scene, CATALOGUE[effect]) is not None) == refused


@pytest.mark.parametrize(
    ("nights", "noise", "refused"), [(1, 0.1, True), (2, 0.1, False), (1, 1.0, False)]
)
def test_what_went_with_the_hour_needs_a_second_night(nights, noise, refused):
    """One night has one curve of temperature; weather that jumps is no curve."""
    phase = np.linspace(-1, 1, 40)
    times = 1e9 + 9 * HOURS * phase + 86400.0 * (np.arange(40) * nights // 40)
    scene = scene_of(times, phase + noise * np.cos(np.pi * np.arange(40)))

    assert (guards._one_night(scene, CATALOGUE["temperature"]) is not None) == refused


@pytest.mark.parametrize(
    ("nights", "known", "said"),
    [(1, "time", "are of one night"), (1, "order", "of more than one night"), (6, "order", None)],
)
def test_the_order_of_the_rows_tells_what_went_with_the_hour(nights, known, said):
    """Where no times are known; whether it is one night nothing says then."""
    phase = np.linspace(-1, 1, 60)
    when, values = 1e9 + 9 * HOURS * phase, np.cos(nights * np.pi * phase)
    scene = scene_of(when)
    scene.problem.recordings.at = rows_with(60, **{known: when, "temperature_c": values})
    found = guards._one_night(scene, CATALOGUE["temperature"])

    assert (found is None) == (said is None)
    assert found is None or said in found.reason


@pytest.mark.parametrize(("size", "refused"), [(1.0, False), (0.0, True)])
def test_what_belongs_to_a_source_must_come_back_with_it(size, refused):
    """An offset on one night is none of the catalogue's."""
    times = np.concatenate([1e9 + 600.0 * np.arange(20), 1e9 + 86400 + 600.0 * np.arange(20)])
    seen = np.full(40, 3.0)
    residual = np.where(np.arange(40) < 20, 0.0, (size - 1) * seen)
    scene = scene_of(times, residual=residual, labels=np.full(40, "3C 84"))
    effect = next(one for one in CATALOGUE.values() if one.belongs_to)

    assert (guards._once_only(scene, effect, seen) is not None) == refused


@pytest.mark.parametrize(("field", "refused"), [(45.0, True), (40.0, False), (60.0, True)])
def test_what_came_back_has_no_name_where_a_field_that_lasts_does_as_well(
    monkeypatch, field, refused
):
    """Within eight of its fifty."""
    effect = epoch_step(1e9, CATALOGUE["epoch_offset"], 2e9)
    turn = step(trial(evidence=50.0, of=replace(candidate("epoch_offset"), effect=effect)))
    scene = SimpleNamespace(
        outcome=SimpleNamespace(chosen=(turn.chosen,), step_of=lambda _: turn),
    )
    best = SimpleNamespace(evidence=field, field=SimpleNamespace(variant="a box"))
    monkeypatch.setattr(guards, "lasting_instead", lambda *_: best)
    found = guards._in_a_part_of_the_sky(scene, effect)

    assert (found is not None) == refused
    assert not refused or "a box" in found.reason
