"""Realignment: rows garbled on purpose find their antennas again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pyport.recordings.gmrt.align import alignment
from pyport.recordings.gmrt.cells import VOUCHED, numbers
from pyport.recordings.gmrt.recover import Numbers, recover
from pyport.recordings.gmrt.sessions import ANTENNAS, SESSIONS

#: A cell that was put in, or two run together: no antenna's.
NOBODY = -1


def drop(cells, owners, k, rng, pool):  # noqa: ARG001 - all garblers are called alike
    """Lose a cell."""
    del cells[k], owners[k]


def double(cells, owners, k, rng, pool):  # noqa: ARG001
    """Print a cell twice."""
    cells.insert(k, cells[k])
    owners.insert(k, owners[k])


def put_in(cells, owners, k, rng, pool):
    """Put in a cell from elsewhere in the table."""
    cells.insert(k, rng.choice(pool))
    owners.insert(k, NOBODY)


def run_together(cells, owners, k, rng, pool):  # noqa: ARG001
    """Print two cells as one that cannot be read."""
    cells[k : k + 2], owners[k : k + 2] = [np.nan], [NOBODY]


def garble(day, good_rows, rng):
    """Garble good rows in one to three places each; return the table and who owns each cell."""
    pool = day.offset[np.isfinite(day.offset)]
    table, owners = [], []
    for i, count in enumerate(day.cells):
        cells, own = list(day.offset[i, :count]), list(range(count))
        for _ in range(rng.integers(1, 4) if i in good_rows else 0):
            change = rng.choice([drop, double, put_in, run_together])
            change(cells, own, int(rng.integers(len(cells) - 1)), rng, pool)
        table.append(cells)
        owners.append(own)
    width = max(map(len, table))
    offset = np.full((len(table), width), np.nan)
    owner = np.full((len(table), width), NOBODY)
    for i, (cells, own) in enumerate(zip(table, owners, strict=True)):
        offset[i, : len(cells)], owner[i, : len(own)] = cells, own
    return replace(day, offset=offset, cells=np.array([len(cells) for cells in table])), owner


def vouched_and_right(session, seed):
    """Garble half of a day's good rows; count cells vouched for, right, and good before."""
    day = numbers(session)
    before = recover(day)
    n = len(ANTENNAS)
    trusted = before.trusted[:, :n] > VOUCHED
    in_place = (before.column[:, :n] == np.arange(n)).all(axis=1)
    good = np.flatnonzero((day.cells == n) & in_place & (trusted.sum(axis=1) >= 0.7 * n))
    rng = np.random.default_rng(seed)
    chosen = rng.permutation(good)[: len(good) // 2]

    garbled, owner = garble(day, set(chosen.tolist()), rng)
    after = recover(garbled)

    vouched = after.trusted[chosen] > VOUCHED
    right = vouched & (after.column[chosen] == owner[chosen])
    return vouched.sum(), right.sum(), trusted[chosen].sum()


@pytest.mark.parametrize("session", SESSIONS[2:], ids=lambda session: session.date)
def test_garbled_rows(session):
    """Of the cells it vouches for in garbled rows at least 98 % are right, and they are most."""
    counts = np.array([vouched_and_right(session, seed) for seed in range(2)]).sum(axis=0)

    vouched, right, there = counts
    assert right >= 0.98 * vouched
    assert vouched >= 0.8 * there


def simulated(rng, rows=24, columns=12):
    """Return a clean table of a smooth, noisy day, both directions apart."""
    hours = np.repeat(np.linspace(-3, 3, rows // 2), 2)
    direction = np.where(np.arange(rows) // 2 % 2, -1.0, 1.0)
    level, slope, half = (
        rng.uniform(-20, 20, columns),
        rng.normal(0, 2, columns),
        rng.normal(2, 1, columns),
    )
    truth = level + slope * hours[:, None] + half * direction[:, None]
    offset = np.round(truth + rng.normal(0, 0.5, truth.shape))
    nothing = np.full((rows, columns), np.nan)
    scan = np.arange(rows) // 2
    zero = np.zeros(rows, int)
    return Numbers(offset, np.full(rows, columns), hours, direction, scan, zero, nothing)


def test_a_clean_table_stays_as_it_is():
    """Nothing is moved where nothing was garbled, and almost every cell is vouched for."""
    day = simulated(np.random.default_rng(5))

    found = recover(day)

    assert (found.column == np.arange(12)).all()
    assert (found.trusted > VOUCHED).mean() > 0.97


def test_a_lost_cell_is_found():
    """A row that lost its third cell is put right from there on."""
    day = simulated(np.random.default_rng(6))
    offset, cells = day.offset.copy(), day.cells.copy()
    offset[7, 2:-1], offset[7, -1], cells[7] = offset[7, 3:], np.nan, 11

    found = recover(replace(day, offset=offset, cells=cells))

    assert found.column[7, :11].tolist() == [0, 1, *range(3, 12)]
    assert (found.belongs[7, 11] == 0).all()


def test_probabilities_add_up():
    """A cell belongs to at most one column, a column has at most one cell."""
    rng = np.random.default_rng(7)
    likelihood = rng.uniform(0, 0.3, (5, 6, 4))

    belongs = alignment(likelihood, np.full((5, 6), 0.05), np.array([6, 5, 4, 3, 6]))

    assert belongs.min() >= 0
    assert belongs.sum(axis=1).max() <= 1 + 1e-12
    assert belongs.sum(axis=2).max() <= 1 + 1e-12


def test_alignment_of_two_cells_and_one_column_by_hand():
    """The forward and backward sums agree with the three ways through written out."""
    from pyport.recordings.gmrt.align import EXTRA, LOST, MATCH, STEPS, STRANGER

    like, back = np.array([0.3, 0.2]), np.array([0.05, 0.07])
    first = STEPS[MATCH, MATCH] * like[0] * STEPS[MATCH, EXTRA] * back[1]
    second = STEPS[MATCH, EXTRA] * back[0] * STEPS[EXTRA, MATCH] * like[1]
    strangers = (
        STEPS[MATCH, STRANGER] * STEPS[STRANGER, EXTRA]
        + STEPS[MATCH, EXTRA] * STEPS[EXTRA, STRANGER]
    ) * back.prod()
    lost = back.prod() * (
        STEPS[MATCH, LOST] * STEPS[LOST, EXTRA] * STEPS[EXTRA, EXTRA]
        + STEPS[MATCH, EXTRA] * STEPS[EXTRA, LOST] * STEPS[LOST, EXTRA]
        + STEPS[MATCH, EXTRA] * STEPS[EXTRA, EXTRA] * STEPS[EXTRA, LOST]
    )
    total = first + second + strangers + lost

    belongs = alignment(like[None, :, None], back[None], np.array([2]))

    np.testing.assert_allclose(belongs[0, :, 0], [first / total, second / total], rtol=1e-12)
