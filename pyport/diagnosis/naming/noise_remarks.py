"""What the noise does beyond scattering evenly: departures, drifts, scatter that is not even."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.least_squares import robust
from pyport.noise import outliers
from pyport.recordings.raw import BLANK
from pyport.recordings.sky import CELLS, ORDER, SESSIONS, SHORT, TIMELESS, TIMES
from pyport.thresholds import FEWEST, REFUTES

if TYPE_CHECKING:
    from pyport.diagnosis.diagnose import Diagnosis

#: Of what departs: its scatter, and several of it where they are counted.
_WORDS = {
    "session": ("Night-to-night", "sessions"),
    "stretch": ("Stretch-to-stretch", "stretches"),
    "source": ("Source-to-source", "sources"),
}
#: Several of it where they differ.
DIFFER = {"session": "nights", "stretch": "stretches of rows", "source": "sources"}
#: What a header says under some keys was done to the recordings, and how it is said.
_HEADER = {
    SHORT: "Sessions are too short to be distinguished and are not used: ",
    SESSIONS: "Sessions are taken from ",
    ORDER: "Time is taken from ",
    TIMELESS: "Drifts and nights are not known: ",
    BLANK: "Taken for blank: ",
    CELLS: "Blank cells are taken from the rows before and after: ",
    TIMES: "Times that are not recorded are taken from ",
}
#: Scatter that differs by less than a quarter between low and high is not worth a word.
GROWS = 1.25
#: A drift that widens the scatter by less is not worth one.
DRIFTS = 1.1
#: Scatter of so many times the recorded errors is more than that these are a little small.
BEYOND_ERRORS = 2.0
#: The lowest and the highest share of the readings that are compared.
END = 0.2


@dataclass(frozen=True)
class NoiseRemarks:
    """What the noise does beyond scattering evenly: see the functions that return each."""

    departing: Sequence[dict[str, Any]]  #: `departures`
    drifting: Sequence[dict[str, Any]]  #: `drifts`
    growing: Sequence[dict[str, Any]]  #: `by_elevation`
    uneven: Sequence[str]  #: `uneven`
    outlying: Sequence[str]  #: `outliers.shared`
    beyond: Sequence[str] = ()  #: `beyond_errors`


def noise_remarks(diagnosis: Diagnosis) -> NoiseRemarks:
    """Return what the noise of a diagnosis does beyond scattering evenly."""
    left, problem = diagnosis.left(diagnosis.after), diagnosis.problem
    return NoiseRemarks(
        departures(diagnosis, left),
        drifts(diagnosis, left),
        by_elevation(diagnosis),
        uneven(diagnosis, left),
        list(outliers.shared(problem.recordings, problem.stack, diagnosis.weighed.used)),
        beyond_errors(diagnosis, left),
    )


def departures(diagnosis: Diagnosis, left: Array) -> list[dict[str, Any]]:
    """Return the random departures of sessions and sources, and which departs most, for reports.

    By its number where a term has one, else by its length. `left` are the residuals (m,) of the
    fit with everything found.
    """
    covariance = diagnosis.weighed.covariance
    found = []
    for one, values in zip(covariance.departures, covariance.departed_by(left), strict=True):
        labels = list(dict.fromkeys(one.labels))
        size = np.linalg.norm(values, axis=0)
        most = int(np.argmax(size))
        found.append(
            {
                "term": one.term,
                "of": one.of,
                "antenna": one.antenna,
                "sigma_arcsec": one.sigma / ARCSEC,
                "labels": labels,
                "most_label": labels[most],
                "most_arcsec": float(values[0, most] if len(values) == 1 else size[most]) / ARCSEC,
            }
        )
    return found


def by_elevation(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return how many times the scatter at the lowest elevations is that at the highest, by axis.

    Of the fifth of the readings at either end; only where it differs by a quarter and more.
    """
    problem, floor = diagnosis.problem, diagnosis.weighed.covariance.floor
    el = problem.recordings.at.el[problem.stack.row]
    found = []
    for is_y, name in zip((False, True), problem.recordings.at.mount.names, strict=True):
        rows = np.flatnonzero((problem.stack.is_y == is_y) & diagnosis.weighed.used)
        end = int(END * len(rows))
        if end == 0:
            continue
        order = rows[np.argsort(el[rows], kind="stable")]
        low, high = (float(np.median(floor[part])) for part in (order[:end], order[-end:]))
        ratio = low / max(high, 1e-300)
        if max(ratio, 1 / ratio) >= GROWS:
            found.append(
                {
                    "axis": name,
                    "low_el_deg": float(np.median(el[order[:end]])) / DEG,
                    "high_el_deg": float(np.median(el[order[-end:]])) / DEG,
                    "low_arcsec": low / ARCSEC,
                    "high_arcsec": high / ARCSEC,
                }
            )
    return found


