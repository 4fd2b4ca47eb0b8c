"""How much of the printed tables was recovered, and how surely."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.recordings.files import read_raw, shipped
from pyport.studies.gmrt.published import ANTENNAS, SESSIONS, Session
from pyport.studies.gmrt.recovery.cells import VOUCHED, numbers
from pyport.studies.gmrt.recovery.recover import Numbers, recover

#: A printed row is usable that keeps offsets of this share of the antennas.
USABLE = 0.5


@dataclass(frozen=True)
class Recovery:
    """What became of one day's table."""

    #: `rows`, `usable`: printed rows, and those that keep offsets of half of the antennas or more.
    rows: int
    usable: int
    #: `cells`, `vouched`, `used`: printed offsets, those whose antenna is sure, and those that are
    #: used.
    cells: int
    vouched: int
    used: int


def recovery(session: Session) -> Recovery:
    """Return what became of a day's table, as the shipped recordings tell it."""
    raw = read_raw(shipped(session.date))
    row, used = raw.numbers("printed_row"), raw.words("set_aside") == ""
    rows, kept = np.unique(row, return_inverse=True)
    offsets = np.bincount(kept[used], minlength=len(rows))
    return Recovery(
        len(rows),
        int((offsets >= USABLE * len(ANTENNAS)).sum()),
        int((raw.words("printed_column") != "").sum()),
        int((np.nan_to_num(raw.numbers("confidence")) >= VOUCHED).sum()),
        int(used.sum()),
    )


def text(seeds: int) -> str:
    """Return what was recovered of June's tables, and how right it is when rows are garbled.

    `seeds`: how often good rows are garbled; not at all for 0.
    """
    june = [session for session in SESSIONS if session.date.startswith("2003-06")]
    lines = ["            printed rows   usable   cells   antenna sure    used"]
    found = [recovery(session) for session in june]
    for session, one in zip(june, found, strict=True):
        lines.append(
            f"{session.date} {one.rows:10d} {one.usable:8d} ({one.usable / one.rows:.0%})"
            f" {one.cells:6d} {one.vouched:7d} ({one.vouched / one.cells:.0%}) {one.used:7d}"
        )
    rows, usable = sum(one.rows for one in found), sum(one.usable for one in found)
    lines.append(
        f"usable, with offsets of {USABLE:.0%} of the antennas or more: {usable} of {rows} rows "
        f"({usable / rows:.1%})"
    )
    for session in june if seeds else ():
        each = [garbled(session, seed) for seed in range(seeds)]
        rows, vouched, right, before = (
            sum(getattr(one, name) for one in each)
            for name in ("rows", "vouched", "right", "before")
        )
        lines.append(
            f"{session.date}: {rows} good rows garbled, {vouched} of {before} cells still vouched "
            f"for ({vouched / before:.0%}), {right} of them rightly ({right / vouched:.2%})"
        )
    return "\n".join(lines)


#: A cell that was put in, or two run together: no antenna's.
NOBODY = -1

#: So many places of a row are garbled at most.
_PLACES = 3

#: A row is good where this share of its antennas is vouched for.
_GOOD = 0.7


@dataclass(frozen=True)
class Garbled:
    """What came of garbled rows."""

    rows: int  #: how many were garbled
    #: `vouched`, `right`: cells in them that the realignment vouches for, and those of them that
    #: are of the antenna that it says.
    vouched: int
    right: int
    before: int  #: cells that it vouched for before they were garbled


def garbled(session: Session, seed: int) -> Garbled:
    """Garble half of a day's good rows in one to three places each and realign the table.

    In each place a cell is dropped, printed twice, put in from elsewhere in the
    table, or run together with its neighbour.
    """
    day = numbers(session)
    before = recover(day)
    n = len(ANTENNAS)
    trusted = before.trusted[:, :n] > VOUCHED
    in_place = (before.column[:, :n] == np.arange(n)).all(axis=1)
    good = np.flatnonzero((day.cells == n) & in_place & (trusted.sum(axis=1) >= _GOOD * n))
    rng = np.random.default_rng(seed)
    chosen = rng.permutation(good)[: len(good) // 2]
    table, owner = _garble(day, set(chosen.tolist()), rng)
    after = recover(table)
    vouched = after.trusted[chosen] > VOUCHED
    right = vouched & (after.column[chosen] == owner[chosen])
    return Garbled(len(chosen), int(vouched.sum()), int(right.sum()), int(trusted[chosen].sum()))


def _garble(
    day: Numbers, rows: AbstractSet[int], rng: np.random.Generator
) -> tuple[Numbers, NDArray[np.int64]]:
    """Return the table with these rows garbled, and whose each cell is, shape (r, m)."""
    pool = day.offset[np.isfinite(day.offset)]
    table, owners = [], []
    for i, count in enumerate(day.cells):
        cells, own = day.offset[i, :count].tolist(), list(range(count))
        for _ in range(rng.integers(1, _PLACES + 1) if i in rows else 0):
            _once(cells, own, int(rng.integers(len(cells) - 1)), rng.choice(pool), rng)
        table.append(cells)
        owners.append(own)
    width = max(map(len, table))
    offset = np.full((len(table), width), np.nan)
    owner = np.full((len(table), width), NOBODY)
    for i, (cells, own) in enumerate(zip(table, owners, strict=True)):
        offset[i, : len(cells)], owner[i, : len(own)] = cells, own
    return replace(day, offset=offset, cells=np.array([len(cells) for cells in table])), owner


def _once(
    cells: list[float], owners: list[int], k: int, strange: float, rng: np.random.Generator
) -> None:
    """Garble a row at its cell k, in one of four ways."""
    way = rng.integers(4)
    if way == 0:
        del cells[k], owners[k]
    elif way == 1:
        cells.insert(k, cells[k])
        owners.insert(k, owners[k])
    elif way == 2:
        cells.insert(k, strange)
        owners.insert(k, NOBODY)
    else:
        cells[k : k + 2], owners[k : k + 2] = [np.nan], [NOBODY]
