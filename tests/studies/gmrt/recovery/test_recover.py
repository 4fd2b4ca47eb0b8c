"""Realignment: rows garbled on purpose find their antennas again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pyport.studies.gmrt.published import SESSIONS
from pyport.studies.gmrt.recovery.cells import VOUCHED
from pyport.studies.gmrt.recovery.printed import alignment
from pyport.studies.gmrt.recovery.recover import Numbers, recover
from pyport.studies.gmrt.recovery.recovery import garbled


@pytest.mark.slow
@pytest.mark.parametrize("session", SESSIONS[2:], ids=lambda session: session.date)
def test_garbled_rows(session):
    """Of the cells it vouches for in garbled rows at least 98 % are right, and they are most."""
    each = [garbled(session, seed) for seed in range(2)]
    right, vouched, before = (
        sum(getattr(one, name) for one in each) for name in ("right", "vouched", "before")
    )

    assert min(one.rows for one in each) >= 3
    assert right >= 0.98 * vouched
    assert vouched >= 0.8 * before


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


@pytest.mark.slow
def test_a_clean_table_stays_as_it_is():
    """Nothing is moved where nothing was garbled, and almost every cell is vouched for."""
    day = simulated(np.random.default_rng(5))

    found = recover(day)

    assert (found.column == np.arange(12)).all()
    assert (found.trusted > VOUCHED).mean() > 0.97


@pytest.mark.slow
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
    from pyport.studies.gmrt.recovery.printed import EXTRA, FOREIGN, LOST, MATCH, STEPS

    like, back = np.array([0.3, 0.2]), np.array([0.05, 0.07])
    first = STEPS[MATCH, MATCH] * like[0] * STEPS[MATCH, EXTRA] * back[1]
    second = STEPS[MATCH, EXTRA] * back[0] * STEPS[EXTRA, MATCH] * like[1]
    foreign = (
        STEPS[MATCH, FOREIGN] * STEPS[FOREIGN, EXTRA] + STEPS[MATCH, EXTRA] * STEPS[EXTRA, FOREIGN]
    ) * back.prod()
    lost = back.prod() * (
        STEPS[MATCH, LOST] * STEPS[LOST, EXTRA] * STEPS[EXTRA, EXTRA]
        + STEPS[MATCH, EXTRA] * STEPS[EXTRA, LOST] * STEPS[LOST, EXTRA]
        + STEPS[MATCH, EXTRA] * STEPS[EXTRA, EXTRA] * STEPS[EXTRA, LOST]
    )
    total = first + second + foreign + lost

    belongs = alignment(like[None, :, None], back[None], np.array([2]))

    np.testing.assert_allclose(belongs[0, :, 0], [first / total, second / total], rtol=1e-12)
