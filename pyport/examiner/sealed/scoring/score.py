"""The score: every row of the proof's table, from the verdicts on all cases."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pyport.examiner.sealed.protocol import THRESHOLDS
from pyport.examiner.sealed.record.files import count
from pyport.examiner.sealed.scoring.judge import Verdict
from pyport.examiner.sealed.scoring.overall import Row, at_most, of_all


def table(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return the rows that these verdicts can fill."""
    by_group: dict[str, list[Verdict]] = {}
    for one in verdicts:
        by_group.setdefault(one.group, []).append(one)
    rows: list[Row] = []
    for group, fill in _FILL.items():
        if group in by_group:
            rows += fill(by_group[group])
    return [*rows, *of_all(verdicts)]


def _at_least(what: str, outcomes: list[bool], key: str) -> Row:
    least, rate = THRESHOLDS[key], count(outcomes)
    return Row(what, str(rate), f"at least {100 * least:.0f} %", rate.value >= least)


def _shown(what: str, outcomes: list[bool], needed: str = "shown") -> Row:
    return Row(what, str(count(outcomes)), needed, None)


def _claims(what: str, verdicts: list[Verdict], key: str) -> Row:
    return at_most(f"{what}: claims anything", count([one.claimed for one in verdicts]), key)


def _null(verdicts: list[Verdict]) -> list[Row]:
    rows = [_claims("nothing hidden", verdicts, "null_claims_most")]
    for key, what in _CIRCUMSTANCES.items():
        some = [one for one in verdicts if one.spec[key] is not None]
        rows += _curve(f"nothing hidden, {what}", key, _detected, "shown")(some)
    return rows


#: What cases without anything hidden differ in.
_CIRCUMSTANCES = {
    "noise": "{} noise",
    "sky": "sky: {}",
    "rows": "{} rows",
    "mount": "{} mount",
    "model": "behind {}",
    "little": "file with the {} alone",
}


def _curve(what: str, key: str, outcome: Callable[[Verdict], bool], needed: str = "curve") -> Any:  # noqa: ANN401
    """Return what gives a row for each value of a key of the specifications."""

    def fill(verdicts: list[Verdict]) -> list[Row]:
        outcomes: dict[Any, list[bool]] = {}
        for one in verdicts:
            outcomes.setdefault(one.spec[key], []).append(outcome(one))
        order = outcomes if needed == "shown" else sorted(outcomes)
        return [_shown(what.format(value), outcomes[value], needed) for value in order]

    return fill


def _detected(one: Verdict) -> bool:
    return one.claimed


def _right(one: Verdict) -> bool:
    return one.first


def _one(verdicts: list[Verdict]) -> list[Row]:
    loud = [one for one in verdicts if one.spec["rho"] >= THRESHOLDS["one_rho_least"]]
    wrong = [one.verdict == "named" and not one.first for one in loud]
    widths = [one.width for one in loud if one.width]
    width = f"mean {np.mean(widths):.2f}" if widths else "none"
    return [
        *_curve("one cause, rho {:g}: detected", "rho", _detected)(verdicts),
        _at_least("one cause: class right first", [one.first for one in loud], "one_first_least"),
        _at_least("one cause: in the first three", [one.three for one in loud], "one_three_least"),
        _at_least(
            "one cause: class right first and nothing wrong beside it",
            [one.first and not one.wrong for one in loud],
            "one_clean_least",
        ),
        _shown("one cause: one confident wrong name", wrong),
        Row("one cause: names in the first class", width, "shown", None),
    ]


def _mounts(verdicts: list[Verdict]) -> list[Row]:
    """Return what is right on each mount, and by how much the others are behind alt-azimuth."""
    altaz, others = ([one for one in verdicts if bool(one.spec["mount"]) == it] for it in (0, 1))
    rows = _curve("one cause, {} mount: class right first", "mount", _right, "shown")(others)
    if not altaz or not others:
        return rows
    first, second = (count([one.first for one in some]) for some in (altaz, others))
    behind, most = first.value - second.value, THRESHOLDS["mounts_behind_most"]
    return [
        _shown("one cause, alt-azimuth: class right first", [one.first for one in altaz]),
        *rows,
        Row(
            "other mounts: behind alt-azimuth",
            f"{100 * behind:.1f} points ({first.hits} of {first.of}, {second.hits} of {second.of})",
            f"at most {100 * most:.0f} points",
            behind <= most,
        ),
    ]


def _driven(verdicts: list[Verdict]) -> list[Row]:
    steps = [any(name.startswith("epoch") for name in one.wrong) for one in verdicts]
    return [
        _shown("driven by a condition: named so, or unknown", [one.first for one in verdicts]),
        at_most("driven by a condition: called a step", count(steps), "driven_epochs_most"),
    ]


