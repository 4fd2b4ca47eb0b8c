"""Say in text and JSON how the ports compare with the published Fortran."""

from __future__ import annotations

import dataclasses
from typing import Any

from pyport.parity.compare import Comparison
from pyport.parity.run import Parity, run
from pyport.parity.ulp import UNLIKE

HEADINGS = (
    f"{'routine':8} {'output':9} {'differing':>10} {'worst ulp':>11}   "
    f"{'median':>8} {'p99':>8} {'worst ulp':>10}"
)


def text(parity: Parity) -> str:
    """Return a table a person reads: worst distances by routine and output."""
    made_by = f"{parity.provenance['compiler']}, {parity.provenance['flags']}"
    where = {
        "live": f"the compiled oracle ({made_by})",
        "stored": f"the oracle's stored answers ({made_by}; {parity.provenance['libc']})",
    }[parity.source]
    points = ", ".join(f"{number:,} {name}" for name, number in parity.points.items())
    lines = [
        f"Against {where}",
        f"Points: {points}",
        "",
        f"{'':8} {'':9} {'legacy port':>22}   {'vectorised port':>28}",
        HEADINGS,
    ]
    for i, legacy in enumerate(parity.legacy):
        row = f"{legacy.routine:8} {legacy.output:9} {legacy.differing:10,} {ulp(legacy.most):>11}"
        if parity.pointing:
            other = parity.pointing[i]
            row += f"   {ulp(other.quantile(0.5)):>8} {ulp(other.quantile(0.99)):>8}"
            row += f" {ulp(other.most):>10}"
        lines.append(row)
    lines += ["", verdict(parity)]
    lines += [str(comparison) for comparison in parity.legacy if comparison.differing]
    return "\n".join(lines) + "\n"


def verdict(parity: Parity) -> str:
    """Say in one sentence whether the legacy port is the published program."""
    if parity.holds:
        return (
            "The legacy port equals the published program bit for bit, "
            "at all 51,395 points of the table too."
        )
    return (
        f"The legacy port is NOT the published program: "
        f"{sum(c.differing for c in parity.legacy):,} answers differ, and "
        f"{parity.table_azimuths_differing} of the table's 541 azimuths."
    )


def as_json(parity: Parity) -> dict[str, Any]:
    """Return the same as plain data."""
    return {
        "schema": "pyport.parity/1",
        "source": parity.source,
        "provenance": parity.provenance,
        "points": parity.points,
        "holds": parity.holds,
        "table_azimuths_differing": parity.table_azimuths_differing,
        "legacy": [_comparison(c) for c in parity.legacy],
        "pointing": parity.pointing and [_comparison(c) for c in parity.pointing],
    }


def _comparison(comparison: Comparison) -> dict[str, Any]:
    return {
        "routine": comparison.routine,
        "output": comparison.output,
        "points": comparison.points,
        "differing": comparison.differing,
        "median_ulp": comparison.quantile(0.5),
        "p99_ulp": comparison.quantile(0.99),
        "max_ulp": comparison.most,
        "worst": comparison.worst and dataclasses.asdict(comparison.worst),
    }


def ulp(distance: int) -> str:
    """Return a distance as a cell of the table."""
    return "unlike" if distance == UNLIKE else f"{distance:,}"


def summary(random_points: int = 5000) -> str:
    """Return the short account of parity that the demonstration prints."""
    return text(run(random_points))
