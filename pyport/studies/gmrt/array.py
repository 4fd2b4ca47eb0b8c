"""The GMRT as an array: its recordings of 2003 taken apart, and held against its survey."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCMIN
from pyport.diagnosis.arrays.places import Comparison
from pyport.diagnosis.arrays.repeat import UnseenDays, medians
from pyport.diagnosis.arrays.report import SCAN, ArrayReport, report
from pyport.diagnosis.arrays.words import comparison, held_out, predict, words
from pyport.diagnosis.diagnose import Diagnosis, diagnose
from pyport.formats.models import load
from pyport.plots.places import write_places
from pyport.recordings import read
from pyport.recordings.files import Survey
from pyport.report import array as as_data

MODEL = "gmrt-paper"
#: All days of Cyg A, and each by itself.
TOGETHER = "gmrt-cyg-a"
DAYS = ("gmrt-2003-06-01", "gmrt-2003-06-02", "gmrt-2003-06-05")
#: The Crab, to be predicted from Cyg A.
CRAB = ("gmrt-2003-05-31", "gmrt-2003-03-31")
#: What must come out: the place of the antennas on these, the held-out gain on that day.
PLACED = (TOGETHER, "gmrt-2003-06-02")
GAINED = "2003-06-01"
LEAST_CORRELATION, SLOPE_WITHIN, LEAST_FACTOR = 0.93, 0.15, 2.0
LEAST_CHANGE, LEAST_WITHIN = 5.0, 0.9


@dataclass(frozen=True)
class Check:
    """A number that must come out, what was asked for, and whether it did."""

    what: str
    value: float
    wanted: str
    passed: bool


@dataclass(frozen=True)
class Evidence:
    """What the GMRT's recordings say of it as an array."""

    array: ArrayReport  #: all days of Cyg A
    alone: dict[str, Comparison | None]  #: each day of Cyg A beside the survey; empty without one
    crab: dict[str, UnseenDays]  #: each day of the Crab, predicted from Cyg A
    checks: tuple[Check, ...]  #: what must come out

    def as_json(self) -> dict[str, Any]:
        """Return all numbers."""
        return {
            "array": as_data.as_json(self.array),
            "alone": {
                name: None if one is None else as_data.comparison_json(one)
                for name, one in self.alone.items()
            },
            "crab": {name: as_data.unseen_json(one) for name, one in self.crab.items()},
            "checks": [vars(one) for one in self.checks],
        }


def evidence(
    survey: Survey | None = None, tell: Callable[[str], None] = lambda _: None
) -> Evidence:
    """Diagnose the GMRT's recordings and return what they say of it as an array.

    `survey`: where its antennas stand, to compare with; without it nothing is compared.
    `tell`: called with a line about each step.
    Raises `BadInput`: the survey is of other antennas.
    """
    known = _diagnosed(TOGETHER, tell)
    array = _array(known, survey)
    alone = {}
    if survey is not None:
        alone = {name: _array(_diagnosed(name, tell), survey).comparison for name in DAYS}
    crab = {}
    for name in CRAB:
        other = _diagnosed(name, tell)
        crab[name] = predict(array, other.problem, other.after)
    return Evidence(array, alone, crab, tuple(_checks(array, alone)))


def _diagnosed(name: str, tell: Callable[[str], None]) -> Diagnosis:
    tell(f"diagnosing {name}")
    return diagnose(read(name), load(MODEL))


def _array(diagnosis: Diagnosis, survey: Survey | None) -> ArrayReport:
    found = report(diagnosis.problem, diagnosis.after, survey)
    if found is None:
        raise ValueError(f"{diagnosis.problem.recordings.file.stem} is no array's")
    return found


def _checks(array: ArrayReport, alone: dict[str, Comparison | None]) -> list[Check]:
    """Return the numbers that must come out."""
    found = []
    tags = [one.tag for one in array.sessions if one.tag is not None]
    if tags:
        low, high = min(tags), max(tags)
        change = (high[0] - low[0]) / float(np.hypot(high[1], low[1]))
        wanted = f"at least {LEAST_CHANGE:g}"
        what = "time tags of the days differ by up to so many sigmas"
        found.append(Check(what, change, wanted, change >= LEAST_CHANGE))
    for day in array.repeats[SCAN]:
        what = f"own scan parts of {day.session} predicted by the other days: share left"
        found.append(Check(what, day.left / day.size, "below 0.5", day.left < day.size / 2))
    for name, one in {TOGETHER: array.comparison, **alone}.items():
        if one is not None and name in PLACED:
            enough, near = one.correlation >= LEAST_CORRELATION, abs(one.slope - 1) <= SLOPE_WITHIN
            wanted = f"at least {LEAST_CORRELATION}"
            found.append(Check(f"{name}: correlation", one.correlation, wanted, enough))
            wanted = f"1 +- {SLOPE_WITHIN}"
            found.append(Check(f"{name}: implied over surveyed", one.slope, wanted, near))
            within = float(np.mean(np.abs(one.misses) <= 2))
            what, wanted = (
                f"{name}: share of antennas within two sigmas",
                f"at least {LEAST_WITHIN}",
            )
            found.append(Check(what, within, wanted, within >= LEAST_WITHIN))
    if array.unseen is not None:
        factor = medians(array.unseen.of(GAINED)).factor
        what = f"{GAINED}: held-out rms of the median antenna falls by"
        wanted = f"at least {LEAST_FACTOR:g}"
        found.append(Check(what, factor, wanted, factor >= LEAST_FACTOR))
    return found


def page(found: Evidence) -> str:
    """Return the evidence as plain text."""
    parts = [words(found.array)]
    for name, one in found.alone.items():
        if one is not None and found.array.places is not None:
            parts.append(
                "\n".join([f"{name} alone:", *comparison(one, found.array.places.radius_m)])
            )
    for name, crab in found.crab.items():
        head = f"{name}, the Crab, from Cyg A:"
        parts.append("\n".join([head, *held_out(crab), *_verdict(crab)]))
    lines = ["What must come out:"]
    for check in found.checks:
        said = f"{check.what}: {check.value:.3f} (wanted {check.wanted})"
        lines.append(f"  {'yes' if check.passed else 'NO ':3} {said}")
    parts.append("\n".join(lines))
    return "\n\n".join(parts)


def _verdict(one: UnseenDays) -> list[str]:
    """Say in one line whether a day of the Crab follows from Cyg A."""
    if not one.days:
        return ["  No antenna could be predicted."]
    median = medians(one.days)
    good = median.after < median.fitted_before
    verdict = f"{'Good' if good else 'Bad'}: predicted to {median.after / ARCMIN:.2f}'"
    beside = f"{'only ' if good else ''}to {median.fitted_before / ARCMIN:.2f}'"
    return [f"  {verdict}, the model's form fits that very day {beside}."]


def write(found: Evidence, folder: Path) -> list[Path]:
    """Draw the implied places and return the pictures' paths."""
    path = write_places(found.array, folder)
    return [] if path is None else [path]
