"""How much of the printed tables was recovered, and how surely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.recordings.files import read_raw, shipped
from pyport.studies.gmrt.recovery.cells import VOUCHED
from pyport.studies.gmrt.recovery.garble import garbled
from pyport.studies.gmrt.sessions import ANTENNAS, SESSIONS, Session

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
