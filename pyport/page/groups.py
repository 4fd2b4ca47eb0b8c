"""What is left of each source and each session: a table of both axes, before and after."""

from __future__ import annotations

import numpy as np

from pyport.page.markup import Markup, table, tag
from pyport.page.picture import Picture, Side

#: Labels that residuals are summed up by, and how many values of one are listed.
LABELS = ("source", "session")
MOST = 60


def by_label(picture: Picture) -> list[Markup]:
    """Return a folded table for each label of several values, the largest rms first."""
    found = []
    for label in LABELS:
        values = picture.labels.get(label)
        if values is None:
            continue
        names = np.unique(values)
        if len(names) > 1:
            found.append(_table(picture, label, values, names))
    return found


def _table(picture: Picture, label: str, values: np.ndarray, names: np.ndarray) -> Markup:
    scale, unit = picture.unit
    sides = picture.sides()
    heads, rows = [label, "recordings"], []
    for axis, _ in sides:
        heads += [f"{axis}: rms [{unit}]", "mean after" if picture.layers else "mean"]
    for name in names:
        mine = values == name
        sizes = [_figures(side, mine, scale) for _, side in sides]
        worst = max(size[0] for size in sizes)
        cells = [text for size in sizes for text in size[1:]]
        rows.append((worst, [str(name) or "none", str(int(mine.sum())), *cells]))
    rows.sort(key=lambda row: -row[0])
    more = f", the {MOST} largest" if len(rows) > MOST else ""
    return tag(
        "details",
        tag("summary", f"By {label}: {len(names)} of them{more}"),
        table(heads, [cells for _, cells in rows[:MOST]], len(heads) - 1),
    )


def _figures(side: Side, rows: np.ndarray, scale: float) -> tuple[float, str, str]:
    """Return the rms after, both rms in words, and the mean after in words."""
    counted = rows & (side.share > 0) & np.isfinite(side.before)
    if not counted.any():
        return 0.0, "", ""
    sizes = [
        float(np.sqrt(np.mean(one[counted] ** 2))) / scale for one in (side.before, side.after)
    ]
    told = " → ".join(f"{size:.3g}" for size in sizes) if side.layers else f"{sizes[0]:.3g}"
    return sizes[-1], told, f"{float(np.mean(side.after[counted])) / scale:+.2f}"