def _named(what: str, by: str = "effect", **placed: tuple[str, str]) -> Any:  # noqa: ANN401
    """Return what shows how often the class is right first, and how well it is placed."""

    def fill(verdicts: list[Verdict]) -> list[Row]:
        rows = _curve(f"{what}, {{}}: class right first", by, _right, "shown")(verdicts)
        for key, (word, unit) in placed.items():
            values = [one.place[key] for one in verdicts if key in one.place]
            if values:
                value = f"median {float(np.median(values)):.3g}{unit}"
                rows.append(Row(f"{what}: {word} ({len(values)})", value, "shown", None))
        return rows

    return fill


def _degenerate(verdicts: list[Verdict]) -> list[Row]:
    whole = [one.whole_class for one in verdicts]
    alone = [one.verdict == "named" for one in verdicts]
    return [
        _at_least("twins: the whole class returned", whole, "degenerate_class_least"),
        _shown("twins: one confident name", alone),
    ]


def _two(verdicts: list[Verdict]) -> list[Row]:
    both, either = ([of(one.found) for one in verdicts] for of in (all, any))
    return [
        _at_least("two causes: both found", both, "two_both_least"),
        _shown("two causes: one of them found", either),
    ]


def _three(verdicts: list[Verdict]) -> list[Row]:
    return [
        _at_least(
            "three causes: all found", [all(one.found) for one in verdicts], "three_all_least"
        ),
        _shown("three causes: two of them found", [sum(one.found) > 1 for one in verdicts]),
    ]


def _unknown(verdicts: list[Verdict]) -> list[Row]:
    unknown, named = ([one.verdict == of for one in verdicts] for of in ("unknown", "named"))
    return [
        _at_least("not in the catalogue: unknown", unknown, "unknown_least"),
        _shown("not in the catalogue: one confident wrong name", named),
        *_curve("not in the catalogue, {}: unknown", "effect", _right, "shown")(verdicts),
    ]


def _placed(what: str, key: str, threshold: str | None, *, least: bool) -> Any:  # noqa: ANN401
    def fill(verdicts: list[Verdict]) -> list[Row]:
        placed = [one.place[key] for one in verdicts if key in one.place]
        if not placed:
            return []
        middle = float(np.median(placed))
        if threshold is None:
            return [Row(f"{what} ({len(placed)})", f"median {middle:.2f}", "shown", None)]
        limit = THRESHOLDS[threshold]
        passed = middle >= limit if least else middle <= limit
        word = "at least" if least else "at most"
        return [Row(f"{what} ({len(placed)})", f"median {middle:.2f}", f"{word} {limit:g}", passed)]

    return fill


def _ablation(verdicts: list[Verdict]) -> list[Row]:
    """Return the rows of the real sky; what the base swallows may be missed."""
    seen: list[bool] = []
    for one in verdicts:
        swallowed = {"ut1", "polar_motion"} if one.spec["kind"] == "ablation" else set()
        steps = one.spec["effect"].split("+")
        seen += [it for step, it in zip(steps, one.found, strict=True) if step not in swallowed]
    pulls = [abs(pull) for one in verdicts for _, _, pull in one.pulls]
    most = THRESHOLDS["ablation_sigmas_most"]
    return [
        _at_least("steps left out: class found", seen, "ablation_class_least"),
        Row(
            "steps left out: coefficients from nature's",
            f"{', '.join(f'{pull:.1f}' for pull in pulls)} sigma" if pulls else "none",
            f"at most {most:g} sigma",
            max(pulls) <= most if pulls else False,
        ),
    ]


_FILL: dict[str, Any] = {
    "null": _null,
    "one": _one,
    "rows": _curve("one cause, {} rows: class right first", "rows", _right),
    "ablation": _ablation,
    "weeks": _curve(
        "nutation left out, {:g} weeks: told from precession",
        "weeks",
        lambda one: one.first and one.said == "nutation" and one.verdict == "named",
    ),
    "degenerate": _degenerate,
    "two": _two,
    "three": _three,
    "unknown": _unknown,
    "mounts": _mounts,
    "little": _named("file with little in it", "little"),
    "models": _named("behind another model", "model"),
    "when": _named("at any moment", moment_rows=("recordings between", "")),
    "array": lambda those: [
        _shown("in some antennas: class right first", [one.first for one in those]),
        *_placed("in some antennas: overlap of rows", "subset_iou", None, least=True)(those),
    ],
    "oscillation": _named("swinging", period_off=("period off by", " of it")),
    "driven": _driven,
    **{group: _named("occasion") for group in ("rotator_circle", "quarter_day", "slew_hysteresis")},
    "real null": lambda those: [_claims("real noise, nothing hidden", those, "real_claims_most")],
    "real": lambda those: [
        _at_least("real noise: class right first", [one.first for one in those], "real_first_least")
    ],
    "region": _placed("a region: overlap of rows", "region_iou", "region_iou_least", least=True),
    "curve": _placed("a curve: distance [deg]", "curve_deg", "curve_deg_most", least=False),
    "moment": _placed("a moment: rows between", "moment_rows", "moment_rows_most", least=False),
    "zero": lambda those: [_claims("control, amplitude zero", those, "zero_claims_most")],
}
