"""One answer held to one truth."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

Finding = dict[str, Any]
Cause = dict[str, Any]

#: A class of more names than this is no answer.
WIDEST_CLASS = 6


@dataclass(frozen=True)
class Verdict:
    """What one report was worth."""

    #: `case`, `group`, `spec`: which case it was and what it was made to be.
    case: str
    group: str
    spec: dict[str, Any]
    failed: str | None  #: why there is no report, or None
    claimed: bool  #: whether it claims any mismatch
    p_value: float | None  #: of a mismatch at all, as reported
    said: str  #: what the first finding names: an id, "unknown", or "nothing"
    verdict: str  #: "named", "ambiguous", "unknown", or "silent"
    width: int  #: how many names the first finding's class has
    #: `first`, `three`: whether the truth is in the class that comes first; among the first three.
    first: bool
    three: bool
    found: tuple[bool, ...]  #: for each hidden cause, whether any finding has it
    wrong: tuple[str, ...]  #: findings that mean nothing that is hidden
    #: Whether the first finding lists all that cannot be distinguished, and claims no one name.
    whole_class: bool
    #: Reported minus true over the reported sigma, for coefficients that truth knows, and the
    #: effect that each belongs to.
    pulls: tuple[tuple[str, str, float], ...] = ()
    #: Overlap of regions, distance of curves [deg], distance of moments [rows].
    place: dict[str, float] = field(default_factory=dict)
    #: Gained and gainable mean squares on data left out, in units of the noise's.
    skill: tuple[float, float] | None = None
    #: The chance that an ideal observer detects the cause.
    possible: float | None = None


def judge(case: str, truth: dict[str, Any], report: dict[str, Any]) -> Verdict:
    """Return what a report is worth; `truth` is the text that was sealed, read.

    Skill and place, which need the recordings themselves, are left empty.
    """
    causes: list[Cause] = truth["truth"]["effects"]
    findings: list[Finding] = report.get("findings", [])
    first = findings[:1]
    return Verdict(
        case=case,
        group=truth["spec"]["group"],
        spec=truth["spec"],
        failed=report["examined"].get("failed"),
        claimed=bool(report.get("mismatch") or findings),
        p_value=report.get("p_value"),
        said=first[0]["effect"] if first else "nothing",
        verdict=first[0]["verdict"] if first else "silent",
        width=len(first[0]["class"]) if first else 0,
        first=any(is_right(one, cause) for one in first for cause in causes),
        three=any(is_right(one, cause) for one in _first_three(findings) for cause in causes),
        found=tuple(any(is_right(one, cause) for one in findings) for cause in causes),
        wrong=tuple(one["effect"] for one in findings if _is_wrong(one, causes)),
        whole_class=any(_has_whole_class(one, cause) for one in first for cause in causes),
        pulls=tuple(pull for cause in causes for pull in _pulls(findings, cause)),
    )


def is_right(finding: Finding, cause: Cause) -> bool:
    """Tell whether a finding means a cause: its class holds it, and is not everything there is."""
    if finding["verdict"] == "unknown" and cause.get("or_unknown"):
        return True
    if cause["effect"] == "unknown":
        return bool(finding["verdict"] == "unknown")
    named = {finding["effect"], *finding["class"]}
    if finding["verdict"] == "unknown" or len(named) > WIDEST_CLASS:
        return False
    return cause["effect"] in named or finding["effect"] in cause["class"]


def _is_wrong(finding: Finding, causes: list[Cause]) -> bool:
    """Tell whether a finding means no hidden cause, nor what may be said beside one."""
    beside = {name for cause in causes for name in cause.get("beside", ())}
    return finding["effect"] not in beside and not any(is_right(finding, one) for one in causes)


def _has_whole_class(finding: Finding, cause: Cause) -> bool:
    """Tell whether a finding lists every name of a cause's class, and so claims none of them."""
    listed = {finding["effect"], *finding["class"]}
    ambiguous = finding["verdict"] == "ambiguous" and len(listed) <= WIDEST_CLASS
    return ambiguous and set(cause["class"]) <= listed


def _first_three(findings: list[Finding]) -> list[Finding]:
    """Return the first finding, what it says came next to it, and the findings after it."""
    ranked = []
    for finding in findings:
        ranked.append(finding)
        runner_up = (finding.get("evidence") or {}).get("runner_up")
        if runner_up:
            ranked.append({"effect": runner_up, "class": [runner_up], "verdict": "named"})
    return ranked[:3]


def _pulls(findings: list[Finding], cause: Cause) -> list[tuple[str, str, float]]:
    """Return (effect, parameter, pull) of what both sides give a number for.

    Of several findings of one name the strongest stands for it; the uncatalogued have no numbers,
    and the coefficients of another harmonic are others.
    """
    effect, k = cause["effect"], cause.get("facts", {}).get("k")
    meant = [one for one in findings if one["effect"] == effect != "unknown"][:1]
    other = re.compile(rf"k = (?!{k}\b)\d+")
    if k is not None and any(other.match(one.get("variant") or "") for one in meant):
        return []
    pulls = []
    for parameter in (each for one in meant for each in one.get("parameters", [])):
        # Only what nature fixes, or what truth knows under the same name, can be compared.
        known = cause["parameters"].get(parameter["name"], parameter.get("expected"))
        if known is not None and parameter.get("sigma"):
            pull = (parameter["value"] - known) / parameter["sigma"]
            pulls.append((effect, parameter["name"], float(pull)))
    return pulls


