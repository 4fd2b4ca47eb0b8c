"""The score: every row of the proof's table, from the verdicts on all cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.examiner.scores import MISSED
from pyport.examiner.sealed.protocol import THRESHOLDS
from pyport.examiner.sealed.record.files import Rate, count
from pyport.examiner.sealed.scoring.judge import Verdict

#: Levels at which stated p-values are held to what happens, and the one that the table shows.
_LEVELS = (0.01, 0.05, 0.1, 0.2, 0.5)
_LEVEL = 0.05


@dataclass(frozen=True)
class Row:
    """One row of the table: what was asked, what came out, what was to be reached."""

    what: str
    result: str
    needed: str
    passed: bool | None

    def __str__(self) -> str:
        """Return the row as Markdown."""
        mark = {True: "yes", False: "**no**", None: "shown"}[self.passed]
        return f"| {self.what} | {self.result} | {self.needed} | {mark} |"


def table(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return the rows that these verdicts can fill."""
    by_group: dict[str, list[Verdict]] = {}
    for one in verdicts:
        by_group.setdefault(one.group, []).append(one)
    rows: list[Row] = []
    for group, fill in _FILL.items():
        if group in by_group:
            rows += fill(by_group[group])
    return [
        *rows,
        *_efficiency(verdicts),
        *_beside(verdicts),
        *_held_out(verdicts),
        *_honesty(verdicts),
    ]


def _at_most(what: str, rate: Rate, key: str) -> Row:
    most = THRESHOLDS[key]
    return Row(what, str(rate), f"at most {100 * most:.0f} %", rate.value <= most)


def _at_least(what: str, outcomes: list[bool], key: str) -> Row:
    least, rate = THRESHOLDS[key], count(outcomes)
    return Row(what, str(rate), f"at least {100 * least:.0f} %", rate.value >= least)


def _shown(what: str, outcomes: list[bool], needed: str = "shown") -> Row:
    return Row(what, str(count(outcomes)), needed, None)


def _claims(what: str, verdicts: list[Verdict], key: str) -> Row:
    return _at_most(f"{what}: claims anything", count([one.claimed for one in verdicts]), key)


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


def _beside(verdicts: Iterable[Verdict]) -> list[Row]:
    """Return how often something wrong is said beside what is hidden, in every case that has it."""
    loud = [
        one
        for one in verdicts
        if one.found and one.spec["rho"] >= THRESHOLDS["one_rho_least"] and any(one.found)
    ]
    if not loud:
        return []
    told = Counter(name for one in loud for name in one.wrong)
    said = ", ".join(f"{name} {n}" for name, n in told.most_common(5)) or "none"
    rate = count([bool(one.wrong) for one in loud])
    return [
        _at_most("found, and something wrong beside it", rate, "beside_most"),
        Row("wrong findings beside right ones", f"{sum(told.values())}: {said}", "shown", None),
    ]


def _efficiency(verdicts: Iterable[Verdict]) -> list[Row]:
    """Return detections over those of an ideal observer, by rows and loudness, and of all cells."""
    cells: dict[tuple[int, float], list[Verdict]] = {}
    for one in verdicts:
        if one.possible is not None and one.spec["rho"] >= THRESHOLDS["one_rho_least"]:
            cells.setdefault((one.spec["rows"] or 1200, one.spec["rho"]), []).append(one)
    enough = {cell: some for cell, some in cells.items() if sum(map(_chance, some)) >= _FEWEST}
    least_rows = THRESHOLDS["efficiency_rows_least"]
    rows = []
    for (n, rho), some in sorted(enough.items()):
        rows.append(_of_observer(f"{n} rows, rho {rho:g}", some, shown=n < least_rows))
    whole = [one for (n, _), some in enough.items() if n >= least_rows for one in some]
    if whole:
        rows.append(_of_observer(f"all of {least_rows:g} rows and more", whole))
    return rows


#: In fewer detections that an ideal observer makes a ratio says nothing.
_FEWEST = 2.0


def _chance(one: Verdict) -> float:
    return one.possible or 0.0


def _of_observer(what: str, some: list[Verdict], *, shown: bool = False) -> Row:
    """Return a row of a cell; it fails where its Wilson interval stays below what is needed."""
    could, least = sum(map(_chance, some)), THRESHOLDS["efficiency_least"]
    rate = count([one.claimed for one in some])
    low, high = (end * rate.of / could for end in rate.interval)
    told = f"{rate.hits / could:.2f} ({rate.hits} of {could:.1f}; {low:.2f} to {high:.2f})"
    return Row(
        f"{what}: detected, over what an ideal observer detects",
        told,
        "shown" if shown else f"at least {least:g}, inside the interval",
        None if shown else high >= least,
    )


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
        _at_most("driven by a condition: called a step", count(steps), "driven_epochs_most"),
    ]


