"""Where a report says that a mismatch is, held to where it was put."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

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
    """Return how well the first cause is placed, in every way that the truth can say.

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
    if where.get("since"):
        since = (moment_rows(table, one, where["since"]) for one in findings)
        placed["moment_rows"] = _first(since, np.inf)
    return placed


def _first(values: Iterable[float | None], otherwise: float) -> float:
    return next((value for value in values if value is not None), otherwise)
