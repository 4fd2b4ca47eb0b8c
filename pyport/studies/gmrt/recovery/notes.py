"""The figures in README.md, made from the recordings so that they cannot differ from them."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from pyport.recordings.files import read, shipped
from pyport.studies.gmrt.recovery import checks
from pyport.studies.gmrt.sessions import CRAB, CYG_A, SESSIONS

README = Path(__file__).parent / "README.md"


def figures() -> dict[str, str]:
    """Return each block of figures of the README by its name."""
    return {
        "counts": _counts(),
        "captions": _captions(),
        "directions": _directions(),
        "elevations": _elevations(),
    }


def readme() -> str:
    """Return the README with its figures as they are now."""
    text = README.read_text("utf-8")
    for name, block in figures().items():
        begin, end = f"<!-- figures: {name} -->\n", "<!-- end -->"
        before, rest = text.split(begin)
        text = before + begin + block + "\n" + rest[rest.index(end) :]
    return text


def _table(titles: list[str], rows: list[list[str]]) -> str:
    """Return a Markdown table."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _kind(reason: str) -> str:
    """Return a reason without what is particular to a cell."""
    return re.sub(r" \([CESW]\d\d\?\)", "", re.sub(r"row \d+", "row N", reason))


def _counts() -> str:
    """Return how many offsets are used, and how many excluded for each reason."""
    used: dict[str, int] = {}
    aside: dict[str, Counter[str]] = {}
    for session in SESSIONS:
        recordings = read(shipped(session.date))
        used[session.date] = len(recordings)
        aside[session.date] = Counter(_kind(one.reason) for one in recordings.set_aside)
    reasons = sorted({reason for counter in aside.values() for reason in counter})
    rows = [["**used**", *(f"**{used[date]}**" for date in used)]]
    rows += [[reason, *(str(aside[date][reason]) for date in used)] for reason in reasons]
    return _table(["", *used], rows)


def _captions() -> str:
    """Return how well each block of offsets agrees with each source and each day of Table 18."""
    rows = []
    for session in SESSIONS[1:]:
        crab, cyg_a = (
            checks.elevation_misfit_deg(session.table, next(s for s in SESSIONS if s.source is one))
            for one in (CRAB, CYG_A)
        )
        misfits = checks.caption_misfits(read(shipped(session.date)))
        rows.append(
            [
                f"table_{session.table}.tsv",
                f"{crab:.1f}",
                f"{cyg_a:.1f}",
                *(f"{misfit:.1f}" for misfit in misfits.values()),
                session.date,
            ]
        )
    days = [f"{session.date} [′]" for session in SESSIONS]
    return _table(["", "Crab [°]", "Cyg A [°]", *days, "so it is of"], rows)


def _directions() -> str:
    """Return how well the half-differences add up, for the directions taken and for the others."""
    halves = [checks.half_differences(read(shipped(session.date)), session) for session in SESSIONS]
    choices = {
        "1, 2 and 5 June": halves[2:],
        "31 May, 1, 2 and 5 June": halves[1:],
        "31 March (labelled in print), 1, 2 and 5 June": [halves[0], *halves[2:]],
    }
    rows = []
    for name, chosen in choices.items():
        misfits = checks.adding_up(chosen)
        taken = misfits.pop((1,) * len(chosen))
        rows.append([name, f"{taken:.2f}", f"{min(misfits.values()):.2f}"])
    return _table(["days", "as derived [′]", "best of all other choices [′]"], rows)


def _elevations() -> str:
    """Return how the printed elevations differ from those of the printed hour angles."""
    rows = []
    for session in SESSIONS[1:]:
        late_h, constant, rest = checks.late_elevations(session.table, session)
        rows.append([session.date, f"{late_h * 60:.0f}", f"{constant:+.1f}", f"{rest:.2f}"])
    return _table(["day", "late [min]", "constant [°]", "median of the rest [°]"], rows)
