"""What a fit leaves, source by source and session by session, and recording by recording."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from typing import IO

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.fitting.fit import Fit

#: Labels that residuals are summed up by.
LABELS = ("source", "session")
#: More groups than this go into the JSON only.
MOST_PRINTED = 40


def by_label(fit: Fit, label: str) -> list[dict[str, object]]:
    """Return count, mean and rms of both axes for every value of a label, largest rms first.

    Arcseconds; outliers without weight do not count. Empty where there is no such label.
    """
    values = fit.recordings.label(label).astype(str)
    if len(np.unique(values)) < 2:
        return []
    groups: list[dict[str, object]] = []
    for value in np.unique(values):
        group: dict[str, object] = {label: str(value)}
        rows = (values[fit.stack.row] == value) & fit.noise.used
        for axis, is_y in (("xel", False), ("el", True)):
            left = fit.residual[rows & (fit.stack.is_y == is_y)] / ARCSEC
            group[f"{axis}_offsets"] = len(left)
            group[f"{axis}_mean_arcsec"] = float(left.mean()) if len(left) else None
            group[f"{axis}_rms_arcsec"] = float(np.sqrt(np.mean(left**2))) if len(left) else None
        groups.append(group)
    return sorted(groups, key=lambda group: -_rms(group))


def _rms(group: dict[str, object]) -> float:
    across, along = (group[f"{axis}_rms_arcsec"] for axis in ("xel", "el"))
    return math.hypot(*(one if isinstance(one, float) else 0.0 for one in (across, along)))


def text(fit: Fit) -> Iterator[str]:
    """Yield tables of the residuals by label, for labels with a handful of values."""
    for label in LABELS:
        groups = by_label(fit, label)
        if not groups or len(groups) > MOST_PRINTED:
            continue
        width = max(len(str(group[label])) for group in groups)
        yield ""
        yield f"residuals by {label}: offsets, mean and rms [arcsec] across and along elevation"
        for group in groups:
            cells = [_cell(group, axis) for axis in ("xel", "el")]
            yield f"  {group[label]!s:{max(width, 8)}s} {'   '.join(cells)}"


def _cell(group: dict[str, object], axis: str) -> str:
    number = group[f"{axis}_offsets"]
    mean, rms = group[f"{axis}_mean_arcsec"], group[f"{axis}_rms_arcsec"]
    if mean is None or rms is None:
        return f"{0:4d} {'':8s} {'':7s}"
    return f"{number:4d} {mean:+8.2f} {rms:7.2f}"


def write(fit: Fit, file: IO[str]) -> None:
    """Write a line for every measured offset: what is left of it, and its weight."""
    at = fit.recordings.at
    labels = [name for name in ("antenna", *LABELS) if name in at]
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["line", "axis", *labels, "az_deg", "el_deg", "residual_arcsec", "weight"])
    for n in np.lexsort((fit.stack.is_y, fit.stack.row)):
        row = fit.stack.row[n]
        writer.writerow(
            [
                int(fit.recordings.line[row]),
                "el" if fit.stack.is_y[n] else "xel",
                *(at.column(name)[row] for name in labels),
                f"{at.az[row] / DEG:.6f}",
                f"{at.el[row] / DEG:.6f}",
                f"{fit.residual[n] / ARCSEC:.3f}",
                f"{fit.weight[n]:.4f}",
            ]
        )
