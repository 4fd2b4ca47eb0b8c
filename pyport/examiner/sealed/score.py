"""The score: every row of the proof's table, from the verdicts on all cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.examiner.sealed.files import Rate, count
from pyport.examiner.sealed.judge import Verdict
from pyport.examiner.sealed.protocol import THRESHOLDS

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
    return [*rows, *_held_out(verdicts), *_honesty(verdicts)]


def _at_most(what: str, rate: Rate, key: str) -> Row:
    most = THRESHOLDS[key]
    return Row(what, str(rate), f"at most {100 * most:.0f} %", rate.value <= most)


def _at_least(what: str, rate: Rate, key: str) -> Row:
    least = THRESHOLDS[key]
    return Row(what, str(rate), f"at least {100 * least:.0f} %", rate.value >= least)


def _null(verdicts: list[Verdict]) -> list[Row]:
    claimed = count([one.claimed for one in verdicts])
    rows = [_at_most("nothing hidden: claims anything", claimed, "null_claims_most")]
    for noise in dict.fromkeys(one.spec["noise"] for one in verdicts):
        those = count([one.claimed for one in verdicts if one.spec["noise"] == noise])
        rows.append(Row(f"nothing hidden, {noise} noise", str(those), "shown", None))
    return rows


def _one(verdicts: list[Verdict]) -> list[Row]:
    rows = [
        Row(
            f"one cause, rho {rho:g}: detected",
            str(count([one.claimed for one in verdicts if one.spec["rho"] == rho])),
            "curve",
            None,
        )
        for rho in sorted({one.spec["rho"] for one in verdicts})
    ]
    loud = [one for one in verdicts if one.spec["rho"] >= THRESHOLDS["one_rho_least"]]
    first, three = count([one.first for one in loud]), count([one.three for one in loud])
    wrong = [one.verdict == "named" and not one.first for one in loud]
    widths = [one.width for one in loud if one.width]
    width = f"mean {np.mean(widths):.2f}" if widths else "none"
    return [
        *rows,
        _at_least("one cause: class right first", first, "one_first_least"),
        _at_least("one cause: in the first three", three, "one_three_least"),
        Row("one cause: one confident wrong name", str(count(wrong)), "shown", None),
        Row("one cause: names in the first class", width, "shown", None),
    ]


def _rows(verdicts: list[Verdict]) -> list[Row]:
    return [
        Row(
            f"one cause, rho 0.25, {rows} rows: detected",
            str(count([one.claimed for one in verdicts if one.spec["rows"] == rows])),
            "curve",
            None,
        )
        for rows in sorted({one.spec["rows"] for one in verdicts})
    ]


def _degenerate(verdicts: list[Verdict]) -> list[Row]:
    whole = count([one.whole_class for one in verdicts])
    alone = count([one.verdict == "named" for one in verdicts])
    return [
        _at_least("twins: the whole class returned", whole, "degenerate_class_least"),
        Row("twins: one confident name", str(alone), "shown", None),
    ]


def _two(verdicts: list[Verdict]) -> list[Row]:
    both = count([all(one.found) for one in verdicts])
    either = count([any(one.found) for one in verdicts])
    return [
        _at_least("two causes: both found", both, "two_both_least"),
        Row("two causes: one of them found", str(either), "shown", None),
    ]


def _unknown(verdicts: list[Verdict]) -> list[Row]:
    return [
        _at_least(
            "not in the catalogue: unknown",
            count([one.verdict == "unknown" for one in verdicts]),
            "unknown_least",
        ),
        Row(
            "not in the catalogue: one confident wrong name",
            str(count([one.verdict == "named" for one in verdicts])),
            "shown",
            None,
        ),
    ]


def _placed(what: str, key: str, threshold: str, *, least: bool) -> Any:  # noqa: ANN401
    def fill(verdicts: list[Verdict]) -> list[Row]:
        placed = [one.place[key] for one in verdicts if key in one.place]
        if not placed:
            return []
        middle, limit = float(np.median(placed)), THRESHOLDS[threshold]
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
        _at_least("steps left out: class found", count(seen), "ablation_class_least"),
        Row(
            "steps left out: coefficients from nature's",
            f"{', '.join(f'{pull:.1f}' for pull in pulls)} sigma" if pulls else "none",
            f"at most {most:g} sigma",
            max(pulls) <= most if pulls else False,
        ),
    ]


def _weeks(verdicts: list[Verdict]) -> list[Row]:
    """Return from how long a campaign on nutation is told from precession."""

    def told(one: Verdict) -> bool:
        return one.first and one.said == "nutation" and one.verdict == "named"

    return [
        Row(
            f"nutation left out, {weeks:g} weeks: told from precession",
            str(count([told(one) for one in verdicts if one.spec["weeks"] == weeks])),
            "curve",
            None,
        )
        for weeks in sorted({one.spec["weeks"] for one in verdicts})
    ]


def _zero(verdicts: list[Verdict]) -> list[Row]:
    claimed = count([one.claimed for one in verdicts])
    return [_at_most("control, amplitude zero: claims anything", claimed, "zero_claims_most")]


_FILL: dict[str, Any] = {
    "null": _null,
    "one": _one,
    "rows": _rows,
    "ablation": _ablation,
    "weeks": _weeks,
    "degenerate": _degenerate,
    "two": _two,
    "unknown": _unknown,
    "region": _placed("a region: overlap of rows", "region_iou", "region_iou_least", least=True),
    "curve": _placed("a curve: distance [deg]", "curve_deg", "curve_deg_most", least=False),
    "moment": _placed("a moment: rows between", "moment_rows", "moment_rows_most", least=False),
    "zero": _zero,
}


def _held_out(verdicts: Iterable[Verdict]) -> list[Row]:
    loud = [
        one.skill
        for one in verdicts
        if one.skill is not None and one.spec["rho"] >= THRESHOLDS["skill_rho_least"]
    ]
    if not loud:
        return []
    each = [gained / gainable for gained, gainable in loud if gainable > 0]
    pooled = sum(gained for gained, _ in loud) / sum(gainable for _, gainable in loud)
    middle, least = float(np.median(each)), THRESHOLDS["skill_least"]
    return [
        Row(
            f"held out: skill ({len(each)})",
            f"median {middle:.3f}, pooled {pooled:.3f}",
            f"at least {least:g}",
            middle >= least,
        )
    ]


def _honesty(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return whether stated probabilities and sigmas are true."""
    below = dict(calibration(verdicts))[_LEVEL]
    within_one, within_two = pulls(verdicts)
    return [
        Row(f"nothing hidden: p-value below {_LEVEL:g}", str(below), "shown", None),
        Row("coefficients within one sigma of the truth", str(within_one), "68 %", None),
        Row("coefficients within two sigma of the truth", str(within_two), "95 %", None),
    ]


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
    return verdict.p_value if verdict.group in {"null", "zero"} else None


def calibration(verdicts: Iterable[Verdict]) -> list[tuple[float, Rate]]:
    """Return how often p-values of cases that hide nothing are below a level, by level."""
    values = [p for one in verdicts if (p := silent_p_value(one)) is not None]
    return [(level, count([p <= level for p in values])) for level in _LEVELS]


def pulls(verdicts: Iterable[Verdict]) -> tuple[Rate, Rate]:
    """Return how many coefficients lie within one and within two reported sigmas of the truth."""
    sizes = [abs(pull) for one in verdicts for _, _, pull in one.pulls]
    return count([size <= 1 for size in sizes]), count([size <= 2 for size in sizes])
