"""Normal points as the cells of a file: means of what was summed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.columns import angle_of
from pyport.recordings.raw import Raw
from pyport.recordings.stream.cells import Cells

#: What the second pass sums, before the further columns.
SUMMED = (
    "rows",
    *(f"{what}_x" for what in ("readings", "weight", "sum", "squares", "outliers")),
    *(f"{what}_y" for what in ("readings", "weight", "sum", "squares", "outliers")),
    "az",
    "el",
    "time",
)


def as_raw(points: Cells, root: Path, meta: dict[str, str], *, places_only: bool = False) -> Raw:
    """Return normal points in the contract's columns, as lines numbered from 1.

    `points`: sums of the second pass; further columns are summed as `NAME:count`, `NAME:sum`, or
      `NAME:sine` and `NAME:cosine`.
    `root`: the data set, for errors.
    `meta`: header keys.
    `places_only`: whether the offsets do not matter: they are zero then.
    """
    of = dict(zip(points.sums, points.totals.T, strict=True))
    columns: dict[str, NDArray[Any]] = {
        "az_deg": of["az"] / of["rows"] / DEG,
        "el_deg": of["el"] / of["rows"] / DEG,
    }
    for axis, name in (("x", "xel"), ("y", "el")):
        mean, sigma = _mean(*(of[f"{what}_{axis}"] for what in ("weight", "sum", "squares")))
        if places_only:
            mean = np.zeros(len(points))
        columns[f"d_{name}_deg"], columns[f"sigma_{name}_deg"] = mean / DEG, sigma / DEG
    if of["time"].any():
        micro = np.rint(of["time"] / of["rows"] * 1e6).astype(np.int64)
        columns["time_utc"] = micro.astype("datetime64[us]")
    direction = points.directions()
    if direction.any():
        columns["scan_direction"] = direction
    for name in (one.removesuffix(":count") for one in points.sums if one.endswith(":count")):
        columns[name] = _further(name, of)
    for n, label in enumerate(points.label_names):
        columns[label] = np.array([words[n] for words in points.names], np.str_)[points.label]
    return Raw(root, meta, 1, columns, np.arange(1, len(points) + 1))


def _mean(weight: Array, total: Array, squares: Array) -> tuple[Array, Array]:
    """Return weighted means and their errors; NaN where nothing has weight, or one alone."""
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(weight > 0, total / weight, np.nan)
        variance = np.maximum(squares / weight - mean**2, 0.0) / (weight - 1)
        sigma = np.sqrt(np.where((weight > 1) & (variance > 0), variance, np.nan))
    return mean, sigma


def _further(name: str, of: dict[str, Array]) -> Array:
    """Return the mean of a further column, in the unit that its name says; NaN where none is."""
    count = of[f"{name}:count"]
    with np.errstate(invalid="ignore", divide="ignore"):
        if f"{name}:sum" in of:
            return np.asarray(of[f"{name}:sum"] / count)
        angle = angle_of(name)
        unit = 1.0 if angle is None else angle[1]
        direction = np.arctan2(of[f"{name}:sine"], of[f"{name}:cosine"]) % (2 * np.pi)
        return np.where(count > 0, direction / unit, np.nan)
