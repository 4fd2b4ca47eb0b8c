"""Against what residuals are drawn: the sky, the hour angle, and every other column that varies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array
from pyport.columns import SPELLED, shown
from pyport.page.picture import Column, Layer
from pyport.recordings.schema import Recordings

#: Bins of equal count that show whether residuals follow a column.
BINS = 12
#: Labels with more values than this are no axis of a panel.
MOST_LABELS = 40
#: Numbers that take no more values than this are drawn as labels are.
FEW_VALUES = 8
#: So many columns beside the sky are kept, the ones with the most structure.
MOST_COLUMNS = 12

#: How regions spell a column -> the column of a panel.
_NAMED = {written: name for name, written in SPELLED.items()}


def columns(
    recordings: Recordings, layers: Sequence[Layer], residuals: Sequence[Array]
) -> tuple[Column, ...]:
    """Return the columns to draw residuals against.

    `recordings`: where, when and in which conditions.
    `layers`: the effects found; the stretches they are confined to come with the columns.
    `residuals`: residuals on each axis, shape (n,) each; what they follow most comes first.
    """
    at = recordings.at
    az, regions = _azimuth(at.az / DEG, _regions("az", layers))
    found = [
        Column("az", "azimuth", "deg", az, regions),
        Column("el", "elevation", "deg", at.el / DEG, _regions("el", layers)),
    ]
    if "hour_angle" in at:
        hours = np.asarray(at.column("hour_angle"), float) / HOUR
        hours = (hours + 12) % 24 - 12
        if np.isfinite(hours).any():
            regions = _regions("hour_angle", layers)
            found.append(Column("hour_angle", "hour angle", "h", hours, regions))
    skipped = {"time", "order", "hour_angle", *recordings.meta.get("bookkeeping", "").split()}
    others = [
        _column(name, values, layers) for name, values in at.columns.items() if name not in skipped
    ]
    kept = [one for one in others if _varies(one)]
    kept.sort(key=lambda one: (not one.regions, -_structure(one, residuals), one.name))
    return (*found, *kept[:MOST_COLUMNS])


def _column(name: str, values: NDArray[np.generic], layers: Sequence[Layer]) -> Column:
    label, unit, scale = shown(name)
    regions = _regions(name, layers)
    if values.dtype.kind not in "fiub":
        return Column(name, label, unit, values.astype(str), regions)
    numbers = np.asarray(values, float) / scale
    told = np.unique(numbers[np.isfinite(numbers)])
    if len(told) > FEW_VALUES or regions:
        return Column(name, label, unit, numbers, regions)
    signed = "+g" if told.min(initial=0) < 0 else "g"
    words = {value: format(value, signed) for value in told}
    texts = [words.get(value, "unknown") for value in numbers.tolist()]
    return Column(name, label, unit, np.array(texts, np.str_), regions)


def _azimuth(
    az: Array, regions: tuple[tuple[float, float, int], ...]
) -> tuple[Array, tuple[tuple[float, float, int], ...]]:
    """Return azimuths [deg] about the south or, where that tears them apart less, about the north.

    Stretches that the new zero cuts come back as two.
    """
    about_south = az % 360
    about_north = (az + 180) % 360 - 180
    first = -180.0 if np.ptp(about_north) < 0.8 * np.ptp(about_south) else 0.0
    parts = []
    for low, high, layer in regions:
        start = (low - first) % 360 + first
        # A stretch across the north may come as from 300 to 7 deg.
        stop = start + (360.0 if high - low >= 360 else (high - low) % 360)
        parts.append((start, min(stop, first + 360), layer))
        if stop > first + 360:
            parts.append((first, stop - 360, layer))
    return (about_north if first else about_south), tuple(parts)


def _regions(name: str, layers: Sequence[Layer]) -> tuple[tuple[float, float, int], ...]:
    """Return where the layers are confined to in a column."""
    return tuple(
        (one.low, one.high, n)
        for n, layer in enumerate(layers)
        for one in layer.region
        if _NAMED.get(one.column, one.column) == name
    )


def _varies(column: Column) -> bool:
    """Tell whether a column has more than one value and, if it holds labels, not too many."""
    if column.values.dtype.kind == "U":
        return 1 < len(np.unique(column.values)) <= MOST_LABELS
    known = column.values[np.isfinite(column.values.astype(float))]
    return 2 * len(known) >= len(column.values) and len(np.unique(known)) > 1


def _structure(column: Column, residuals: Sequence[Array]) -> float:
    """Return the largest share of the residuals' variance that a column's bins explain."""
    shares = []
    for residual in residuals:
        rows = np.isfinite(residual)
        if column.values.dtype.kind != "U":
            rows = rows & np.isfinite(column.values.astype(float))
        if rows.sum() > 2 * BINS:
            shares.append(explained(column.values[rows], residual[rows]))
    return max(shares, default=0.0)


def explained(values: NDArray[np.generic], residual: Array) -> float:
    """Return the share of the variance of residuals that bins of a column explain.

    What bins explain by chance is taken off; at most 1, about 0 for nothing.
    """
    order, codes = np.unique(values, return_inverse=True)
    if len(order) > BINS and values.dtype.kind != "U":
        edges = np.quantile(values.astype(float), np.linspace(0, 1, BINS + 1)[1:-1])
        codes = np.searchsorted(edges, values.astype(float))
    limit = 5 * float(np.median(np.abs(residual))) or np.inf
    clipped = np.clip(residual, -limit, limit)
    count = np.bincount(codes)
    mean = np.bincount(codes, clipped) / np.maximum(count, 1)
    total = float(np.var(clipped))
    if total <= 0:
        return 0.0
    bins, n = int((count > 0).sum()), len(residual)
    left = float(np.mean((clipped - mean[codes]) ** 2)) * n / max(n - bins, 1)
    return 1 - left / (total * n / (n - 1))
