"""Is it what it says? Captions by declination and Table 18, directions, elevations."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, Array
from pyport.recordings import sky
from pyport.recordings.schema import Recordings
from pyport.studies.gmrt.published import table_18
from pyport.studies.gmrt.recovery import printed
from pyport.studies.gmrt.sessions import ANTENNAS, LATITUDE_DEG, SESSIONS, Session, apparent_place


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
