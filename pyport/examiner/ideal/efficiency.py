"""Efficiency: detections and right names of a tool over the detections of the ideal observer."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pyport.examiner import program
from pyport.examiner.acceptance.drawn import diagnosed, judged
from pyport.examiner.ideal import observer
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.worlds.kinds import HIDEABLE

ROWS = (60, 100, 150, 300, 600, 1200, 2400)
RHOS = (0.25, 0.5, 1.0)
#: In fewer possible detections than this a ratio says nothing.
FEWEST = 0.5
#: Causes that have a period, and by what share it may be off.
PERIODIC, NEAR = ("oscillation", "wandering_oscillation"), 0.03


@dataclass(frozen=True)
class Drawn:
    """Which case is meant: the cause, how loud, of how many rows, and the seed."""

    effect: str
    rho: float
    rows: int
    seed: int


def cases(
    effects: Sequence[str], rhos: Sequence[float], rows: Sequence[int], count: int, seed: int
) -> list[Drawn]:
    """Return `count` cases of every cause, loudness and number of rows, cheapest first."""
    return [
        Drawn(effect, rho, n, seed + 1000 * k + HIDEABLE.index(effect))
        for n in sorted(rows)
        for k in range(count)
        for rho in rhos
        for effect in effects
    ]


def examine(drawn: Drawn) -> dict[str, Any]:
    """Make a case, diagnose it, and return what was said beside what could have been."""
    spec = Spec("one", "one", drawn.effect, drawn.rho, drawn.rows)
    made = spec.make(drawn.seed)
    with tempfile.TemporaryDirectory() as name:
        report = diagnosed(made, Path(name) / "recordings.csv")
    verdict = judged(spec, drawn.seed, made, report)
    return vars(drawn) | {
        "program": program.version(),
        "detected": verdict.claimed,
        "named": verdict.first,
        "said": verdict.said,
        "gain": observer.gain(made),
        "possible": observer.possible(made),
        "period_error": period_error(report, made.truth["effects"]),
    }


def period_error(report: dict[str, Any], causes: Sequence[dict[str, Any]]) -> float | None:
    """Return by what share the period of the right finding is off; None where there is none."""
    true = next((one["facts"]["period_s"] for one in causes if "period_s" in one["facts"]), None)
    said = (p for one in report["findings"] for p in one["parameters"] if p["name"] == "period")
    found = next(said, None)
    return None if true is None or found is None else found["value"] * 60 / true - 1


def text(outcomes: Iterable[dict[str, Any]]) -> str:
    """Return both efficiencies against rows and loudness, and cause by cause."""
    outcomes = list(outcomes)
    lines = [_row("rows", "rho", "cases", "possible", "detected", "named", "efficiency", "naming")]
    cells = sorted({(one["rows"], one["rho"]) for one in outcomes})
    for rows, rho in cells:
        own = [one for one in outcomes if (one["rows"], one["rho"]) == (rows, rho)]
        lines.append(_row(str(rows), f"{rho:g}", *_figures(own)))
    lines.append("")
    for effect in dict.fromkeys(one["effect"] for one in outcomes):
        own = [one for one in outcomes if one["effect"] == effect]
        lines.append(f"{effect:24}" + _row("", "", *_figures(own)))
    return "\n".join([*lines, *_periods(outcomes)])


def _periods(outcomes: Sequence[dict[str, Any]]) -> list[str]:
    """Return a table of causes that have a period: how often it is found, and how well."""
    cells = [(one["effect"], one["rows"], one["rho"]) for one in outcomes]
    lines = []
    for effect, rows, rho in sorted({cell for cell in cells if cell[0] in PERIODIC}):
        own = [
            one for one, cell in zip(outcomes, cells, strict=True) if cell == (effect, rows, rho)
        ]
        errors = [abs(one["period_error"]) for one in own if one["period_error"] is not None]
        near = sum(error <= NEAR for error in errors)
        median = f"{100 * float(np.median(errors)):.2f} %" if errors else "-"
        named = sum(one["named"] for one in own)
        counts = (str(rows), f"{rho:g}", *map(str, (len(own), named, near)), median)
        lines.append(f"{effect:24}" + _row(*counts))
    if not lines:
        return []
    columns = ("rows", "rho", "cases", "named", f"within {100 * NEAR:g} %", "median")
    return ["", f"{'period':24}" + _row(*columns), *lines]


def _figures(outcomes: list[dict[str, Any]]) -> tuple[str, ...]:
    could = sum(one["possible"] for one in outcomes)
    detected, named = (sum(one[key] for one in outcomes) for key in ("detected", "named"))
    ratios = [f"{n / could:.2f}" if could >= FEWEST else "-" for n in (detected, named)]
    return str(len(outcomes)), f"{could:.1f}", str(detected), str(named), *ratios


def _row(*cells: str) -> str:
    return "".join(f"{cell:>11}" for cell in cells)
