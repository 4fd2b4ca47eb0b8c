"""What was published of a set, and whether it came out.

Every kind of fact in published.toml is a function here: recordings, report, fit and the fact
give what came out in words, and whether that is what was published.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pyport.examiner import program, scores
from pyport.examiner.real.sets import Recordings
from pyport.examiner.scores import Array

Fact = dict[str, Any]
Report = dict[str, Any]
#: What came out, in words, and whether it is what was published.
Outcome = tuple[str, bool]


@dataclass(frozen=True)
class Check:
    """A published fact, what came out, and whether it did."""

    says: str
    found: str
    passed: bool


def checks(recordings: Recordings, report: Report, fit: Report) -> tuple[Check, ...]:
    """Return every fact of a set beside what came out."""
    return tuple(
        Check(fact["says"], *KINDS[fact["kind"]](recordings, report, fit, fact))
        for fact in recordings.facts
    )


def _step(recordings: Recordings, report: Report, _: Report, fact: Fact) -> Outcome:
    """Look for one step at the published moment, and give its size beside the published one."""
    steps = [one for one in report["findings"] if one["where"].get("since")]
    el = recordings.el
    x = np.mean(-fact["p10"] * np.cos(el) - fact["p11"] * np.sin(el))
    y = np.mean(fact["p10"] * np.sin(el) - fact["p11"] * np.cos(el))
    parts = [f"published {x:+.1f} across, {y:+.1f} along elevation"]
    near = False
    for one in steps:
        late_h = (_utc(one["where"]["since"]) - _utc(fact["when"])) / np.timedelta64(1, "h")
        both = {"xel", "el"} <= set(one["where"]["axes"])
        near = bool(abs(late_h) <= fact["within_h"]) and both
        sizes = ", ".join(f"{p['name'].partition('[')[0]} {_shown(p)}" for p in one["parameters"])
        parts.append(f"{one['effect']} {late_h:+.1f} h from it: {sizes}")
    return "; ".join(parts[::-1] if steps else ["no step", *parts]), len(steps) == 1 and near


def _utc(when: object) -> np.datetime64:
    return np.datetime64(str(when).replace(" ", "T").removesuffix("Z").removesuffix("+00:00"))


def _shown(parameter: Report) -> str:
    value, sigma = parameter["value"], parameter["sigma"]
    if value is None:
        return "not determined"
    return f"{value:.1f}" if sigma is None else f"{value:.1f} +- {sigma:.1f}"


def _only(_: Recordings, report: Report, __: Report, fact: Fact) -> Outcome:
    others = [one["effect"] for one in report["findings"] if one["effect"] not in fact["effects"]]
    return ", ".join(others) or "nothing else", not others


def _lacks(_: Recordings, report: Report, __: Report, fact: Fact) -> Outcome:
    names = [one["effect"] for one in report["findings"]]
    found = [one for one in names if one in fact["effects"]]
    return ", ".join(found) or "none", not found


def _rms_below(recordings: Recordings, _: Report, fit: Report, fact: Fact) -> Outcome:
    """Give the rms of each axis of the program's own coefficients."""
    left = recordings.offsets() - recordings.columns() @ _values(recordings.names, fit)
    x, y = np.sqrt(np.nanmean(left**2, axis=0))
    return f"rms {x:.1f} across, {y:.1f} along elevation", bool(max(x, y) < fact["most"])


def _values(names: tuple[str, ...], fit: Report) -> Array:
    found = {one["name"]: one["value"] or 0.0 for one in fit["parameters"]}
    return np.array([found.get(name, 0.0) for name in names])


def changes(report: Report, prefix: str) -> Iterator[tuple[str, float, float]]:
    """Yield label, size and sigma of every change whose coefficients begin with a name.

    The components that one label has count as one vector.
    """
    for one in report["findings"]:
        parts: dict[str, list[tuple[float, float]]] = {}
        for parameter in one["parameters"]:
            name, _, label = parameter["name"].partition("[")
            if name.startswith(prefix) and None not in {parameter["value"], parameter["sigma"]}:
                pair = (parameter["value"], parameter["sigma"])
                parts.setdefault(label.rstrip("]"), []).append(pair)
        for label, pairs in parts.items():
            size = math.hypot(*(value for value, _ in pairs))
            along = math.hypot(*(value * sigma for value, sigma in pairs))
            yield label, size, along / size if size else math.inf


def _change(_: Recordings, report: Report, __: Report, fact: Fact) -> Outcome:
    """Look for a change of the published size, within two sigmas."""
    found = sorted(
        changes(report, fact["parameter"]),
        key=lambda one: abs(one[1] - fact["arcsec"]) / one[2] if one[2] else math.inf,
    )
    if not found:
        return "not found", False
    label, size, sigma = found[0]
    text = f"{size:.1f} +- {sigma:.1f} ({label}), published {fact['arcsec']}"
    return text, abs(size - fact["arcsec"]) <= 2 * sigma


def _change_or_asked(recordings: Recordings, report: Report, fit: Report, fact: Fact) -> Outcome:
    """Look for a change of the published size, or for words that ask what would show it."""
    text, found = _change(recordings, report, fit, fact)
    if found:
        return text, True
    asked = next((one for one in texts(report) if re.search(fact["words"], one)), None)
    return asked or text, asked is not None


