"""Drawn cases: how often silent, how often right, how often honestly at a loss."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCMIN, DEG
from pyport.diagnosis.arrays.repeat import medians
from pyport.diagnosis.diagnose import diagnose
from pyport.examiner.ideal import observer
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import Rate, count, write_recordings
from pyport.examiner.sealed.scoring.judge import Verdict, judge, place, read_table
from pyport.examiner.worlds.campaign import NOISES
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.faults import UNCATALOGUED
from pyport.examiner.worlds.faults.mount import rt32_edge_on_the_cable
from pyport.examiner.worlds.kinds import HIDEABLE, make_case
from pyport.formats.models import load
from pyport.recordings import read
from pyport.recordings.files import Survey
from pyport.report.made import report_of
from pyport.report.typed import as_json
from pyport.runs.stages import track
from pyport.studies.gmrt.array import GAINED, evidence

#: Cases without anything hidden, and of each uncatalogued cause.
NULLS, OF_UNCATALOGUED = 200, 8
#: The share of cases without anything hidden in which something may be claimed.
MOST_CLAIMS = 0.05
#: How loud a cause is, how often each is drawn then, and the share that must come out.
LOUDNESS = ((0.5, 2, 0.95), (0.25, 2, 0.85))
#: Column or place that an uncatalogued cause must be found at; the others are anywhere in the sky.
_FOLLOWS = {"strange_column": "hydraulic_bar", "long_oscillation": "time"}


@dataclass(frozen=True)
class Line:
    """A figure, what was asked for, and whether it came out; None where it is shown only."""

    what: str
    value: str
    wanted: str
    passed: bool | None


def lines(jobs: int, seed: int) -> Iterator[Line]:
    """Yield the figures of all drawn cases; `seed` is where their seeds begin."""
    specs = list(_specs())
    tasks = [(spec, seed + n) for n, spec in enumerate(specs)]
    with ProcessPoolExecutor(jobs) as pool:
        solved = track(pool.map(_solve, tasks, chunksize=4), "diagnosing", total=len(tasks))
        verdicts, chances = zip(*solved, strict=True)
    yield _silence([one for one in verdicts if one.group == "null"])
    for rho, _, least in LOUDNESS:
        beside = [
            (one, chance)
            for one, chance in zip(verdicts, chances, strict=True)
            if one.group == "one" and one.spec["rho"] == rho
        ]
        masked = [one for one, _ in beside]
        yield _at_least(f"masked, rho {rho}: named or in its class", _right(masked), least)
        could = sum(chance for _, chance in beside)
        what = f"masked, rho {rho}: the same over what an ideal observer detects"
        yield Line(what, f"{_right(masked).hits / max(could, 1e-9):.3f}", "shown", None)
        yield from _missed(masked)
    uncatalogued = [one for one in verdicts if one.group == "unknown"]
    yield _at_least("in no catalogue: unknown", _right(uncatalogued), 0.8)
    for name in UNCATALOGUED:
        own = [one for one in uncatalogued if one.spec["effect"] == name]
        rate = _right(own)
        yield Line(f"  {name.replace('_', ' ')}", f"{rate.hits} of {rate.of}", "shown", None)


def _specs() -> Iterator[Spec]:
    for n in range(NULLS):
        yield Spec("null", "null", noise=NOISES[n % len(NOISES)])
    for rho, times, _ in LOUDNESS:
        for effect in HIDEABLE:
            yield from [Spec("one", "one", effect, rho)] * times
    for name in UNCATALOGUED:
        yield from [Spec("unknown", "unknown", name, 0.5)] * OF_UNCATALOGUED


def _solve(task: tuple[Spec, int]) -> tuple[Verdict, float]:
    """Make a case, write what may be seen of it, diagnose that, and judge the report.

    With the verdict comes the chance that an ideal observer detects the cause.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    spec, seed = task
    made = spec.make(seed)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "recordings.csv"
        report = diagnosed(made, path)
        verdict = judged(spec, seed, made, report)
        placed = place(read_table(path), report["findings"], made.truth["effects"])
    wanted = _FOLLOWS.get(spec.effect or "")
    if spec.group == "unknown" and verdict.first and wanted:
        like = report["findings"][0]["looks_like"] or ""
        verdict = replace(verdict, first=wanted in like)
    chance = 0.0 if made.truth["kind"] != "one" else observer.possible(made)
    return replace(verdict, place=placed), chance


def diagnosed(made: Case, path: Path) -> dict[str, Any]:
    """Return the report of a made case; what may be seen of it is written to `path`."""
    write_recordings(made, path)
    return reported(made, path)


def reported(made: Case, path: Path, model: str | None = None) -> dict[str, Any]:
    """Return the report of a made case that was written to `path` before."""
    asked = dict(zip(made.arguments[::2], made.arguments[1::2], strict=True))
    refit = None if asked.get("--refit", "all") == "all" else ()
    found = diagnose(read(path), load(model or asked.get("--model", "altaz")), refit=refit)
    report: dict[str, Any] = as_json(report_of(found))
    return report


def judged(spec: Spec, seed: int, made: Case, report: dict[str, Any]) -> Verdict:
    """Return what the report of a made case is worth."""
    truth = {"spec": spec.as_json(), "truth": made.truth}
    return judge(str(seed), truth, {**report, "examined": {}})


def _right(verdicts: Iterable[Verdict]) -> Rate:
    return count([one.first for one in verdicts])