Table = dict[str, list[str]]
Mask = NDArray[np.bool_]


def read_table(path: Path) -> Table:
    """Return the columns of a recordings file as text."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    return dict(zip(rows[0], map(list, zip(*rows[1:], strict=True)), strict=True))


def numbers(table: Table, column: str) -> Array:
    """Return a column as numbers, NaN where it is blank."""
    return np.array([float(text) if text else np.nan for text in table[column]])


def inside(table: Table, region: list[dict[str, Any]]) -> Mask:
    """Return which rows lie in a region: all its intervals hold; azimuths are taken round."""
    mask = np.ones(len(table["el_deg"]), bool)
    for interval in region:
        column, low, high = interval["column"], interval["low"], interval["high"]
        if column not in table:
            return np.zeros_like(mask)
        value = numbers(table, column)
        low = -np.inf if low is None else low
        high = np.inf if high is None else high
        if column == "az_deg" and np.isfinite([low, high]).all() and abs(high - low) < 360:
            mask &= (value - low) % 360 <= (high - low) % 360
        else:
            mask &= (value >= low) & (value <= high)
    return mask


def overlap(found: Mask, true: Mask) -> float:
    """Return the rows in both over the rows in either."""
    either = int(np.sum(found | true))
    return float(np.sum(found & true) / either) if either else 0.0


def region_overlap(
    table: Table, finding: dict[str, Any], true: list[dict[str, Any]]
) -> float | None:
    """Return the overlap of a finding's region with the true one, counted in rows."""
    region = finding["where"].get("region")
    return overlap(inside(table, region), inside(table, true)) if region else None


def _subset_overlap(
    table: Table, finding: dict[str, Any], true: dict[str, list[str]]
) -> float | None:
    """Return the overlap of the rows that a finding's labels select with the true ones."""
    subset = finding["where"].get("subset")
    if not subset or not set(subset) <= set(table):
        return None

    def rows(labels: dict[str, list[str]]) -> Mask:
        chosen = [np.isin(table[column], names) for column, names in labels.items()]
        return np.asarray(np.all(chosen, axis=0))

    return overlap(rows(subset), rows(true))


def curve_distance_deg(finding: dict[str, Any], true: list[dict[str, float]]) -> float | None:
    """Return the median distance in elevation of two curves over the azimuths of the found one."""
    curve = finding["where"].get("curve")
    if not curve:
        return None
    known_az = np.array([point["az_deg"] for point in true])
    known_el = np.array([point["el_deg"] for point in true])
    az = np.array([point["az_deg"] for point in curve])
    el = np.array([point["el_deg"] for point in curve])
    expected = np.interp(az % 360, known_az, known_el, period=360)
    return float(np.median(np.abs(el - expected)))


def moment_rows(table: Table, finding: dict[str, Any], true: str) -> float | None:
    """Return how many recordings lie between a moment found and the true one."""
    since = finding["where"].get("since")
    if not since:
        return None
    times = np.array([_seconds(text) for text in table["time_utc"]])
    low, high = sorted((_seconds(since), _seconds(true)))
    return float(np.sum((times > low) & (times < high)))


def _seconds(text: str) -> float:
    return datetime.fromisoformat(text).timestamp()


def place(
    table: Table, findings: list[dict[str, Any]], causes: list[dict[str, Any]]
) -> dict[str, float]:
    """Return how well the first cause is placed and dated, in every way that the truth can say.

    The first finding that says such a place is held to it; where none does the
    overlap is nothing and the distance infinite.
    """
    if not causes:
        return {}
    where = causes[0]["where"]
    placed: dict[str, float] = {}
    if where.get("region"):
        region = (region_overlap(table, one, where["region"]) for one in findings)
        placed["region_iou"] = _first(region, 0.0)
    if where.get("curve"):
        curve = (curve_distance_deg(one, where["curve"]) for one in findings)
        placed["curve_deg"] = _first(curve, np.inf)
    if where.get("subset"):
        subset = (_subset_overlap(table, one, where["subset"]) for one in findings)
        placed["subset_iou"] = _first(subset, 0.0)
    if (period_s := causes[0].get("facts", {}).get("period_s")) is not None:
        periods = (
            parameter["value"] * 60 / period_s - 1
            for one in findings
            for parameter in one.get("parameters", [])
            if parameter["name"] == "period"
        )
        placed["period_off"] = abs(_first(periods, np.inf))
    if where.get("since"):
        since = (moment_rows(table, one, where["since"]) for one in findings)
        placed["moment_rows"] = _first(since, np.inf)
    return placed


def _first(values: Iterable[float | None], otherwise: float) -> float:
    return next((value for value in values if value is not None), otherwise)