def texts(value: Any) -> Iterator[str]:  # noqa: ANN401 - whatever JSON holds
    """Yield every text of a report."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for one in value.values():
            yield from texts(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from texts(one)


def _says(_: Recordings, report: Report, fit: Report, fact: Fact) -> Outcome:
    """Look for whole words in some parts of the report, or in the warnings of the fit."""
    whole = re.compile(rf"(?<![\w-])({fact['words']})", re.IGNORECASE)
    places = [*(report.get(key) for key in fact["under"]), fit.get("warnings")]
    for one in texts(places):
        if whole.search(one):
            return one, True
    return "not said", False


def _silent(_: Recordings, report: Report, __: Report, fact: Fact) -> Outcome:
    """Expect no finding, words that say why, and limits of what would have been seen."""
    said = next((one for one in texts(report) if re.search(fact["words"], one)), None)
    limits = any(one is not None for one in report["detection_limit_arcsec"].values())
    text = f"{len(report['findings'])} findings; {said or 'no word of it'}"
    text += "; with limits" if limits else "; no limits"
    return text, not report["findings"] and said is not None and limits


def _no_number_above_data(recordings: Recordings, report: Report, _: Report, __: Fact) -> Outcome:
    """Compare every number of the findings in arcsec with the largest offset on the sky."""
    largest = float(np.nanmax(np.abs(recordings.offsets())))
    numbers = []
    for one in report["findings"]:
        numbers += [one[f"{key}_rms_arcsec"] for key in ("visible", "true")]
        numbers += [p["value"] for p in one["parameters"] if p["unit"] == "arcsec"]
    worst = max((abs(one) for one in numbers if one is not None), default=0.0)
    return f"at most {worst:.0f}, data {largest:.0f} arcsec", worst <= largest


def _first_rows(recordings: Recordings, _: Report, __: Report, fact: Fact) -> Outcome:
    some = recordings.take(np.arange(fact["rows"]))
    report = program.diagnosed(some.table, some.header, some.model)
    if isinstance(report, program.Refused):
        return f"refused: {report.why}", False
    total = report["fit"].get("heldout") or {}
    before, after = (total.get(f"rms_{one}_arcsec") for one in ("before", "after"))
    if before is None or after is None:
        return "nothing was held out", not report["findings"]
    names = ", ".join(one["effect"] for one in report["findings"]) or "nothing"
    return f"{names}; held out {before:.1f} to {after:.1f} arcsec", after <= before * (1 + 1e-9)


#: Columns of published terms that the classical model lacks: across, along.
_MORE: dict[str, Callable[[Recordings], tuple[Array | float, Array | float]]] = {
    "cot_e": lambda at: (0.0, 1 / np.tan(at.el)),
    "sin2a_cos2e": lambda at: (np.cos(at.el) * np.sin(2 * at.az) * np.cos(2 * at.el), 0.0),
}


def _sky_rms(recordings: Recordings, _: Report, __: Report, fact: Fact) -> Outcome:
    """Fit the published terms, given as a TPOINT model, and compare the rms on the sky.

    With equal weights, as what was published was fitted.
    """
    lines = ["published terms", f"T {len(recordings)} 0.0 0.0 0.0"]
    lines += [f"  {name} +0.0 1.0" for name in fact["terms"]]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "published.mod"
        file.write_text("\n".join([*lines, "END", ""]), encoding="utf-8")
        fit = program.fitted(recordings.table, recordings.header, str(file), "equal")
    if isinstance(fit, program.Refused):
        return f"refused: {fit.why}", False
    base = dict(zip(recordings.names, np.moveaxis(recordings.columns(), 2, 0), strict=True))
    left = recordings.offsets()
    for one in fit["parameters"]:
        name, sign = fact["terms"][one["name"]]
        if name in _MORE:
            column = scores.both(*_MORE[name](recordings), len(recordings))
        else:
            column = base[name]
        left = left - sign * (one["value"] or 0.0) * column
    before, after = (
        float(np.sqrt(np.sum(offsets**2) / len(recordings)))
        for offsets in (recordings.offsets(), left)
    )
    right = abs(after - fact["after"]) <= fact["within"]
    if "before" in fact:
        right &= abs(before - fact["before"]) <= fact["within"]
    return f"{before:.2f} to {after:.2f} arcsec", right


def _read(recordings: Recordings, _: Report, __: Report, ___: Fact) -> Outcome:
    """Compare the fit of the published file with that of the examiner's reading of it."""
    if recordings.file is None:
        return "cannot be compared", False
    theirs = program.fitted(recordings.file, model=recordings.model)
    ours = program.fitted(recordings.table, recordings.header, recordings.model)
    for one in (theirs, ours):
        if isinstance(one, program.Refused):
            return f"refused: {one.why}", False
    first, second = (
        recordings.columns() @ _values(recordings.names, one)
        for one in (theirs, ours)
        if isinstance(one, dict)
    )
    largest, apart = float(np.max(np.abs(second))), float(np.max(np.abs(first - second)))
    text = f"fitted offsets up to {largest:.0f} arcsec; the file as read differs by {apart:.1f}"
    return text, apart < 0.01 * largest


#: Kind of fact -> how it is looked for.
KINDS: dict[str, Callable[[Recordings, Report, Report, Fact], Outcome]] = {
    "step": _step,
    "only": _only,
    "lacks": _lacks,
    "rms_below": _rms_below,
    "change": _change,
    "change_or_asked": _change_or_asked,
    "says": _says,
    "silent": _silent,
    "no_number_above_data": _no_number_above_data,
    "first_rows": _first_rows,
    "sky_rms": _sky_rms,
    "read": _read,
}
