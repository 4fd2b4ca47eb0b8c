"""Own, shared and passing parts: told apart, with honest errors, whatever one day does."""

import numpy as np
import pytest
from diagnosis.arrays.made_array import RATE, array, case
from hypothesis import given, settings
from hypothesis import strategies as st

from pyport.angles import ARCMIN
from pyport.diagnosis.arrays.blocks import Block
from pyport.diagnosis.arrays.lasting import expected_without, lasting
from pyport.diagnosis.arrays.report import report

EAST_M = 3000.0 * np.linspace(-1, 1, 8)


def made_blocks(seed, antennas=15, sessions=4, scatter=0.5, error=0.2):
    """Return blocks of two shapes, the second one shared, and the truth."""
    rng = np.random.default_rng(seed)
    own = rng.normal(0, 2, (antennas, 2)) * ARCMIN
    common = np.zeros((sessions, 2))
    common[:, 1] = rng.normal(0, 5, sessions) * ARCMIN
    blocks = []
    for a in range(antennas):
        for s in range(sessions):
            truth = own[a] + common[s] + scatter * ARCMIN * rng.normal(size=2)
            turn = rng.normal(size=(4, 2))
            information = turn.T @ turn / (error * ARCMIN) ** 2
            noise = np.linalg.cholesky(information) @ rng.normal(size=2)
            score = information @ truth + noise
            blocks.append(
                Block(f"A{a:02d}", f"s{s}", *([np.zeros(0)] * 5), 1.0, information, score)
            )
    return blocks, own, common


def test_parts_come_back_with_honest_errors():
    """Own and common parts are off by their sigmas, the scatter of what passes is found."""
    pulls, scatters = [], []
    for seed in range(8):
        blocks, own, _ = made_blocks(seed)
        found = lasting(blocks, [1])
        own[:, 1] -= own[:, 1].mean()
        for shape in (0, 1):
            sigma = np.sqrt(np.diag(found.own_covariance(shape)))
            pulls.append((found.own[:, shape] - own[:, shape]) / sigma)
        scatters.append(found.scatter / ARCMIN)

    assert 0.8 < np.sqrt(np.mean(np.square(pulls))) < 1.2
    # a Student distribution of the same middle has a smaller scale than a normal one
    assert np.mean(scatters) == pytest.approx(0.45, rel=0.2)


def test_changes_of_the_common_part_are_known_better_than_its_level():
    """Sessions share their antennas, so differences do not carry the scatter of own parts."""
    pulls = []
    for seed in range(8):
        blocks, _, common = made_blocks(seed)
        found = lasting(blocks, [1])
        covariance = found.common_covariance(1)
        change = np.diff(found.common[:, 1] - common[:, 1])
        each = np.diff(np.eye(len(covariance)), axis=0)
        pulls.append(change / np.sqrt(np.diag(each @ covariance @ each.T)))

    assert 0.7 < np.sqrt(np.mean(np.square(pulls))) < 1.4


def test_one_touched_mount_does_not_spoil_the_rest():
    """A day on which one antenna was moved by 20 arcmin leaves the scatter nearly as it was."""
    blocks, own, _ = made_blocks(0)
    before = lasting(blocks, [1])
    touched = blocks[9]
    touched.score[:] += touched.information @ np.full(2, 20 * ARCMIN)
    after = lasting(blocks, [1])

    assert np.all(after.scatter < 1.5 * before.scatter)
    others = np.arange(len(own)) != 9 // 4
    np.testing.assert_allclose(after.own[others], before.own[others], atol=0.3 * ARCMIN)


def test_nothing_passes_in_one_session():
    """What is seen once is taken to last."""
    blocks, *_ = made_blocks(0, sessions=1)
    found = lasting(blocks, [1])

    assert np.all(found.scatter == 0)
    expected = found.of("A03", "s0")
    np.testing.assert_allclose(expected, blocks[3].alone(), rtol=1e-4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 59), st.floats(-300, 300))
def test_what_is_held_out_has_no_say(seed, held, by):
    """Whatever a block says, the others expect the same of it, but for the scatter they share."""
    blocks, *_ = made_blocks(seed)
    whole = lasting(blocks, [1])
    before = expected_without(blocks, whole, held)
    blocks[held].score[:] += blocks[held].information @ np.full(2, by * ARCMIN)
    after = expected_without(blocks, whole, held)

    np.testing.assert_allclose(after, before, atol=1e-12)


def test_what_others_expect_is_what_a_fit_of_the_others_says():
    """Leaving one block out by hand gives the same expectation."""
    blocks, *_ = made_blocks(5)
    whole = lasting(blocks, [1])
    for held in (0, 17, 42):
        others = [one for n, one in enumerate(blocks) if n != held]
        one = blocks[held]
        by_hand = lasting(others, [1]).of(one.antenna, one.session)

        np.testing.assert_allclose(
            expected_without(blocks, whole, held), by_hand, atol=0.05 * ARCMIN
        )


def test_time_tags_and_play_are_told_apart():
    """Tags come back in seconds, play in arcmin, and play predicts the day that was held out."""
    tags = (6.0, 1.0, -5.0)
    made, play, _ = array(EAST_M, tags=tags, noise=0.3, seed=4)
    found = report(*case(made))
    scan = [one.name for one in found.shapes].index("scan_direction_el")

    told = np.array([one.tag for one in found.sessions])
    np.testing.assert_allclose(np.diff(told[:, 0]), np.diff(tags), atol=1.2)
    np.testing.assert_allclose(
        found.parts.own[:, scan] / ARCMIN, play - play.mean(), atol=4 * 0.3 / np.sqrt(72)
    )
    assert found.rate == pytest.approx(RATE)
    for day in found.repeats["scan_direction_el"]:
        assert day.correlation > 0.9
        assert day.left < 2 * day.noise
        assert day.p_value > 1e-3