def _silence(verdicts: Iterable[Verdict]) -> Line:
    rate = count([one.claimed for one in verdicts])
    wanted, within = f"at most {100 * MOST_CLAIMS:.0f} %", rate.hits <= MOST_CLAIMS * rate.of
    return Line("nothing hidden: any finding", str(rate), wanted, within)


def _at_least(what: str, rate: Rate, least: float) -> Line:
    return Line(what, str(rate), f"at least {100 * least:.0f} %", rate.hits >= least * rate.of)


def _missed(verdicts: Iterable[Verdict]) -> Iterator[Line]:
    """Yield a line for every cause that did not come out, with what was said instead."""
    for one in verdicts:
        if not one.first:
            why = f"p = {one.p_value:.2g}" if one.p_value is not None else "no p-value"
            said = f"{one.said} ({why})"
            yield Line(f"  {one.spec['effect']}, seed {one.case}", said, "shown", None)


def array_lines(survey: Survey | None) -> Iterator[Line]:
    """Yield the figures of the GMRT's recordings; without a survey no place is compared."""
    found = evidence(survey)
    array = found.array
    tags = [
        f"{one.name} {one.tag[0]:+.2f} +- {one.tag[1]:.2f} s" for one in array.sessions if one.tag
    ]
    yield Line("GMRT, time tags of scans, for all antennas", ", ".join(tags), "shown", None)
    for check in found.checks:
        yield Line(f"GMRT, {check.what}", f"{check.value:.3f}", check.wanted, check.passed)
    if array.unseen is not None:
        median = medians(array.unseen.of(GAINED))
        seen = f"{median.fitted_before / ARCMIN:.2f}' to {median.fitted_after / ARCMIN:.2f}'"
        factor = median.fitted_before / median.fitted_after
        what = f"GMRT, {GAINED}: rms of the median antenna in the fit falls by"
        yield Line(what, f"{factor:.3f} ({seen})", "shown", None)
        weak = [one for one in array.unseen.days if one.why]
        seen = f"{len(weak)} of {len(array.unseen.days)}; `pyport study gmrt-array` has the reasons"
        yield Line("GMRT, antenna-days that gain less than twice", seen, "shown", None)
    for name, crab in found.crab.items():
        if not crab.days:
            yield Line(f"{name}, the Crab, from Cyg A", "no antenna", "shown", None)
            continue
        median = medians(crab.days)
        numbers = np.array([median.before, median.after, median.fitted_before]) / ARCMIN
        seen = "{:.2f}' to {:.2f}'; the model fitted to that very day {:.2f}'".format(*numbers)
        yield Line(f"{name}, the Crab, from Cyg A: rms of the median antenna", seen, "shown", None)


#: The published model without its last parameter.
TERMS = (
    *("azimuth_zero", "elevation_zero", "collimation", "skew", "tilt", "sag_cosine"),
    *("sag_sine", "azimuth_harmonics", "elevation_harmonics"),
)
CAMPAIGNS = 3
#: The published p12, which the campaigns are made with.
SIZE_ARCSEC = -73.4
#: Where the edge must be, how far off the size may be, how long it may take.
NEAR_DEG, SIGMAS, SECONDS = 2.0, 2.0, 5.0


def jump_lines(seed: int) -> Iterator[Line]:
    """Yield the figures of some campaigns; `seed` is that of the first."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        model = folder / "without-p12.toml"
        model.write_text("".join(f'[[term]]\neffect = "{one}"\n' for one in TERMS), "utf-8")
        for n in range(CAMPAIGNS):
            yield from _campaign(seed + n, folder, str(model))


def _campaign(seed: int, folder: Path, model: str) -> Iterator[Line]:
    made = make_case("rt32-campaign", seed)
    path = folder / f"campaign-{seed}.csv"
    write_recordings(made, path)
    started = time.perf_counter()
    report = reported(made, path, model)
    took = time.perf_counter() - started
    head = f"RT32 campaign {seed}"
    jumps = [one for one in report["findings"] if one["effect"] == "subreflector_jump"]
    named = bool(jumps) and jumps[0]["verdict"] == "named"
    yield Line(f"{head}: jump named", "yes" if named else "no", "yes", named)
    if jumps:
        edge = _edge_off_deg(jumps[0])
        size = jumps[0]["parameters"][0]
        off = abs(size["value"] - SIZE_ARCSEC) / size["sigma"]
        near = edge is not None and edge <= NEAR_DEG
        seen = "no curve" if edge is None else f"{edge:.2f} deg"
        yield Line(f"{head}: its edge is off by", seen, f"at most {NEAR_DEG:g} deg", near)
        seen = f"{size['value']:.1f} +- {size['sigma']:.1f} arcsec, {off:.1f} sigma off"
        yield Line(f"{head}: its size", seen, f"within {SIGMAS:g} sigma", off <= SIGMAS)
    others = [one["effect"] for one in report["findings"] if one not in jumps]
    yield Line(f"{head}: found besides", ", ".join(others) or "nothing", "shown", None)
    rows = report["input"]["rows"]
    yield Line(
        f"{head}: {rows} rows diagnosed in",
        f"{took:.1f} s",
        f"{SECONDS:g} s",
        took < SECONDS,
    )


def _edge_off_deg(jump: dict[str, Any]) -> float | None:
    """Return the median distance in elevation between the curve that was found and the true one."""
    curve = jump["where"]["curve"]
    if not curve:
        return None
    # The cable's azimuth counts from south, the report's from north.
    az_south = np.radians([point["az_deg"] - 180 for point in curve])
    el = np.array([point["el_deg"] for point in curve])
    return float(np.median(np.abs(el - rt32_edge_on_the_cable(az_south) / DEG)))
