"""Data left out: what is left out together, what counts, and which findings stay."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import beside, candidate, problem_with, rows_with, step, trial

from pyport.diagnosis import holdout, joint
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.folds import Folds, folds
from pyport.diagnosis.naming import scene
from pyport.diagnosis.searching import settling
from pyport.diagnosis.searching.turns import Outcome
from pyport.effects.empirical.epochs import epoch_step
from pyport.least_squares.gram import Solution


def problem(rows=120, sessions=4, antennas=1, *, times=True, **more):
    """Return as much of a problem as the choice of folds looks at."""
    row = np.arange(rows)
    known = {"time": 1e9 + 60.0 * row} if times else {}
    if more.get("scans"):
        known["scan_direction"] = np.ones(rows)
    return problem_with(
        session=row * sessions // rows,
        pointing=row,
        recordings=SimpleNamespace(at=rows_with(rows, **known)),
        stack=SimpleNamespace(row=row, is_y=np.ones(rows, bool)),
        blocks=SimpleNamespace(antennas=antennas),
    )


def chosen(effect="refraction", scope="all", **more):
    """Return a choice."""
    return Chosen(candidate(effect, **more), scope)


def weighed(*, departing=False):
    """Return a weighing in which sessions depart, or do not."""
    some = [SimpleNamespace(of="session")] if departing else []
    return SimpleNamespace(covariance=SimpleNamespace(departures=some))


@pytest.mark.parametrize(
    ("sessions", "count", "whole"),
    [
        (3, 3, True),
        (2, 10, False),
        (1, 5, False),
        (5, 5, True),
        (20, 20, True),
        (40, 20, True),
        (21, 20, True),
        (14, 14, True),
        (30, 20, True),
    ],
)
def test_whole_sessions_are_left_out_from_three_on(sessions, count, whole):
    """Twenty folds at most; of fewer sessions five blocks of time in each."""
    found = folds(problem(sessions=sessions), weighed(), (chosen(),))

    assert ("session out" in found.scheme or "whole sessions" in found.scheme) == whole
    assert len(np.unique(found.fold)) == (count if whole else 5)
    assert not found.departing


@pytest.mark.parametrize(
    ("choice", "departing", "counts"),
    [
        (chosen("epoch_tilt"), False, False),
        (chosen("epoch_tilt"), True, False),
        (chosen(of_time=True), False, False),
        (chosen("tilt", "antenna and session"), False, False),
        (chosen(), True, True),
    ],
)
def test_what_belongs_to_a_session_is_tested_within_it(choice, departing, counts):
    """A change must do better than the model alone: no departure is granted to it."""
    found = folds(problem(), weighed(departing=departing), (choice,))

    own = ", what a session departs by predicted from its others" if counts else ""
    assert found.scheme == f"leave blocks of time out, five in each session{own}"
    assert found.departing == counts
    assert len(np.unique(found.fold)) == 5


@pytest.mark.parametrize(
    ("effect", "apart"), [("clock_rate", 1), ("temperature", 0), ("refraction", 0)]
)
def test_blocks_are_of_time_and_even(effect, apart):
    """Each session is cut into five; of what goes with the hour they lack different ones."""
    found = folds(problem(rows=100, sessions=2), weighed(), (chosen(effect),))

    assert found.fold[:50].tolist() == np.repeat(np.arange(5), 10).tolist()
    assert found.fold[50:].tolist() == ((found.fold[:50] + apart) % 5).tolist()


@pytest.mark.parametrize("rows", [100, 7])
def test_without_times_pointings_are_dealt_to_ten_folds(rows):
    """Evenly."""
    found = folds(problem(rows=rows, sessions=1, times=False), weighed(), ())

    assert found.scheme == "leave pointings out, ten folds"
    assert np.bincount(found.fold).tolist() == [max(1, rows // 10)] * min(10, rows)


@pytest.mark.parametrize(
    ("until", "beside", "scheme"),
    [
        (np.inf, (), "blocks of time"),
        (2e9, (), "pointings"),
        (2e9, (chosen(),), "blocks of time"),
    ],
)
def test_what_came_back_is_held_to_pointings(until, beside, scheme):
    """By itself: a block of time may hold all of it, and nothing beside it tells its size."""
    back = chosen("epoch_offset")
    effect = epoch_step(1e9, until=until)
    back = replace(back, candidate=replace(back.candidate, effect=effect))
    found = folds(problem(rows=100, sessions=2), weighed(), (back, *beside))

    assert found.scheme.startswith(f"leave {scheme} out")


def test_scans_of_an_array_are_left_out_whole():
    """In ten folds."""
    found = folds(problem(sessions=2, antennas=5, scans=True), weighed(), ())

    assert found.scheme == "leave whole scans out, ten folds"
    assert len(np.unique(found.fold)) == 10


def misfit(monkeypatch, off, *, known=True, factor=1.0):
    """Return the misfit of one prediction that is off by some sigmas, and of one that is not."""
    white = np.array([[1.0, off], [1.0, 0.0]])
    solution = SimpleNamespace(
        values=np.zeros(1),
        known=np.array([known]),
        covariance=np.zeros((1, 1)),
        normal=np.ones((1, 1)),
    )
    monkeypatch.setattr(holdout, "whitened", lambda *_: (white, []))
    monkeypatch.setattr(
        holdout, "_without_each", lambda *_: [(0, solution, np.array([0])), (1, solution, [1])]
    )
    case = problem_with(expanded=lambda _, of: of[:, :1])
    evidence = SimpleNamespace(common=SimpleNamespace(factor=factor))
    of = SimpleNamespace(covariance=None, evidence=evidence)
    return holdout.unseen_misfit(case, of, (), None)


@pytest.mark.parametrize(
    ("off", "counted"), [(3.0, 9.0), (4.9, 24.01), (6.0, 25.0), (50.0, 25.0), (3.6, 12.96)]
)
def test_a_prediction_counts_for_five_sigma_at_most(monkeypatch, off, counted):
    """A coefficient may rest on one scan alone."""
    assert misfit(monkeypatch, off) == pytest.approx(counted)


def test_what_cannot_be_predicted_counts_as_far_off(monkeypatch):
    """Both readings; shared noise divides."""
    assert misfit(monkeypatch, 1.0, known=False) == pytest.approx(50.0)
    assert misfit(monkeypatch, 3.0, factor=3.0) == pytest.approx(3.0)


@pytest.mark.parametrize(("share", "open_"), [(3e-5, False), (3e-4, True)])
def test_a_prediction_is_open_where_the_fit_leaves_its_columns_open(share, open_):
    """A ten-thousandth of their length."""
    solution = SimpleNamespace(
        known=np.array([True, False]), covariance=np.diag([1.0, 0.0]), normal=np.eye(2)
    )

    assert holdout._left_open(solution, np.array([[1.0, share]]))[0] == open_


def linear(rows=20):
    """Return a problem of one column, white noise of one, and data that follow it."""
    rng = np.random.default_rng(0)
    column = rng.normal(size=(rows, 1))
    case = problem(rows=rows, sessions=2)
    case.unseen = {}
    case.residual = 3.0 * column[:, 0] + 0.1 * rng.normal(size=rows)
    case.expanded = lambda _: column
    return case, column


def test_a_fold_is_predicted_by_a_fit_without_it(monkeypatch):
    """Its readings have no weight there."""
    case, column = linear()

    class White:
        """Noise of one."""

        departures, noises = (), ()

        def __init__(self, weights):
            self.weights = weights

        def whiten(self, data):
            """Return columns times the root of weights."""
            return data * np.sqrt(self.weights)[:, None]

        def products(self, data):
            """Return the products of weighted columns."""
            return data.T @ (data * self.weights[:, None])

    monkeypatch.setattr(holdout, "replace", lambda _, weights: White(weights))
    of = SimpleNamespace(covariance=White(np.ones(20)), weights=np.ones(20))
    partition = Folds("", np.arange(20) % 4)
    left = holdout.residuals(case, of, (), partition)
    others = np.arange(20) % 4 != 1
    slope = (column[others, 0] @ case.residual[others]) / (column[others, 0] @ column[others, 0])

    np.testing.assert_allclose(left[1::4], (case.residual - slope * column[:, 0])[1::4])


def test_the_solution_of_products_is_least_squares():
    """Values, what is left, and what is not determined."""
    rng = np.random.default_rng(0)
    columns, data = rng.normal(size=(30, 2)), rng.normal(size=30)
    both = np.concatenate([columns, data[:, None]], axis=1)
    found = Solution.of(both.T @ both)
    wanted, left, *_ = np.linalg.lstsq(columns, data, rcond=None)

    np.testing.assert_allclose(found.values, wanted)
    assert found.residual == pytest.approx(left[0])
    assert found.known.all()


def unseen(monkeypatch, first, second, fold):
    """Return predictions with and without something, for readings (m,) in folds."""
    answers = [np.asarray(first, float), np.asarray(second, float)]
    monkeypatch.setattr(holdout, "residuals", lambda *_: answers.pop(0))
    case = problem_with(
        session=np.zeros(len(first), int),
        series=np.ones(len(first), int),
    )
    return holdout.unseen(case, (None, None), (), (), Folds("", np.asarray(fold)))


@pytest.mark.parametrize(
    ("off", "counted"), [(9.5, True), (10.5, False), (5.5, True), (19.0, False)]
)
def test_a_reading_that_both_miss_by_ten_times_the_scatter_is_a_gross_error(
    monkeypatch, off, counted
):
    """The scatter of the other folds; one that either fit predicts counts."""
    fold = np.arange(100) // 50
    others = np.where(np.arange(100) % 2, 1.0, -1.0)
    first = others.copy()
    first[3] = off * 1.0135
    found = unseen(monkeypatch, first, first, fold)
    second = first.copy()
    second[3] = 0.5
    either = unseen(monkeypatch, first, second, fold)

    assert found.counted[3] == counted
    assert found.counted.sum() == 99 + counted
    assert either.counted.all()


def test_what_one_fit_cannot_predict_is_not_counted(monkeypatch):
    """NaN in either."""
    ones = np.ones(20)
    found = unseen(monkeypatch, np.where(np.arange(20) == 4, np.nan, ones), ones, np.arange(20) % 2)

    assert not found.counted[4]
    assert found.rms() == (1.0, 1.0)
    assert found.compared(np.ones(20, bool), ones).gross == 1


def settled(
    monkeypatch,
    rms,
    evidences,
    error=None,
    stretches=20,
    sigmas=(9.0, 9.0, 9.0),
    prior=(),
    partition=None,
):
    """Return what is to be dropped; rms by what is left of the choices, "" for the model alone."""
    names = ("refraction", "skew", "tilt")[: len(evidences)]
    some = (candidate(name) for name in names)
    drawn = [replace(one, effect=replace(one.effect, prior=prior)) for one in some]
    steps = tuple(step(trial(of=c, evidence=e)) for c, e in zip(drawn, evidences, strict=True))
    key = lambda some: " ".join(one.candidate.effect.id for one in some)  # noqa: E731

    def sigma(_rows, fewest):
        return error if stretches >= fewest else None

    def of(_setup, _weighed, before, after, _partition):
        told = rms[key(before)], rms[key(after)]
        return SimpleNamespace(rms=lambda: told, counted=None, fall_sigma=sigma)

    monkeypatch.setattr(settling, "unseen", of)
    monkeypatch.setattr(settling, "weigh_model", lambda *_, **__: None)
    partition = partition or SimpleNamespace(fewest=3)
    monkeypatch.setattr(settling, "folds", lambda *_: partition)
    monkeypatch.setattr(settling.joint, "fit", lambda *_: None)
    own, weighed = len(problem_with().base), SimpleNamespace(covariance=None)
    monkeypatch.setattr(settling.joint, "distance", lambda _fit, n: sigmas[n - own])
    found = settling._worst(
        Outcome(problem_with(), tuple(one.chosen for one in steps), steps, weighed, 0.001, ())
    )
    return found and found[0].candidate.effect.id


@pytest.mark.parametrize(
    ("without_first", "without_second", "alone", "dropped"),
    [
        (1.2, 1.3, 2.0, None),
        # Both do harm: the one with less evidence goes.
        (0.9, 0.8, 2.0, "skew"),
        (0.9, 1.3, 2.0, "refraction"),
        (1.0, 1.3, 2.0, "refraction"),
        # Each pays, all together do not: without which the others do best.
        (1.2, 1.1, 0.9, "skew"),
        (1.1, 1.2, 1.0, "refraction"),
    ],
)
def test_each_finding_and_all_together_must_pay(
    monkeypatch, without_first, without_second, alone, dropped
):
    """On data left out."""
    rms = {
        "refraction skew": 1.0,
        "skew": without_first,
        "refraction": without_second,
        "": alone,
    }

    assert settled(monkeypatch, rms, (30.0, 20.0)) == dropped


@pytest.mark.parametrize(
    ("sigmas", "dropped"),
    [((9.0, 2.1), None), ((9.0, 1.9), "skew"), ((1.9, 9.0), "refraction"), ((1.9, 1.8), "skew")],
)
def test_a_finding_without_a_size_is_dropped(monkeypatch, sigmas, dropped):
    """Within two sigma of zero as it would be reported, whatever predicts better with it."""
    rms = {"refraction skew": 1.0, "skew": 1.2, "refraction": 1.2, "": 2.0}

    assert settled(monkeypatch, rms, (30.0, 20.0), sigmas=sigmas) == dropped
    # Drawn toward zero by a prior they are near it whatever they are.
    assert settled(monkeypatch, rms, (30.0, 20.0), sigmas=sigmas, prior=(1.0,)) is None


@pytest.mark.parametrize(
    ("values", "covariance", "excess", "sigmas"),
    [
        ((3.0,), ((1.0,),), 1.0, 3.0),
        ((3.0,), ((1.0,),), 4.0, 1.5),
        ((3.0, 0.0), ((1.0, 0.0), (0.0, 1.0)), 1.0, 2.54),
        # Neither is known alone, their sum is.
        ((1.5, 1.5), ((100.0, -99.9), (-99.9, 100.0)), 1.0, 6.39),
        ((1.5,), ((0.0,),), 1.0, np.inf),
    ],
)
def test_how_far_coefficients_together_are_from_zero(values, covariance, excess, sigmas):
    """The deviation of a normal that is as unlikely; with as much more scatter as is left."""
    solution = SimpleNamespace(
        values=np.array(values), covariance=np.array(covariance), residual=excess * 10, rank=2
    )
    fit = joint.Joint((), solution, np.array([0, len(values)]), np.zeros(12))

    assert joint.distance(fit, 0) == pytest.approx(sigmas, rel=0.01)


@pytest.mark.parametrize(
    ("error", "sessions", "stretches", "dropped"),
    [
        (0.19, 10, 20, None),
        (0.21, 10, 20, "refraction"),
        (0.12, 10, 20, None),
        (0.35, 10, 8, "refraction"),
        (0.35, 10, 7, None),
        (0.35, 30, 7, None),
        (0.35, 1, 5, "refraction"),
        (0.35, 1, 2, None),
    ],
)
def test_a_finding_must_pay_by_more_than_its_error(
    monkeypatch, error, sessions, stretches, dropped
):
    """The rms falls by 0.2; where few sessions, or blocks, tell its error any fall will do."""
    rms = {"refraction": 1.0, "": 1.2}
    partition = folds(problem(sessions=sessions), weighed(), (chosen(),))

    found = settled(monkeypatch, rms, (30.0,), error, stretches, partition=partition)
    assert found == dropped


def test_without_findings_nothing_is_dropped(monkeypatch):
    """The end of a search that found nothing."""
    assert settled(monkeypatch, {"": 1.0}, ()) is None


@pytest.mark.parametrize(
    ("behind", "tried"), [(58.0, True), (62.0, False), (35.0, True), (100.0, False)]
)
def test_members_of_a_family_are_tried_beside_noise_of_their_own(monkeypatch, behind, tried):
    """Those that came within sixty."""
    asked = []
    first = trial("azimuth_harmonics", 100.0, of=candidate("azimuth_harmonics", choices=3))
    other = trial("azimuth_harmonics", 100.0 - behind, of=candidate("azimuth_harmonics", choices=3))
    monkeypatch.setattr(
        settling, "likeliest", lambda _s, _o, members: asked.append(members) or members[-1]
    )
    one = step(first, trials=[other])
    end = settling._of_families(Outcome(problem_with(), (one.chosen,), (one,), None, 0.001, ()))

    assert bool(asked) == tried
    assert (end.chosen[0].candidate is other.candidate) == tried


@pytest.mark.parametrize("sound", [True, False])
def test_a_member_without_the_size_that_physics_gives_is_not_tried(monkeypatch, sound):
    """Precession from another equinox draws nearly the same curve, of another size."""
    asked = []
    some = [trial("precession", 100.0 - n, of=candidate("precession", choices=4)) for n in (0, 1)]
    monkeypatch.setattr(settling, "likeliest", lambda *given: asked.append(given) or given[-1][0])
    monkeypatch.setattr(settling.classes, "fits_physics", lambda one: sound or one is some[0])
    one = step(some[0], trials=some[1:])
    settling._of_families(Outcome(problem_with(), (one.chosen,), (one,), None, 0.001, ()))

    assert bool(asked) == sound


@pytest.mark.parametrize(("share", "tried"), [(0.985, True), (0.995, False)])
def test_a_member_that_draws_the_same_curve_is_not_tried(monkeypatch, share, tried):
    """It leaves the same noise."""
    asked = []
    some = [trial("refraction", 100.0 - n, of=candidate("refraction", choices=6)) for n in (0, 1)]
    monkeypatch.setattr(settling, "likeliest", lambda *given: asked.append(given) or given[-1][0])
    one = replace(step(some[0], trials=some[1:]), beside=beside(refraction=share))
    settling._of_families(Outcome(problem_with(), (one.chosen,), (one,), None, 0.001, ()))

    assert bool(asked) == tried


@pytest.mark.parametrize(
    ("rival", "evidence", "own", "inside"),
    [
        ("temperature", 80.0, 95.0, True),
        ("temperature", 80.0, 91.0, False),
        ("temperature", 45.0, 95.0, True),
        ("temperature", 35.0, 95.0, False),
        ("sag_sine", 80.0, 95.0, False),
    ],
)
def test_a_rival_that_follows_a_condition_is_weighed_beside_its_own_noise(
    monkeypatch, rival, evidence, own, inside
):
    """Where it came within sixty; it is in the class if by its own noise it is within eight."""
    worth = {"driven_term": 100.0, rival: own}
    monkeypatch.setattr(
        settling,
        "lead",
        lambda _s, _o, *two: worth[two[0].candidate.effect.id] - worth[two[1].candidate.effect.id],
    )
    one = step(trial("driven_term", 100.0), trials=[trial(rival, evidence)])
    outcome = Outcome(problem_with(), (one.chosen,), (one,), None, 0.001, ())
    held = settling._with_driven_rivals(outcome, one)

    assert (rival in held.called.members) == inside


def test_three_members_at_most_are_tried(monkeypatch):
    """And the one that was chosen."""
    asked = []
    some = [
        trial("azimuth_harmonics", 100.0 - n, of=candidate("azimuth_harmonics", choices=9))
        for n in range(9)
    ]
    monkeypatch.setattr(
        settling, "likeliest", lambda _s, _o, members: asked.extend(members) or members[0]
    )
    one = step(some[0], trials=some[1:])
    settling._of_families(Outcome(problem_with(), (one.chosen,), (one,), None, 0.001, ()))

    assert len(asked) == 3


@pytest.mark.parametrize(
    ("scatter", "noisy"), [(9.5, False), (10.5, True), (5.5, False), (19.0, True)]
)
def test_an_antenna_ten_times_as_noisy_counts_in_no_rms(scatter, noisy):
    """As the median antenna."""
    names = np.array(["A", "B", "C", "D", "E"])
    case = problem_with(antenna=names)

    assert scene.noisy_antennas(case, np.array([1, 1, 1, 1, scatter])) == ["E"] * noisy


@pytest.mark.parametrize(("antennas", "judged"), [(3, True), (2, False), (1, False)])
def test_of_two_antennas_none_is_noisy(antennas, judged):
    """Neither is the odd one out."""
    case = problem_with(antenna=np.array(["A", "B", "C"][:antennas]))
    scatter = np.ones(antennas)
    scatter[0] = 1000.0

    assert bool(scene.noisy_antennas(case, scatter)) == judged


@pytest.mark.parametrize(
    ("other", "axes"),
    [(0.25, ("xel", "el")), (0.15, ("xel",)), (0.11, ("xel",)), (0.35, ("xel", "el"))],
)
def test_an_axis_belongs_to_a_finding_from_a_fifth(other, axes):
    """Of what the other axis shows."""
    case = problem_with(stack=SimpleNamespace(is_y=np.array([False, False, True, True])))

    assert scene.axes(case, np.array([1.0, -1.0, other, -other])) == axes


STRETCHES, LENGTH = 40, 25


def with_offsets(rng: np.random.Generator, stretches: int = STRETCHES) -> holdout.Unseen:
    """Return residuals before and after, each stretch with an offset of its own."""
    stretch = np.repeat(np.arange(stretches), LENGTH)
    noise = rng.normal(size=len(stretch)) + rng.normal(size=stretches)[stretch]
    cause = np.tile(np.sin(np.arange(LENGTH)), stretches)
    partition = Folds("", stretch)
    return holdout.Unseen(partition, stretch, noise + 2 * cause, noise, np.ones(len(stretch), bool))


def test_the_stated_error_of_a_fall_is_how_far_it_scatters():
    """Offsets of each stretch widen it."""
    rng = np.random.default_rng(5)
    rows = np.ones(STRETCHES * LENGTH, bool)
    drawn = [with_offsets(rng).compared(rows, np.zeros(len(rows))) for _ in range(400)]
    falls = np.array([one.before - one.after for one in drawn])
    stated = np.array([one.fall_sigma for one in drawn])
    assert np.median(stated) == pytest.approx(falls.std(), rel=0.12)


def test_too_few_stretches_state_no_error():
    """Two say nothing of how they scatter."""
    few = holdout.FEWEST_STRETCHES - 1
    rows = np.ones(few * LENGTH, bool)
    assert with_offsets(np.random.default_rng(1), few).compared(rows, 0.0 * rows).fall_sigma is None
