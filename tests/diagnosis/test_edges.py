"""Edges of any form: the best one, all that are as likely, and the jump averaged over them."""

import dataclasses

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.shapes.edge_paths import CLIMB, _good, _log_likely, _path
from pyport.diagnosis.shapes.edges import LEVELS, sky_of
from pyport.diagnosis.shapes.edges import _path as cheapest
from pyport.effects.telescope.structure import FreeEdge
from pyport.formats.models import load
from pyport.mounts import KINDS

DEG = np.pi / 180


def jagged(az):
    """Return an edge that no two waves draw [rad]."""
    corners = np.array([0, 60, 100, 140, 200, 260, 300, 360])
    return np.interp(np.degrees(az) % 360, corners, [40, 62, 44, 66, 48, 66, 46, 40]) * DEG


def loose(at):
    """Return a jump of 20 arcsec above that edge."""
    return np.where(at.el >= jagged(at.az), -20.0, 0.0)


def test_the_cheapest_path_follows_the_edge_and_pays_for_climbing():
    """Viterbi's path is the best of all paths, as trying each of them shows."""
    rng = np.random.default_rng(3)
    cost = rng.normal(size=(4, 5))
    paths = np.stack(np.meshgrid(*[np.arange(5)] * 4, indexing="ij"), -1).reshape(-1, 4)
    totals = cost[np.arange(4), paths].sum(axis=1) + 0.7 * np.abs(np.diff(paths)).sum(axis=1)

    np.testing.assert_array_equal(cheapest(cost), paths[np.argmin(totals)])


def test_sums_above_each_level():
    """Each cell holds what lies above its level in its column."""
    az, el = np.array([2, 3, 12, 13]) * DEG, np.array([0.5, 1.5, 1.5, 2.5]) * DEG
    sky = sky_of(az, el, np.ones(4, bool), 10 * DEG, LEVELS)
    sums = sky.above_each(np.array([1.0, 10.0, 100.0, 1000.0]))

    np.testing.assert_array_equal(sums[:, :3], [[11, 10, 0], [1100, 1100, 1000]])
    np.testing.assert_array_equal(sky.above(np.array([1, 2])), [False, True, False, True])


def test_a_free_edge_is_straight_between_its_corners():
    """Beyond its ends it goes on level."""
    edge = FreeEdge((0.0, 1.0), (0.2, 0.4))

    np.testing.assert_allclose(edge(np.array([-1.0, 0.5, 2.0])), [0.2, 0.3, 0.4])
    assert edge.span == (0.0, 1.0)


def test_a_path_becomes_a_curve_and_a_path_again():
    """A curve's levels in the middles of the columns are those it was made of."""
    rng = np.random.default_rng(2)
    sky = sky_of(rng.uniform(-1, 5, 300), rng.uniform(0, 1.5, 300), np.ones(300, bool), 0.1, LEVELS)
    path = rng.integers(0, 90, sky.columns)

    np.testing.assert_array_equal(sky.path_of(sky.edge_of(path)), path)


@pytest.mark.slow
def test_paths_are_drawn_as_often_as_they_are_likely():
    """Shares of many draws are those that trying every path gives."""
    rng = np.random.default_rng(3)
    likelier = rng.normal(scale=1.5, size=(3, 4))
    paths = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3)
    step = np.exp(-CLIMB * np.abs(np.arange(4)[:, None] - np.arange(4)))
    step /= step.sum(axis=1, keepdims=True)
    chance = np.exp(likelier[np.arange(3), paths].sum(axis=1))
    chance *= step[paths[:, 0], paths[:, 1]] * step[paths[:, 1], paths[:, 2]]
    chance /= chance.sum()
    drawn = np.array([_path(likelier, rng) for _ in range(20_000)]) @ [16, 4, 1]

    shares = np.bincount(drawn, minlength=64) / len(drawn)
    assert np.abs(shares - chance).max() < 5 * np.sqrt(0.25 / len(drawn))


def test_a_pointing_far_from_both_sides_is_thought_bad():
    """One ten sigmas off is bad, one within a sigma is as good as never; neither decides."""
    rng = np.random.default_rng(4)

    assert _good(np.zeros(1000), rng).mean() > 0.98
    assert not _good(np.full(1000, 10.0), rng).any()
    assert _log_likely(np.array([30.0])) - _log_likely(np.array([26.0])) > -2


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 12])
def test_a_jump_above_a_jagged_edge_comes_out_with_its_size(seed):
    """The error holds what is not known of the edge; the edge is near the true one."""
    found = diagnose(recordings(1600, seed, y=loose), load("altaz"))
    first = found.findings[0]
    jump = first.parameters[0]
    az, el = np.array(first.where.curve).T * DEG

    assert first.effect == "subreflector_jump"
    assert abs(jump.value + 20) < 3 * jump.sigma
    assert np.median(np.abs(el - jagged(az))) < 2 * DEG


def stepped(kind, n, seed, x=None, y=None):
    """Return recordings of another mount that steps by `x` or `y` [arcsec], with noise of 3."""
    made = recordings(n, seed)
    at = dataclasses.replace(made.at, mount=KINDS[kind])
    rng = np.random.default_rng(seed)
    offsets = [3 * rng.normal(size=n) + (0 if add is None else add(at.axes)) for add in (x, y)]
    return dataclasses.replace(made, at=at, x=offsets[0] * ARCSEC, y=offsets[1] * ARCSEC)


@pytest.mark.parametrize(
    ("kind", "axis", "at_deg", "variant"),
    [
        ("xy-ns", "y", 20, "in Y, beyond X 20"),
        ("fork", "x", -30, "in hour angle, beyond hour angle -30"),
    ],
)
def test_an_edge_in_the_angle_of_an_axis_is_found_where_it_is(kind, axis, at_deg, variant):
    """One of the first axis was a wave, a scale or an eccentricity of it, or had no name."""

    def step(at):
        return 8 * (at.az >= at_deg * DEG) * (np.cos(at.el) if axis == "x" else 1.0)

    found = diagnose(stepped(kind, 500, 5, **{axis: step}), load("altaz").on(KINDS[kind]))
    first = found.findings[0]

    assert (first.effect, first.verdict) == ("subreflector_jump", "named")
    place = float(first.variant.removesuffix(" deg").rpartition(" ")[2])
    assert first.variant.startswith(variant.rpartition(" ")[0])
    assert abs(place - at_deg) < 1
    assert abs(first.parameters[0].value - 8) < 3 * first.parameters[0].sigma


def test_a_step_of_y_at_the_zenith_is_play_or_a_jump():
    """What follows the sky turns back in Y where X crosses zero: both are one curve."""
    found = diagnose(
        stepped("xy-ns", 300, 7, y=lambda at: 8 * (at.az >= 0)), load("altaz").on(KINDS["xy-ns"])
    )
    first = found.findings[0]

    assert first.verdict == "ambiguous"
    assert set(first.members) == {"backlash_y", "subreflector_jump"}


def test_a_ramp_of_an_axis_is_not_two_steps():
    """Two steps of Y one behind the other draw it: a bend does so better."""
    ramp = stepped("xy-ns", 700, 13, y=lambda at: 12 * np.maximum(at.el - 20 * DEG, 0))
    found = diagnose(ramp, load("altaz").on(KINDS["xy-ns"]))

    assert found.findings
    assert all(one.verdict != "named" for one in found.findings)
