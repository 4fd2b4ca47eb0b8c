"""Say in text and JSON how the ports compare with the published Fortran."""

from __future__ import annotations

import dataclasses
from typing import Any

from pyport.parity.compare import Comparison
from pyport.parity.promise import PROMISED_ULP
from pyport.parity.run import Parity, run
from pyport.parity.ulp import UNLIKE

HEADINGS = (
    f"{'':18} {'legacy port':>22}   {'vectorised port':>51}\n"
    f"{'routine':8} {'output':9} {'differing':>10} {'worst ulp':>11}   "
    f"{'median':>8} {'p99':>8} {'worst ulp':>13} {'arcsec*':>8} {'beyond**':>8}"
)
FOOTNOTE = (
    " * worst on the sky; from here on without what the ledger of deviations explains\n"
    "** worst ulp beyond the oracle's own spread (REAL*8 throughout, or an input one ulp away);\n"
    "   promised: " + ", ".join(map(str, PROMISED_ULP)) + " row by row"
)


def text(parity: Parity) -> str:
    """Return a table a person reads: worst distances by routine and output."""
    sizes = ", ".join(f"{number:,} {name}" for name, number in parity.points.items())
    lines = [f"Against {oracle_text(parity)}", f"Points: {sizes}", "", HEADINGS]
    held = parity.held
    for legacy, pointing, sky, beyond in zip(
        held.legacy, held.pointing, held.sky, held.beyond, strict=True
    ):
        lines.append(
            f"{legacy.routine:8} {legacy.output:9} {legacy.differing:10,} {ulp(legacy.most):>11}   "
            f"{ulp(pointing.quantile(0.5)):>8} {ulp(pointing.quantile(0.99)):>8} "
            f"{ulp(pointing.most):>13} {sky.arcsec:8.4f} {ulp(beyond.most):>8}"
        )
    lines += [FOOTNOTE, "", verdict(parity), promise_verdict(parity)]
    lines += [f"legacy: {comparison}" for comparison in held.legacy if comparison.differing]
    if not parity.promise_kept:
        lines += [f"vectorised: {comparison}" for comparison in held.beyond if comparison.differing]
    return "\n".join(lines) + "\n"


def oracle_text(parity: Parity) -> str:
    """Return which oracle was asked, and what made it."""
    made_by = f"{parity.provenance['compiler']}, {parity.provenance['flags']}"
    if parity.source == "live":
        return f"the compiled oracle ({made_by})"
    return f"the oracle's stored answers ({made_by}; {parity.provenance['libc']})"


def verdict(parity: Parity) -> str:
    """Say in one sentence whether the legacy port is the published program."""
    if parity.bit_for_bit:
        return (
            "The legacy port equals the published program bit for bit, "
            "at all 51,395 points of the table too."
        )
    return (
        f"The legacy port is NOT the published program: "
        f"{sum(c.differing for c in parity.held.legacy):,} answers differ, and "
        f"{parity.table_azimuths_differing} of the table's 541 azimuths."
    )


def promise_verdict(parity: Parity) -> str:
    """Say in one sentence whether the vectorised port keeps its promise."""
    explained = ", ".join(f"{name} {n:,}" for name, n in parity.held.explained.items() if n)
    return (
        f"The vectorised port {'keeps' if parity.promise_kept else 'BREAKS'} its promise; "
        f"the ledger explains {sum(parity.held.explained.values()):,} answers"
        + (f" ({explained})." if explained else ".")
    )


def as_json(parity: Parity) -> dict[str, Any]:
    """Return the same as plain data."""
    return {
        "schema": "pyport.parity/1",
        "source": parity.source,
        "provenance": parity.provenance,
        "points": parity.points,
        "bit_for_bit": parity.bit_for_bit,
        "promise_kept": parity.promise_kept,
        "table_azimuths_differing": parity.table_azimuths_differing,
        "legacy": [_comparison(c) for c in parity.held.legacy],
        "pointing": [_comparison(c) for c in parity.held.pointing],
        "pointing_outside_ledger": [_comparison(c) for c in parity.held.sky],
        "pointing_beyond_spread": [_comparison(c) for c in parity.held.beyond],
        "explained": dict(parity.held.explained),
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
        "max_sky_arcsec": comparison.arcsec,
        "worst": comparison.worst and dataclasses.asdict(comparison.worst),
    }


def ulp(distance: int) -> str:
    """Return a distance as a cell of the table."""
    return "unlike" if distance == UNLIKE else f"{distance:,}"


def summary(random_points: int = 5000) -> str:
    """Return the short account of parity that the demonstration prints."""
    return text(run(random_points))