def _named(what: str, by: str = "effect", **placed: tuple[str, str]) -> Any:  # noqa: ANN401
    """Return what shows how often the class is right first, and how well it is placed."""

    def fill(verdicts: list[Verdict]) -> list[Row]:
        rows = _curve(f"{what}, {{}}: class right first", by, _right, "shown")(verdicts)
        for key, (word, unit) in placed.items():
            values = [one.place[key] for one in verdicts if key in one.place]
            if values:
                told = f"median {float(np.median(values)):.3g}{unit}"
                rows.append(Row(f"{what}: {word} ({len(values)})", told, "shown", None))
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


#: Groups whose skill counts; that of others is asked only whether it is negative.
_SKILLED = frozenset({"one", "curve", "moment"})
#: Answers are kept in steps, by which a mean square may be off. [the noise's square]
_STEPS = 2e-3


def _held_out(verdicts: Iterable[Verdict]) -> list[Row]:
    known = [one for one in verdicts if one.skill is not None]
    loud = [
        one.skill
        for one in known
        if one.skill and one.group in _SKILLED and one.spec["rho"] >= THRESHOLDS["skill_rho_least"]
    ]
    told = [one for one in known if one.claimed]
    rows = []
    if loud:
        each = [gained / gainable for gained, gainable in loud if gainable > 0]
        pooled = sum(gained for gained, _ in loud) / sum(gainable for _, gainable in loud)
        middle, least = float(np.median(each)), THRESHOLDS["skill_least"]
        result = f"median {middle:.3f}, pooled {pooled:.3f}"
        what = f"held out: skill ({len(each)})"
        rows.append(Row(what, result, f"at least {least:g}", middle >= least))
    if told:
        worse = count([one.skill is not None and one.skill[0] < -_STEPS for one in told])
        rows.append(_at_most("held out: worse than without findings", worse, "worse_most"))
    return rows


def _honesty(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return whether stated probabilities and sigmas are true."""
    below = dict(calibration(verdicts))[_LEVEL]
    rows = [Row(f"nothing hidden: p-value below {_LEVEL:g}", str(below), "shown", None)]
    for many, rate in zip(("one", "two"), pulls(verdicts), strict=True):
        low, high = (THRESHOLDS[f"{many}_sigma_{end}"] for end in ("least", "most"))
        what = f"coefficients within {many} sigma of the truth"
        needed = f"{100 * low:.0f} to {100 * high:.0f} %, inside the interval"
        met = None if not rate.of else rate.judged(low, high) != MISSED
        rows.append(Row(what, str(rate), needed, met))
    return rows


def confusion(verdicts: Iterable[Verdict]) -> list[tuple[str, str, int]]:
    """Return (hidden, said, how often) for cases that hide one cause loudly, by the hidden one."""
    twin = {"degenerate": "twin: "}
    pairs = Counter(
        (twin.get(one.group, "") + str(one.spec["effect"]), "right" if one.first else one.said)
        for one in verdicts
        if one.group in {"one", "unknown", "degenerate"}
        and one.spec["rho"] >= THRESHOLDS["one_rho_least"]
    )
    return [(hidden, said, n) for (hidden, said), n in sorted(pairs.items())]


def silent_p_value(verdict: Verdict) -> float | None:
    """Return the stated p-value of a case that hides nothing, if it is one."""
    return verdict.p_value if verdict.group in {"null", "zero", "real null"} else None


def calibration(verdicts: Iterable[Verdict]) -> list[tuple[float, Rate]]:
    """Return how often p-values of cases that hide nothing are below a level, by level."""
    values = [p for one in verdicts if (p := silent_p_value(one)) is not None]
    return [(level, count([p <= level for p in values])) for level in _LEVELS]


def pulls(verdicts: Iterable[Verdict]) -> tuple[Rate, Rate]:
    """Return how many coefficients lie within one and within two reported sigmas of the truth."""
    sizes = [abs(pull) for one in verdicts for _, _, pull in one.pulls]
    return count([size <= 1 for size in sizes]), count([size <= 2 for size in sizes])
