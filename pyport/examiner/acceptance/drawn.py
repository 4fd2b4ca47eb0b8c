"""Drawn cases: how often silent, how often right, how often honestly at a loss."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.examiner.ideal import observer
from pyport.examiner.sealed.intervals import Rate
from pyport.examiner.sealed.judge import Verdict, judge, place, read_table
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.worlds.campaign import NOISES
from pyport.examiner.worlds.faults import UNCATALOGUED
from pyport.examiner.worlds.kinds import HIDEABLE
from pyport.progress import track

#: Cases without anything hidden, and of each uncatalogued cause.
NULLS, OF_UNCATALOGUED = 200, 8
#: How loud a cause is, how often each is drawn then, and the share that must come out.
LOUDNESS = ((0.5, 2, 0.95), (0.25, 2, 0.85))
#: Column or place that an uncatalogued cause must be found at; the others are anywhere in the sky.
_FOLLOWS = {"strange_column": "hydraulic_bar", "oscillation": "time"}


@dataclass(frozen=True)
class Line:
    """A figure, what was asked for, and whether it came out; None where it is shown only."""

    what: str
    value: str
    wanted: str
    passed: bool | None


@dataclass(frozen=True)
class _Task:
    spec: Spec
    seed: int


def lines(jobs: int, seed: int) -> Iterator[Line]:
    """Yield the figures of all drawn cases; `seed` is where their seeds begin."""
    specs = list(_specs())
    tasks = [_Task(spec, seed + n) for n, spec in enumerate(specs)]
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


def _solve(task: _Task) -> tuple[Verdict, float]:
    """Make a case, write what may be seen of it, diagnose that, and judge the report.

    With the verdict comes the chance that an ideal observer detects the cause.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    made = task.spec.make(task.seed)
    truth = {"spec": task.spec.as_json(), "seed": task.seed, "truth": made.truth}
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "recordings.csv"
        report = diagnosed(made, path)
        verdict = judge(str(task.seed), truth, {**report, "examined": {}})
        placed = place(read_table(path), report["findings"], made.truth["effects"])
    wanted = _FOLLOWS.get(task.spec.effect or "")
    if task.spec.group == "unknown" and verdict.first and wanted:
        told = report["findings"][0]["looks_like"] or ""
        verdict = _but(verdict, first=wanted in told)
    chance = 0.0 if made.truth["kind"] != "one" else observer.possible(report, made)
    return _but(verdict, place=placed), chance


def diagnosed(made: Any, path: Path, model: str | None = None) -> dict[str, Any]:  # noqa: ANN401
    """Return the report of a made case; what may be seen of it is written to `path`."""
    from pyport.examiner.sealed.files import write_recordings

    write_recordings(made, path)
    return reported(made, path, model)


def reported(made: Any, path: Path, model: str | None = None) -> dict[str, Any]:  # noqa: ANN401
    """Return the report of a made case that was written to `path` before."""
    from pyport.diagnosis.diagnose import diagnose
    from pyport.formats.models import load
    from pyport.recordings import read
    from pyport.report.made import report_of
    from pyport.report.typed import as_json

    asked = dict(zip(made.arguments[::2], made.arguments[1::2], strict=True))
    refit = None if asked.get("--refit", "all") == "all" else ()
    found = diagnose(read(path), load(model or asked.get("--model", "altaz")), refit=refit)
    report: dict[str, Any] = as_json(report_of(found))
    return report


def _but(verdict: Verdict, **changes: object) -> Verdict:
    from dataclasses import replace

    return replace(verdict, **changes)  # type: ignore[arg-type]


def _right(verdicts: Iterable[Verdict]) -> Rate:
    verdicts = list(verdicts)
    return Rate(sum(one.first for one in verdicts), len(verdicts))


def _silence(verdicts: list[Verdict]) -> Line:
    rate = Rate(sum(one.claimed for one in verdicts), len(verdicts))
    most = 0.05
    wanted = f"at most {100 * most:.0f} %"
    return Line("nothing hidden: any finding", str(rate), wanted, rate.hits <= most * rate.of)


def _at_least(what: str, rate: Rate, least: float) -> Line:
    return Line(what, str(rate), f"at least {100 * least:.0f} %", rate.hits >= least * rate.of)


def _missed(verdicts: Iterable[Verdict]) -> Iterator[Line]:
    """Yield a line for every cause that did not come out, with what was said instead."""
    for one in verdicts:
        if not one.first:
            why = f"p = {one.p_value:.2g}" if one.p_value is not None else "no p-value"
            said = f"{one.said} ({why})"
            yield Line(f"  {one.spec['effect']}, seed {one.case}", said, "shown", None)
