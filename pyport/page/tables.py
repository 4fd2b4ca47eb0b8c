"""Coefficients, their correlations, and the candidates that competed, as tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import decimals
from pyport.models.complete import CHANGE, ENTER, IN_FILE
from pyport.page.markup import Markup, chance, scrolled, table, tag
from pyport.page.picture import Picture, Side
from pyport.page.sections import CUT, section
from pyport.page.story import Row, Story, Turn

#: A heat map of more names has no numbers in its cells.
FINE = 16
#: With so many groups a table has a row for each group, and a column for each coefficient.
MANY_GROUPS = 4


def parameters(story: Story) -> Markup | None:
    """Return the table of coefficients and the heat map of their correlations."""
    if not story.rows:
        return None
    groups = list(dict.fromkeys(row.group for row in story.rows))
    several = len([group for group in groups if group]) >= MANY_GROUPS
    whole = [row for row in story.rows if not (several and row.group)]
    split = [row for row in story.rows if several and row.group]
    parts = [_plain("Coefficients", _listed(whole))] if whole else []
    heat = _heat(story)
    side = tag("div", *parts, heat, class_="split")
    return section(
        "parameters",
        "Parameters",
        "Values with one-sigma errors, all fitted together; what was found stands in bold.",
        side,
        _plain("Coefficients of each", _by_group(split)) if split else None,
    )


def _plain(title: str, inside: Markup) -> Markup:
    return tag("div", tag("h3", title), inside, class_="plain")


def _listed(rows: Sequence[Row]) -> Markup:
    grouped = any(row.group for row in rows)
    has_before = any(row.before is not None for row in rows)
    against = [IN_FILE, CHANGE] if has_before else []
    numeric = {ENTER, "sigma", "value / sigma", *against}
    of = ["of"] if grouped else []
    names = ["coefficient", *of, ENTER, "sigma", "unit", *against, "value / sigma"]

    def cells(row: Row) -> list[str]:
        name = [row.name.replace("_", " "), *([row.group] if grouped else [])]
        if row.value is None:
            return [*name, "not determined", "", row.unit, *("" for _ in against), ""]
        digits = 3 if row.sigma is None else decimals(row.sigma, 9)
        sigma = "" if row.sigma is None else f"{row.sigma:.{digits}f}"
        size = f"{abs(row.value) / row.sigma:.1f}" if row.sigma else ""
        old = row.before or 0.0
        change = _signed(row.value - old, digits)
        moved = [_signed(old, digits), change if change[0] == "−" else f"+{change}"]
        moved = moved[: len(against)]
        return [*name, _signed(row.value, digits), sigma, row.unit, *moved, size]

    def line(row: Row) -> Markup:
        named = zip(names, cells(row), strict=True)
        inside = (tag("td", cell, class_="n" if name in numeric else None) for name, cell in named)
        return tag("tr", *inside, class_="found" if row.found else None)

    heads = [tag("th", name, class_="n" if name in numeric else None) for name in names]
    return scrolled(heads, [line(row) for row in rows[:CUT]])


def _by_group(rows: Sequence[Row]) -> Markup:
    """Return one line for each group, such as an antenna, and a column for each coefficient."""
    names = list(dict.fromkeys((row.name, row.unit) for row in rows))
    of_group: dict[str, dict[tuple[str, str], Row]] = {}
    for row in rows:
        of_group.setdefault(row.group, {})[row.name, row.unit] = row
    heads = [tag("th", "of")]
    heads += [tag("th", f"{name.replace('_', ' ')} [{unit}]", class_="n") for name, unit in names]
    body = [
        tag("tr", tag("td", group), *(_value(found.get(name)) for name in names))
        for group, found in list(of_group.items())[:CUT]
    ]
    return scrolled(heads, body)


def _value(row: Row | None) -> Markup:
    if row is None:
        return tag("td", "", class_="n")
    if row.value is None:
        return tag("td", "not determined", class_="n")
    digits = 3 if row.sigma is None else decimals(row.sigma, 9)
    text = _signed(row.value, digits)
    if row.sigma is not None:
        text += f" ± {row.sigma:.{digits}f}"
    return tag("td", tag("b", text) if row.found else text, class_="n")


def _signed(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".replace("-", "−")


def _heat(story: Story) -> Markup | None:
    names, matrix = story.correlation
    if len(names) < 2:
        return None
    words = [name.replace("_", " ") for name in names]
    body = [
        tag(
            "tr",
            tag("th", name, scope="row"),
            *(_cell(value, f"{name} and {words[k]}: {value:+.3f}") for k, value in enumerate(row)),
        )
        for name, row in zip(words, matrix, strict=True)
    ]
    heads = [tag("td"), *(tag("th", name, scope="col") for name in words)]
    condition = story.condition
    said = "" if condition is None else f"Condition number {condition:.3g}. "
    return tag(
        "div",
        tag("h3", "Correlations"),
        tag("p", said + "In hundredths: orange together, blue against each other.", class_="how"),
        scrolled(heads, body, "heat" if len(names) <= FINE else "heat fine"),
        class_="plain",
    )


def _cell(value: float, title: str) -> Markup:
    size = min(1.0, abs(value))
    kind = "p" if value > 0 else "m"
    strong = " strong" if size > 0.6 else ""
    text = str(round(100 * value)).replace("-", "−")
    return tag("td", text, class_=f"{kind}{strong}", style=f"--r:{100 * size:.0f}%", title=title)


def candidates(story: Story) -> Markup | None:
    """Return, turn by turn, what competed and how it did."""
    if not story.turns:
        return None
    parts = [_turn(n, one) for n, one in enumerate(story.turns, 1)]
    return section(
        "candidates",
        "What competed",
        "In each turn every effect of the catalogue was tried with the model refitted. The gain is "
        "in BIC: what it explains less what its coefficients cost. In orange, the class that these "
        "recordings cannot distinguish.",
        tag("div", *parts, class_="split"),
    )


def _turn(n: int, turn: Turn) -> Markup:
    most = max((one.delta_bic for one in turn.rivals), default=1.0)
    body = [
        tag(
            "tr",
            tag("td", one.effect.replace("_", " "), f", {one.variant}" if one.variant else None),
            tag("td", one.scope),
            tag("td", str(one.coefficients), class_="n"),
            tag("td", _signed(one.delta_bic, 0), class_="n"),
            tag(
                "td",
                tag(
                    "i",
                    class_="worth",
                    style=f"width:{100 * max(one.delta_bic, 0) / max(most, 1e-9):.1f}%",
                ),
                class_="wide",
            ),
            class_="member" if one.member else None,
        )
        for one in turn.rivals
    ]
    names = ("effect", "one for", "coefficients", "gain", "")
    heads = [
        tag("th", name, class_="n" if name in ("coefficients", "gain") else None) for name in names
    ]
    return tag(
        "div",
        tag("h3", f"Turn {n}: {turn.winner.replace('_', ' ')}"),
        tag("p", f"chance that noise alone looks like this: {chance(turn.p_value)}", class_="how"),
        scrolled(heads, body),
        class_="plain",
    )


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
    text = " → ".join(f"{size:.3g}" for size in sizes) if side.layers else f"{sizes[0]:.3g}"
    return sizes[-1], text, f"{float(np.mean(side.after[counted])) / scale:+.2f}"
