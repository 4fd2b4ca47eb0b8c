"""Is it what it says? Captions by declination and Table 18, directions, elevations."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, Array
from pyport.recordings import sky
from pyport.recordings.files import read, shipped
from pyport.recordings.schema import Recordings
from pyport.studies.gmrt.published import (
    ANTENNAS,
    CRAB,
    CYG_A,
    LATITUDE_DEG,
    SESSIONS,
    Session,
    apparent_place,
    table_18,
)
from pyport.studies.gmrt.recovery import printed


def elevation_misfit_deg(table: int, session: Session) -> float:
    """Return the rms of a table's printed elevations about those of a session's source [deg]."""
    heads = np.array([row.head for row in printed.day(table)], float)
    _, dec = apparent_place(session)
    _, el = sky.horizon(heads[:, 0] * HOUR, np.full(len(heads), dec), LATITUDE_DEG * DEG)
    return float(np.sqrt(np.mean((heads[:, 1] - el / DEG) ** 2)))


def caption_misfits(recordings: Recordings) -> dict[str, float]:
    """Return, for each day of Table 18, how far its curves run from these recordings [arcmin].

    The median over antennas of each antenna's rms.
    """
    antenna, hour_angle = recordings.at.column("antenna"), recordings.at.column("hour_angle")
    misfits: dict[str, list[float]] = {session.date: [] for session in SESSIONS}
    for wave in table_18():
        own = antenna == wave.antenna
        if own.sum() >= 10:
            apart = recordings.y[own] - wave(hour_angle[own])
            misfits[wave.session].append(float(np.sqrt(np.mean(apart**2))) / ARCMIN)
    return {date: float(np.median(each)) for date, each in misfits.items()}


def half_differences(recordings: Recordings, session: Session) -> Array:
    """Return half of forward minus reverse of each antenna [arcmin], NaN for too few, shape (30,).

    A robust cubic in hour angle takes what runs smoothly, and a step where new
    offsets were loaded.
    """
    antenna, all_hours = recordings.at.column("antenna"), recordings.at.column("hour_angle") / HOUR
    differences = np.full(len(ANTENNAS), np.nan)
    for place, name in enumerate(ANTENNAS):
        own = antenna == name
        if own.sum() < 10:
            continue
        hours, y = all_hours[own], recordings.y[own] / ARCMIN
        powers = np.vander((hours - hours.mean()) / 3, 4)
        steps = [(hours > at)[:, None] for at in session.reloaded_at_h]
        direction = recordings.at.column("scan_direction")[own]
        design = np.concatenate([direction[:, None], powers, *steps], axis=1)
        weight = np.ones(len(y))
        for _ in range(20):
            fit = np.linalg.lstsq(design * weight[:, None], y * weight, rcond=None)[0]
            weight = 1 / (1 + ((y - design @ fit) / 1.5) ** 2)
        differences[place] = fit[0]
    return differences


def adding_up(differences: Sequence[Array]) -> dict[tuple[int, ...], float]:
    """Return the rms misfit [arcmin] of antenna plus day, for every choice of directions.

    What makes forward differ from reverse is an antenna's own (slack, the same
    every day) plus what all antennas share on a day (the time tag). With the
    right directions the half-differences add up so; with a day's directions
    swapped they do not. The first day's directions are held.
    """
    table = np.stack(differences, axis=1)
    table = table[np.isfinite(table).all(axis=1)]
    free = (table.shape[0] - 1) * (table.shape[1] - 1)
    misfits = {}
    for signs in itertools.product((1, -1), repeat=table.shape[1] - 1):
        turned = table * np.array((1, *signs))
        rest = turned - turned.mean(axis=1, keepdims=True) - turned.mean(axis=0) + turned.mean()
        misfits[1, *signs] = float(np.sqrt((rest**2).sum() / free))
    return misfits


def late_elevations(table: int, session: Session) -> tuple[float, float, float]:
    """Return by how much the elevations were printed late, and what is left.

    Fits el(HA + late) + e to the printed elevations, outliers faded.

    Returns late [h], e [deg], and the median of what is left [deg].
    """
    heads = np.array([row.head for row in printed.day(table)], float)
    _, dec = apparent_place(session)

    def elevation(late_h: float) -> Array:
        hours = (heads[:, 0] + late_h) * HOUR
        return sky.horizon(hours, np.full(len(heads), dec), LATITUDE_DEG * DEG)[1] / DEG

    late = constant = 0.0
    for _ in range(30):
        apart = heads[:, 1] - elevation(late) - constant
        slope = (elevation(late + 0.01) - elevation(late - 0.01)) / 0.02
        weight = 1 / (1 + (apart / 0.6) ** 2)
        design = np.stack([slope, np.ones(len(slope))], axis=1) * weight[:, None]
        step = np.linalg.lstsq(design, apart * weight, rcond=None)[0]
        late, constant = late + float(step[0]), constant + float(step[1])
    return late, constant, float(np.median(np.abs(heads[:, 1] - elevation(late) - constant)))


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
            elevation_misfit_deg(session.table, next(s for s in SESSIONS if s.source is one))
            for one in (CRAB, CYG_A)
        )
        misfits = caption_misfits(read(shipped(session.date)))
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
    halves = [half_differences(read(shipped(session.date)), session) for session in SESSIONS]
    choices = {
        "1, 2 and 5 June": halves[2:],
        "31 May, 1, 2 and 5 June": halves[1:],
        "31 March (labelled in print), 1, 2 and 5 June": [halves[0], *halves[2:]],
    }
    rows = []
    for name, chosen in choices.items():
        misfits = adding_up(chosen)
        taken = misfits.pop((1,) * len(chosen))
        rows.append([name, f"{taken:.2f}", f"{min(misfits.values()):.2f}"])
    return _table(["days", "as derived [′]", "best of all other choices [′]"], rows)


def _elevations() -> str:
    """Return how the printed elevations differ from those of the printed hour angles."""
    rows = []
    for session in SESSIONS[1:]:
        late_h, constant, rest = late_elevations(session.table, session)
        rows.append([session.date, f"{late_h * 60:.0f}", f"{constant:+.1f}", f"{rest:.2f}"])
    return _table(["day", "late [min]", "constant [°]", "median of the rest [°]"], rows)