def drifts(diagnosis: Diagnosis, left: Array) -> list[dict[str, Any]]:
    """Return what a single antenna drifts by in each axis, and the sessions furthest from usual.

    Rms of what a drift has moved the readings by, as the residuals `left` (m,) show it, its
    memory, and their mean in the lowest and the highest session; only where that widens the scatter
    by a tenth and more.
    """
    problem = diagnosis.problem
    if problem.blocks.antennas > 1:
        return []
    of_order = ORDER in problem.recordings.meta
    covariance = diagnosis.weighed.covariance
    moved = covariance.drifted(left)
    session = problem.session_names
    found = []
    for part, noise in zip(problem.parts, covariance.shown, strict=True):
        rows = part.rows[covariance.used[part.rows]]
        white = np.hypot(noise.within, noise.between) / np.sqrt(covariance.precision[rows])
        power = float((moved[rows] ** 2).mean())
        if noise.time_s is None or power < (DRIFTS**2 - 1) * float((white**2).mean()):
            continue
        names = set(session[rows].tolist())
        means = {one: float(left[rows][session[rows] == one].mean()) for one in names}
        low, high = (end(means, key=lambda one: (means[one], one)) for end in (min, max))
        found.append(
            {
                "axis": problem.recordings.at.mount.names[part.is_y],
                "rms_arcsec": float(np.sqrt(power)) / ARCSEC,
                "memory_s": None if of_order else noise.time_s,
                "memory_rows": noise.time_s if of_order else None,
                "lowest_session": low,
                "lowest_arcsec": means[low] / ARCSEC,
                "highest_session": high,
                "highest_arcsec": means[high] / ARCSEC,
            }
        )
    return found


def uneven(diagnosis: Diagnosis, left: Array) -> list[str]:
    """Return a sentence for each axis of a single antenna in which one session scatters more.

    Of the residuals `left` (m,) by everything found; only where its scatter is larger by a quarter,
    and by more than chance.
    """
    problem = diagnosis.problem
    session, axis = problem.session, problem.stack.is_y.astype(int)
    if problem.blocks.antennas > 1 or len(np.unique(session)) < 2:
        return []
    names = problem.session_names
    found = []
    for is_y, name in enumerate(problem.recordings.at.mount.names):
        own = (axis == is_y) & diagnosis.weighed.used
        there, counts = np.unique(session[own], return_counts=True)
        counted = dict(zip(there[counts >= FEWEST], counts[counts >= FEWEST], strict=True))
        each = {one: left[own & (session == one)] for one in counted}
        sizes = {one: robust.scale(some - np.median(some)) for one, some in each.items()}
        if len(sizes) < 2:
            continue
        most = max(sizes, key=lambda one: sizes[one])
        usual = float(np.median([size for one, size in sizes.items() if one != most]))
        more = np.log(sizes[most] / max(usual, 1e-300))
        if more > max(np.log(GROWS), REFUTES / np.sqrt(2 * counted[most])):
            said = f"{sizes[most] / ARCSEC:.2g} arcsec in {names[session == most][0]}"
            found.append(f"Scatter in {name} is {usual / ARCSEC:.2g} arcsec, but {said}")
    return found


def beyond_errors(diagnosis: Diagnosis, left: Array) -> list[str]:
    """Return a sentence for each axis whose offsets scatter far beyond their recorded errors.

    Of the residuals `left` (m,) by everything found, over those errors, drifts and all.
    """
    recordings, stack = diagnosis.problem.recordings, diagnosis.problem.stack
    found = []
    for is_y, name in enumerate(recordings.at.mount.names):
        error = (recordings.sigma_x, recordings.sigma_y)[is_y][stack.row]
        own = (stack.is_y == is_y) & diagnosis.weighed.used & (error > 0)
        if own.sum() < FEWEST:
            continue
        times = robust.scale(left[own] / error[own])
        if times > BEYOND_ERRORS:
            found.append(f"Offsets in {name} scatter by {times:.2g} times their recorded errors")
    return found


def _of_drift(one: dict[str, Any]) -> str:
    several = one["lowest_session"] != one["highest_session"]
    if one["memory_s"] is None:
        along, memory = "along the rows", f"{one['memory_rows']:.0f} rows"
    else:
        along, hours = "with date" if several else "with time", one["memory_s"] / 3600
        memory = f"{hours:.2g} h" if hours < 48 else f"{hours / 24:.2g} days"
    said = (
        f"{one['axis'].capitalize()} drifts {along}: {one['rms_arcsec']:.2g} arcsec rms with a "
        f"memory of {memory}"
    )
    if not several:
        return said
    low, high = (
        f"{one[f'{end}_arcsec']:.2g} ({one[f'{end}_session']})" for end in ("lowest", "highest")
    )
    return f"{said}; means of sessions run from {low} to {high} arcsec"


def sentences(noise: NoiseRemarks, meta: Mapping[str, str]) -> list[str]:
    """Return a sentence for all that the noise does, and for what the recordings' header tells."""
    said = [
        f"{_WORDS[one['of']][0]} scatter of the {one['term']}: {one['sigma_arcsec']:.2g} arcsec "
        f"({len(one['labels'])} {_WORDS[one['of']][1]}; "
        f"{one['most_arcsec']:.2g} in {one['most_label']})"
        for one in noise.departing
    ]
    said += map(_of_drift, noise.drifting)
    said += [
        f"Scatter in {one['axis']} is {one['low_arcsec']:.2g} arcsec near "
        f"{one['low_el_deg']:.0f} deg of elevation and {one['high_arcsec']:.2g} near "
        f"{one['high_el_deg']:.0f} deg"
        for one in noise.growing
    ]
    said += [*noise.uneven, *noise.beyond]
    said += [words + meta[key] for key, words in _HEADER.items() if key in meta]
    return said
