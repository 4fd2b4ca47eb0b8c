"""Places: what is too little to hold a step, an edge, a stretch, a bump or a slope."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import problem_with
from diagnosis.made import recordings

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis import candidates, disagreements
from pyport.diagnosis.arrays import findings, lasting, places, repeat
from pyport.diagnosis.naming import words
from pyport.diagnosis.naming.finding import Evidence, Finding, Where
from pyport.diagnosis.searching import refining
from pyport.diagnosis.shapes import boxes, edges, fields
from pyport.diagnosis.shapes.forms import Field
from pyport.diagnosis.trial import at_best
from pyport.diagnosis.weighing import View
from pyport.effects import CATALOGUE
from pyport.fitting.two_axes import Difference
from pyport.recordings.schema import stack


def viewed(left, basis=None):
    """Return readings of one sigma as they stand beside a model."""
    n = len(left)
    basis = np.zeros((n, 0)) if basis is None else basis
    return View(np.arange(n), np.ones(n), basis, np.asarray(left, float))


def elevations(n):
    """Return n recordings, and the problem that has their elevations alone."""
    given = recordings(n, 0)
    data = stack(given)
    only = np.flatnonzero(data.is_y)
    both = SimpleNamespace(
        row=data.row[only], is_y=data.is_y[only], columns=lambda e, at: e.columns(at)[1]
    )
    return given, problem_with(recordings=given, stack=both)


@pytest.mark.parametrize(("after", "placed"), [(8, True), (7, False), (4, False), (15, True)])
def test_a_step_has_eight_readings_on_either_side(after, placed):
    """Where fewer follow, it is somewhere else."""
    given, problem = elevations(60)
    time = given.at.column("time")[problem.stack.row]
    order = np.argsort(time, kind="stable")
    left = np.zeros(60)
    left[order[-after:]] = 5.0
    problem.session = np.zeros(60, int)
    found = refining._steps(problem, viewed(left), CATALOGUE["epoch_offset"])
    moments = [one.parameter for one, _ in found]
    middle = (time[order[-after - 1]] + time[order[-after]]) / 2

    assert any(abs(one - middle) < 1e-3 for one in moments) == placed


@pytest.mark.parametrize(("inside", "box"), [(8, True), (7, False), (4, False), (15, True)])
def test_a_box_has_eight_readings(inside, box):
    """In a cell of the sky with fewer there is no offset."""
    az = np.concatenate([np.full(inside, 0.1), np.linspace(1, 6, 80)])
    el = np.concatenate([np.full(inside, 0.3), np.full(80, 0.9)])
    there = az < 0.2
    edges_, tried = boxes._scanned(az, el, np.ones(len(az)), 10.0 * there)
    gain = boxes._gain_of(az, el, np.ones(len(az)), 10.0 * there)

    assert tried > 100
    assert (gain((0.0, 0.2, 0.2, 0.4)) > 0) == box
    assert (gain(edges_) > 105 * inside) == box


@pytest.mark.parametrize(("above", "there"), [(8, True), (7, False), (4, False), (15, True)])
def test_an_edge_has_eight_readings_on_either_side(above, there):
    """A curve above which fewer stand decides nothing."""
    n = 60
    az = np.linspace(0, 6, n)
    el = np.where(np.arange(n) < above, 1.4, 0.5)
    left = np.where(np.arange(n) < above, 5.0, 0.0)
    found = edges._free(viewed(left - left.mean()), az, el, np.ones(n), edges.LEVELS)

    assert (found is not None) == there


def test_an_edge_needs_thirty_two_elevations():
    """Four times as many as a side."""
    az, el = np.linspace(0, 6, 40), np.linspace(0.2, 1.4, 40)
    left = np.where(el > 0.8, 3.0, -3.0)

    assert edges._free(viewed(left), az, el, np.ones(40), edges.LEVELS) is not None
    few = slice(0, 40, 2)
    assert edges._free(viewed(left[few]), az[few], el[few], np.ones(20), edges.LEVELS) is None


@pytest.mark.parametrize(("beyond", "placed"), [(8, True), (7, False), (4, False), (15, True)])
def test_a_cut_has_eight_readings_on_either_side(beyond, placed):
    """Where fewer stand beyond, it is somewhere else."""
    az = np.random.default_rng(1).permutation(np.linspace(-1.5, 1.5, 60))
    order = np.argsort(az)
    left = np.zeros(60)
    left[order[-beyond:]] = 5.0
    (found,) = edges._cut(viewed(left - left.mean(), np.full((60, 1), 60**-0.5)), az, np.ones(60))
    middle = az[order[-beyond - 1 : 60 - beyond + 1]].mean()

    assert (abs(found - middle) < 1e-9) == placed
    assert edges._cut(viewed(left[:15]), az[:15], np.ones(15)) == []


def bumps(monkeypatch, felt):
    """Return how many bumps a field has of which the last is felt by some readings."""
    n = 60
    columns = np.zeros((n, 2))
    columns[:, 0] = 1.0
    columns[:felt, 1] = 0.5
    is_y = np.ones(n, bool)
    one = Field("a field", "somewhere", columns, is_y)
    seen = []
    monkeypatch.setattr(fields, "families", lambda _: [(1, one)])

    def worth(field, *_):
        seen.append(field.columns.shape[1])
        return SimpleNamespace(evidence=0.0)

    monkeypatch.setattr(fields, "worth", worth)
    ground = SimpleNamespace(
        problem=problem_with(stack=SimpleNamespace(is_y=is_y)),
        axes=[],
        _whitened=lambda wanted: ((*one, one[1].values) for one in wanted),
        _products=lambda *_: (np.eye(4), np.eye(4), np.zeros(4)),
    )
    list(fields.Ground.worths(ground))
    return seen


@pytest.mark.parametrize(("felt", "kept"), [(8, 2), (7, 1), (4, 1), (15, 2)])
def test_a_bump_is_felt_by_eight_readings(monkeypatch, felt, kept):
    """Its height would be that of fewer."""
    assert bumps(monkeypatch, felt) == [kept]


@pytest.mark.parametrize(("share", "kept"), [(0.2, 2), (0.11, 2), (0.09, 1), (0.01, 1)])
def test_a_direction_nearly_degenerate_with_the_model_is_left_out(share, kept):
    """Of which less than a tenth is left beside it, however well the data determine that."""
    one = Field("a field", "somewhere", np.ones((60, 2)), np.ones(60, bool))
    alone = np.diag([1e6, 1e6])
    information = alone * np.diag([0.25, share**2])

    found = fields.worth(one, information, alone, np.array([5e3, 5e3]))

    assert found.directions.shape[1] == kept


@pytest.mark.filterwarnings("error")
def test_directions_of_which_rounding_leaves_less_than_nothing_are_left_out():
    """Bumps that are hardly felt, beside a model that draws them: eigenvalues below zero."""
    one = Field("a field", "somewhere", np.ones((60, 2)), np.ones(60, bool))
    nothing = np.diag([1e6, -1e-30])

    found = fields.worth(one, nothing, nothing, np.array([5e3, 1e-16]))

    assert found.directions.shape[1] == 1


@pytest.mark.parametrize(("known", "kept"), [(0.5, 2), (0.35, 2), (0.25, 1), (0.1, 1)])
def test_a_direction_that_the_data_hardly_tell_of_is_left_out(known, kept):
    """Of which they know less than three tenths of what its prior does."""
    one = Field("a field", "somewhere", np.ones((60, 2)), np.ones(60, bool))
    _, variance = at_best(np.array([1e4]), np.array([2e3]))
    information = np.diag([1e4, known / variance])

    found = fields.worth(one, information, information, np.array([2e3, 0.0]))

    assert found.directions.shape[1] == kept
    assert found.gain == pytest.approx(398, abs=0.9)  # of 400 in the fit


@pytest.mark.parametrize(("worth_each", "names"), [(0.5, 2), (9.0, 3)])
def test_both_axes_are_tried_where_either_is_worth_something(monkeypatch, worth_each, names):
    """With a width for each of them they are worth no less than with one for both."""
    is_y = np.arange(60) % 2 == 0
    one = Field("a field", "somewhere", np.ones((60, 1)), is_y)
    monkeypatch.setattr(fields, "families", lambda _: [(1, one)])
    price = 2 * np.log(3)
    monkeypatch.setattr(
        fields, "worth", lambda *_: SimpleNamespace(evidence=worth_each / 2 - price)
    )
    ground = SimpleNamespace(
        problem=problem_with(stack=SimpleNamespace(is_y=is_y)),
        axes=[],
        _whitened=lambda wanted: ((*each, each[1].values) for each in wanted),
        _products=lambda *_: (np.eye(2), np.eye(2), np.zeros(2)),
    )

    assert len(list(fields.Ground.worths(ground))) == names


@pytest.mark.parametrize(
    ("wide", "placed"), [(30, True), (34, True), (37, False), (45, False), (1, False), (3, True)]
)
def test_a_field_has_a_place_where_it_stands_out(wide, placed):
    """In two to thirty-five hundredths of the readings."""
    values = np.arange(100.0)
    curve = np.where(np.abs(values - 50) < wide / 2, 3.0, 0.1)
    # A shoulder of a third of the peak is none of the place.
    curve[5:15] = curve[86:96] = 1.0
    curve[np.abs(values - 50) < wide / 2 + 2] = np.maximum(
        curve[np.abs(values - 50) < wide / 2 + 2], 1.0
    )
    there = Field("", "", np.ones((100, 1)), np.ones(100, bool), along=("x", values))
    found = fields.region(there, curve)

    assert bool(found) == placed
    if placed:
        assert abs(found[0].low - (50 - wide / 2)) <= 1
        assert abs(found[0].high - (50 + wide / 2)) <= 1


def test_evidence_is_that_of_coefficients_from_one_normal():
    """Of one direction known from power p: gain less one less log gain at the best width."""
    for gain in (2.0, 5.0, 30.0, 500.0):
        found, variance = at_best(np.array([4.0]), np.array([2 * np.sqrt(gain)]))

        assert found == pytest.approx(gain - 1 - np.log(gain), abs=0.15)
        assert variance == pytest.approx((gain - 1) / 4, rel=0.5)
    assert at_best(np.array([4.0]), np.array([0.0]))[0] < 0


def test_evidence_adds_over_directions_of_one_width():
    """Two alike have twice that of one; an idle one costs its share."""
    one, _ = at_best(np.array([1.0]), np.array([6.0]))
    two, _ = at_best(np.array([1.0, 1.0]), np.array([6.0, 6.0]))
    idle, _ = at_best(np.array([1.0, 1.0]), np.array([6.0, 0.0]))

    assert two == pytest.approx(2 * one)
    assert one - 5 < idle < one - 2


ANTENNAS = tuple("ABCDEFGH")


def parts(values, sigma, sessions=1):
    """Return coefficients of some antennas, taken apart."""
    antenna = np.repeat(ANTENNAS[: len(values)], sessions)
    session = np.tile([f"s{n}" for n in range(sessions)], len(values))
    value = np.repeat(values, sessions) + 0.0
    return findings.split(antenna, session, value, np.full(len(value), sigma))


@pytest.mark.parametrize(
    ("common", "there"), [(3.3, True), (2.7, False), (1.7, False), (5.5, True)]
)
def test_a_common_part_is_there_from_three_sigma(common, there):
    """Of four antennas of one sigma its error is a half."""
    assert parts(np.full(4, common / 2), 1.0).has_common == there


def test_parts_of_antennas_are_about_what_they_share():
    """Own parts of zero mean; a shared one with its error; changes from session to session."""
    found = parts(np.array([1.0, 2.0, 3.0, 6.0]), 0.1)

    np.testing.assert_allclose(found.own, [-2, -1, 0, 3], atol=1e-6)
    assert found.common[0] == pytest.approx(3.0, abs=1e-6)
    assert found.spread == pytest.approx(np.std([1, 2, 3, 6], ddof=1), rel=0.01)
    moved = findings.split(
        np.repeat(ANTENNAS[:4], 2), np.tile(["a", "b"], 4), np.tile([0.0, 1.0], 4), np.full(8, 0.1)
    )
    assert moved.changes
    # Each weighs by its error and the scatter of antennas together, and own parts have no mean.
    uneven = findings.split(
        np.array(["A", "B", "A", "B"]),
        np.array(["a", "a", "b", "b"]),
        np.array([0.0, 10.0, 0.0, 4.0]),
        np.array([0.5, 1.0, 1.0, 1.0]),
    )
    assert uneven.own.mean() == pytest.approx(0.0, abs=1e-9)
    assert uneven.common[0] - uneven.common[1] == pytest.approx(3.0, abs=0.5)
    assert not parts(np.array([1.0, 2, 3, 6]), 0.1, sessions=2).changes


@pytest.mark.parametrize(("sigma", "used"), [(2.9, True), (3.1, False), (1.7, True), (5.8, False)])
def test_an_antenna_known_three_times_worse_is_no_reference(sigma, used):
    """Than the median one."""
    covariance = np.diag(np.array([1.0, 1, 1, 1, 1, 1, 1, sigma]) ** 2)
    # About the mean of eight, the errors of the others hardly change.
    well = lasting.well_known(np.diag(np.array([1.0] * 60 + [sigma]) ** 2))
    known = SimpleNamespace(
        antennas=ANTENNAS, own=np.zeros((8, 1)), own_covariance=lambda _: covariance
    )
    found = places.places(known, 0, SimpleNamespace(latitude=0.6, height_m=0.0))

    assert bool(well[-1]) == used
    assert found.usable[-1] == used


def surveyed(antennas):
    """Return a comparison of displacements with a survey of some antennas."""
    east = np.arange(8.0) * 100
    found = places.Places(ANTENNAS, east, np.eye(8), np.ones(8, bool), 6.4e6)
    survey = SimpleNamespace(names=ANTENNAS[:antennas], east_m=east[:antennas], file="survey")
    return places.compare(found, survey)


@pytest.mark.parametrize(("antennas", "there"), [(4, True), (3, False), (2, False), (7, True)])
def test_a_survey_needs_four_antennas(antennas, there):
    """A slope from three fits anything."""
    assert (surveyed(antennas) is not None) == there


@pytest.mark.parametrize(
    ("slope", "sigma", "site"),
    [
        (1.0, 0.3, True),
        (1.0, 0.36, False),
        (1.0, 0.6, False),
        (1.0, 0.18, True),
        (1.28, 0.1, True),
        (1.32, 0.1, False),
        (1.16, 0.1, True),
        (1.58, 0.1, False),
    ],
)
def test_leans_grow_with_distance_as_displacements_do(slope, sigma, site):
    """A slope that is there from three sigma, and no further from one."""
    known = surveyed(8)
    found = places.Comparison(
        **{**vars(known), "slope": slope, "slope_sigma": sigma, "delta_bic": 5.0}
    )

    assert found.is_the_site == site


@pytest.mark.parametrize(("antennas", "there"), [(4, True), (3, False), (2, False), (7, True)])
def test_sessions_are_compared_in_four_antennas(monkeypatch, antennas, there):
    """As many as a comparison with a survey needs."""
    blocks = [
        SimpleNamespace(session=session, antenna=name)
        for session in "ab"
        for name in ANTENNAS[:antennas]
    ]
    monkeypatch.setattr(repeat, "lasting", lambda *_: None)
    monkeypatch.setattr(repeat, "_compared", lambda *_: "compared")

    assert bool(repeat.repeats(blocks, (), 0)) == there


def apart(sigmas):
    """Return a difference of so many sigmas."""
    from scipy.special import ndtr

    one = np.ones(1)
    return Difference(np.zeros(1, int), one, one, one, one, 1.0, float(2 * ndtr(-sigmas)))


@pytest.mark.parametrize(
    ("sigmas", "placed"), [(3.2, True), (2.8, False), (1.7, False), (5.5, True)]
)
def test_halves_three_sigma_apart_place_a_disagreement(sigmas, placed):
    """In an axis and a half."""
    half = disagreements.Half("below", apart(1.0))
    split = disagreements.Halves((half, half), apart(sigmas), apart(0.5))
    said = words._place((split,), "tilt", ("x", "y"))

    assert said.startswith("It lies in x") == placed


@pytest.mark.parametrize(("sigmas", "same"), [(1.8, True), (2.2, False), (1.2, True), (3.5, False)])
def test_halves_two_sigma_apart_agree(sigmas, same):
    """Then the other axis has one tilt in both."""
    half = disagreements.Half("below", apart(1.0))
    split = disagreements.Halves((half, half), apart(8.0), apart(sigmas))
    said = words._place((split,), "tilt", ("x", "y"))

    assert ("y has one in both" in said) == same


def causes(gain, left, count=1):
    """Return the causes that would settle a disagreement, each of one column."""
    some = [SimpleNamespace(effect=SimpleNamespace(id=f"c{n}")) for n in range(count)]
    data = np.zeros(20)
    data[1 : 1 + count] = np.sqrt(gain) + 0.01 * np.arange(count)
    column = lambda n: np.eye(20)[:, n : n + 1]  # noqa: E731
    problem = problem_with(
        candidates=some,
        expanded=lambda choices, **_: column(
            1 + some.index(choices[0].candidate) if choices[0].candidate in some else 15
        ),
    )
    difference = apart(2.0)
    ground = SimpleNamespace(
        others=lambda _: column(19),
        weighed=SimpleNamespace(white=None),
        problem=problem,
        data=data,
        compare=lambda *_: Difference(**{**vars(difference), "chi2": left}),
    )
    one = SimpleNamespace(candidate="the effect")
    found = Difference(**{**vars(difference), "chi2": 100.0})
    return [name for name, _ in disagreements._Ground._causes(ground, one, found)]


@pytest.mark.parametrize(
    ("gain", "left", "told"),
    [
        (9.5, 10.0, True),
        (8.5, 10.0, False),
        (2.5, 10.0, False),
        (30.0, 10.0, True),
        (30.0, 48.0, True),
        (30.0, 52.0, False),
        (30.0, 27.0, True),
        (30.0, 90.0, False),
    ],
)
def test_a_cause_takes_most_of_a_disagreement_away(gain, left, told):
    """Worth three sigma for each coefficient, with at most half of the square left."""
    assert bool(causes(gain, left)) == told


def test_three_causes_are_listed():
    """Those that gain most."""
    assert causes(20.0, 1.0, count=5) == ["c4", "c3", "c2"]


@pytest.mark.parametrize(
    ("visible", "said"), [(96.0, False), (94.0, True), (50.0, True), (100.0, False)]
)
def test_what_the_fitted_terms_absorb_is_said_from_a_twentieth(visible, said):
    """Less is not worth a word."""
    found = Finding(
        *("refraction", ("refraction",), "named", "", Where(("el",)), ()),
        *(Evidence(1e-9, 50.0, None, None), visible * ARCSEC, 100 * ARCSEC),
    )

    assert ("absorb" in found.size) == said


def test_a_path_over_columns_climbs_where_that_pays():
    """Each degree from one column to the next costs what is said."""
    cost = np.full((3, 92), 10.0)
    cost[0, 20] = cost[1, 24] = cost[2, 20] = 0.0

    assert edges._path(cost).tolist() == [20, 24, 20]
    cost[1, 24] = 6.0
    assert edges._path(cost).tolist() == [20, 20, 20]


def test_levels_and_columns_of_the_sky():
    """One degree up, ten around."""
    sky = edges.sky_of(
        np.array([0.5, 15.0, 25.0]) * DEG,
        np.array([10.5, 20.5, 91.0]) * DEG,
        np.ones(3, bool),
        edges.COLUMN,
        edges.LEVELS,
    )

    assert sky.columns == 3
    assert sky.above(np.array([10, 20, 90])).tolist() == [True, True, True]
    assert sky.above(np.array([11, 21, 91])).tolist() == [False, False, False]


@pytest.mark.parametrize(
    ("share", "tested"), [(1.2e-3, True), (0.8e-3, False), (0.1, True), (0.0, True)]
)
def test_what_the_fitted_terms_draw_nearly_all_of_is_not_tested(share, tested, monkeypatch):
    """A thousandth of its length must be a candidate's own, but what is theirs may change."""
    given = recordings(200, 0)
    own = np.where(np.arange(200) % 2, 1.0, -1.0) * share / np.sqrt(1 - share**2)
    zero = replace(
        CATALOGUE["elevation_zero"], basis=lambda _: (np.zeros((200, 1)), np.ones((200, 1)))
    )
    nearly = replace(zero, basis=lambda _: (np.zeros((200, 1)), 1 + own[:, None]))
    monkeypatch.setattr(candidates, "catalogue", lambda _: {"nearly": nearly})
    data = stack(given)
    beside = data.columns(zero, given.at)
    _, found, untestable = candidates.design(given, data, beside)

    assert bool(found) == tested
    assert bool(untestable) != tested


@pytest.mark.parametrize(("shown", "said"), [(1.0, []), (0.0, ["family"])])
def test_a_family_is_not_testable_where_none_of_it_shows(monkeypatch, shown, said):
    """It is listed once, however many members it has."""
    one = CATALOGUE["elevation_zero"]
    still, moved = (
        replace(
            one,
            id="family",
            basis=lambda at, k=k: (np.zeros((len(at), 1)), np.full((len(at), 1), k)),
        )
        for k in (0.0, shown)
    )
    family = replace(one, id="family", profile=lambda _: (still, still, moved))
    monkeypatch.setattr(candidates, "catalogue", lambda _: {"family": family})
    given = recordings(50, 0)
    _, found, untestable = candidates.design(given, stack(given))

    assert [each.effect for each in untestable] == said
    assert len(found) == (not said)
