"""What is measured of each set: scatter against Huber, splits of the nights, findings, few rows."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner import program
from pyport.examiner.real import huber, published
from pyport.examiner.real.sets import Recordings

#: Random half-splits for sigmas, and for findings, which take longer.
SPLITS, FINDING_SPLITS = 20, 5
#: Fewest nights of which halves are made; blocks of time where there is one night.
FEWEST_NIGHTS, BLOCKS = 4, 5
#: Rows of a random subset.
FEW = (15, 40)
#: Patience with so few rows [s]; they take half a second.
FEW_PATIENCE_S = 60.0
#: Readings for each coefficient below which nothing is left out: what remains fits itself.
LEAST_READINGS = 3
#: Share of resampled data in which a name must come back.
STABLE = 0.8


@dataclass(frozen=True)
class Row:
    """What came out of a set; None and NaN where it cannot be measured."""

    name: str
    rows: int
    nights: int
    #: `in_fit`, `in_fit_clipped`, `across`, `across_clipped`: scatter of `fit` over that of Huber
    #: least squares: in the fit, and cross-validated; plain and with residuals cut off at three
    #: sigmas.
    in_fit: float = math.nan
    in_fit_clipped: float = math.nan
    across: float = math.nan
    across_clipped: float = math.nan
    across_sigma: float = math.nan  #: error of `across`, from pointings drawn with replacement
    scheme: str = ""  #: what was left out
    #: `rms_z`, `rms_z_sigma`, `pairs`: of differences between halves of the nights over their
    #: sigmas, what that scatters by where all sigmas are right, and how many differences.
    rms_z: float = math.nan
    rms_z_sigma: float = math.nan
    pairs: int = 0
    #: `findings`, `worse`: what was found, as "effect (variant), verdict"; how many predict unseen
    #: data worse.
    findings: tuple[str, ...] = ()
    worse: int = 0
    total: tuple[float, float] | None = None  #: held-out rms before and after, of all findings
    unstable: int = 0  #: named findings that came back in less than four of five resamplings
    agreement: tuple[int, int] | None = None  #: names shared by halves of the nights, and all names
    below_rounding: int = 0  #: sigmas smaller than the rounding of the recordings allows
    #: What was published, what came out, and whether it did.
    checks: tuple[published.Check, ...] = ()
    #: `few`, `few_worse`, `few_refused`: random subsets of few rows, those whose total is worse,
    #: those without an answer.
    few: int = 0
    few_worse: int = 0
    few_refused: int = 0
    notes: tuple[str, ...] = field(default=())  #: what else is to be known


def measure(recordings: Recordings, subsets: int) -> Row:
    """Put a set to the program and return what came out."""
    rng = np.random.default_rng([0, zlib.crc32(recordings.name.encode())])
    nights = len(np.unique(recordings.night))
    found: dict[str, Any] = {"name": recordings.name, "rows": len(recordings), "nights": nights}
    notes = []
    table = recordings.file or recordings.table
    fit = program.fitted(table, _header(recordings), recordings.model)
    report = program.diagnosed(table, _header(recordings), recordings.model)
    refused = [one.why for one in (fit, report) if isinstance(one, program.Refused)]
    if recordings.file is not None and refused:
        said = refused[0].replace(f"{recordings.file.parent}/", "")
        notes.append(f"the file as published is refused: {said}")
        table = recordings.table
        fit = program.fitted(table, recordings.header, recordings.model)
        report = program.diagnosed(table, recordings.header, recordings.model)
    if isinstance(fit, program.Refused) or isinstance(report, program.Refused):
        why = next(one.why for one in (fit, report) if isinstance(one, program.Refused))
        return Row(**found, notes=(*notes, f"refused: {why}"))
    if (used := report["input"]["used"]) != len(recordings):
        notes.append(f"{used} of {len(recordings)} rows used")
    alike = program.fitted(recordings.table, recordings.header, recordings.model)
    if not isinstance(alike, program.Refused):
        found |= _in_fit(recordings, alike)
    found |= _across(recordings)
    found["below_rounding"] = below_rounding(recordings, fit)
    found |= of_findings(report)
    if nights >= FEWEST_NIGHTS and recordings.hour_angle is None:
        found |= _half_sigmas(recordings, rng)
        found["agreement"] = _agreement(recordings, rng)
    found["checks"] = published.checks(recordings, report, fit)
    if recordings.public and len(recordings) > FEW[0]:
        found |= few(recordings, rng, subsets)
    return Row(**found, notes=tuple(notes))


def _header(recordings: Recordings) -> dict[str, float | str]:
    """Return what a published file does not say itself."""
    return {} if recordings.file is not None else recordings.header


def coefficients(recordings: Recordings, fit: dict[str, Any]) -> huber.Coefficients:
    """Return the program's coefficients [arcsec] as the examiner's; those not determined are 0."""
    found = {str(group): np.zeros(len(recordings.names)) for group in np.unique(recordings.group)}
    for one in fit["parameters"]:
        group = "|".join(one["labels"]) if recordings.hour_angle is not None else ""
        if group in found and one["value"] is not None and one["name"] in recordings.names:
            found[group][recordings.names.index(one["name"])] = one["value"]
    return found


def _in_fit(recordings: Recordings, fit: dict[str, Any]) -> dict[str, float]:
    ours = huber.residuals(recordings, coefficients(recordings, fit))
    theirs = huber.residuals(recordings, huber.fit(recordings))
    return {
        "in_fit": huber.ratio(ours, theirs),
        "in_fit_clipped": huber.clipped(ours, theirs),
    }


def folds(recordings: Recordings) -> tuple[str, list[NDArray[np.bool_]]]:
    """Return what is left out, and which rows each time: nights, or blocks where there is one."""
    names = np.unique(recordings.night)
    if len(names) > 1:
        return "nights", [recordings.night == one for one in names]
    time = recordings.table.get("time_utc")
    order = np.arange(len(recordings)) if time is None else np.argsort(time, kind="stable")
    block = np.empty(len(recordings), dtype=int)
    block[order] = np.arange(len(recordings)) * BLOCKS // len(recordings)
    return "blocks", [block == n for n in range(BLOCKS)]


def _across(recordings: Recordings) -> dict[str, Any]:
    """Return scatter of what was left out of the fits."""
    readings = int(np.isfinite(recordings.offsets()).sum())
    if readings < LEAST_READINGS * len(recordings.names):
        return {"scheme": "none"}
    scheme, left_out = folds(recordings)
    shape = recordings.offsets().shape
    ours, theirs = np.full(shape, np.nan), np.full(shape, np.nan)
    for out in left_out:
        rest, held = recordings.take(np.flatnonzero(~out)), recordings.take(np.flatnonzero(out))
        if 2 * len(rest) < len(recordings.names):
            continue
        fit = program.fitted(rest.table, rest.header, rest.model)
        if isinstance(fit, program.Refused):
            continue
        ours[out] = huber.residuals(held, coefficients(rest, fit))
        theirs[out] = huber.residuals(held, huber.fit(rest))
    if not np.isfinite(ours).any():
        return {"scheme": "none"}
    return {
        "across": huber.ratio(ours, theirs),
        "across_clipped": huber.clipped(ours, theirs),
        "across_sigma": huber.ratio_sigma(ours, theirs),
        "scheme": scheme,
    }


def halves(
    recordings: Recordings, rng: np.random.Generator, count: int
) -> Iterator[tuple[Recordings, Recordings]]:
    """Yield random halves of the nights; each must have more rows than the model has terms."""
    names = np.unique(recordings.night)
    made = 0
    for _ in range(10 * count):
        first = np.isin(recordings.night, rng.permutation(names)[: len(names) // 2])
        if min(first.sum(), (~first).sum()) > 2 * len(recordings.names):
            yield recordings.take(np.flatnonzero(first)), recordings.take(np.flatnonzero(~first))
            made += 1
        if made == count:
            return


def _half_sigmas(recordings: Recordings, rng: np.random.Generator) -> dict[str, Any]:
    z: list[float] = []
    independent: list[float] = []
    for pair in halves(recordings, rng, SPLITS):
        both = [program.fitted(one.table, one.header, one.model) for one in pair]
        fits = [one for one in both if isinstance(one, dict)]
        if len(fits) == len(both):
            z += differences(*fits)
            independent += map(independent_of, fits)
    if not z:
        return {}
    return {
        "rms_z": float(np.sqrt(np.mean(np.square(z)))),
        "rms_z_sigma": float(1 / np.sqrt(2 * np.mean(independent))),
        "pairs": len(z),
    }


def independent_of(fit: dict[str, Any]) -> float:
    """Return how many independent numbers scatter as the squares of all coefficients together do.

    The variance of a sum of squares is twice the sum of the squared correlations (Satterthwaite
    1946, Biometrics Bulletin 2, 110): coefficients that go together count as one.
    """
    found = np.array(fit["correlation"]["matrix"], float)
    known = np.isfinite(np.diag(found))
    found = found[np.ix_(known, known)]
    return float(np.trace(found) ** 2 / np.sum(found**2))


def differences(first: dict[str, Any], second: dict[str, Any]) -> list[float]:
    """Return differences of the coefficients that both fits have over their combined sigma."""
    found = []
    theirs = {(one["name"], *one["labels"]): one for one in second["parameters"]}
    for one in first["parameters"]:
        other = theirs.get((one["name"], *one["labels"]))
        if other is None or None in {one["value"], other["value"], one["sigma"], other["sigma"]}:
            continue
        sigma = math.hypot(one["sigma"], other["sigma"])
        if sigma > 0:
            found.append((one["value"] - other["value"]) / sigma)
    return found


def below_rounding(recordings: Recordings, fit: dict[str, Any]) -> int:
    """Count sigmas below what readings rounded to their last digit could give."""
    if recordings.hour_angle is not None or recordings.step_arcsec == 0:
        return 0
    columns = recordings.columns()[np.isfinite(recordings.offsets())]
    inverse = np.linalg.pinv(columns.T @ columns)
    least = recordings.step_arcsec / math.sqrt(12) * np.sqrt(np.diag(inverse))
    bound = dict(zip(recordings.names, least.tolist(), strict=True))
    return sum(
        one["sigma"] is not None and one["sigma"] < bound.get(one["name"], 0.0)
        for one in fit["parameters"]
    )


def of_findings(report: dict[str, Any]) -> dict[str, Any]:
    """Return findings and how they predict what was held out."""
    findings = report["findings"] if report["mismatch"] else []
    worse = sum(_is_worse(one.get("heldout")) for one in findings)
    total = report["fit"].get("heldout") or {}
    before, after = (total.get(f"rms_{one}_arcsec") for one in ("before", "after"))
    names = []
    for one in findings:
        variant = f" ({one['variant']})" if one.get("variant") else ""
        names.append(f"{one['effect']}{variant}, {one['verdict']}")
    return {
        "findings": tuple(names),
        "worse": worse,
        "total": None if before is None or after is None else (before, after),
        "unstable": sum(one["verdict"] == "named" and _is_unstable(one) for one in findings),
    }


def _is_worse(heldout: dict[str, Any] | None) -> bool:
    """Tell whether what was held out is predicted worse with a finding than without."""
    if not heldout:
        return False
    before, after = heldout.get("rms_before_arcsec"), heldout.get("rms_after_arcsec")
    return before is not None and after is not None and after > before * (1 + 1e-9)


def _is_unstable(finding: dict[str, Any]) -> bool:
    stability = finding.get("stability")
    if not stability or not stability.get("draws"):
        return False
    return bool(stability["kept"] < STABLE * stability["draws"])


def _names(table: Recordings) -> set[str] | None:
    report = program.diagnosed(table.table, table.header, table.model)
    if isinstance(report, program.Refused):
        return None
    return {one["effect"] for one in report["findings"]} if report["mismatch"] else set()


def _agreement(recordings: Recordings, rng: np.random.Generator) -> tuple[int, int]:
    """Return how many names halves of the nights share, and how many there are."""
    shared = every = 0
    for pair in halves(recordings, rng, FINDING_SPLITS):
        first, second = (_names(one) for one in pair)
        if first is not None and second is not None:
            shared += len(first & second)
            every += len(first | second)
    return shared, every


def few(recordings: Recordings, rng: np.random.Generator, subsets: int) -> dict[str, int]:
    """Diagnose random subsets of few rows; count totals that predict worse than the model alone."""
    worse = refused = 0
    for _ in range(subsets):
        most = min(FEW[1], len(recordings))
        rows = rng.choice(len(recordings), rng.integers(FEW[0], most + 1), replace=False)
        some = recordings.take(np.sort(rows))
        report = program.diagnosed(some.table, some.header, some.model, FEW_PATIENCE_S)
        if isinstance(report, program.Refused):
            refused += 1
        else:
            worse += _is_worse(report["fit"].get("heldout"))
    return {"few": subsets, "few_worse": worse, "few_refused": refused}
