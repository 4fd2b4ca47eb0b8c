"""The score: every row of the proof's table, from the verdicts on all cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
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


def _at_least(what: str, outcomes: list[bool], key: str) -> Row:
    least, rate = THRESHOLDS[key], count(outcomes)
    return Row(what, str(rate), f"at least {100 * least:.0f} %", rate.value >= least)


def _shown(what: str, outcomes: list[bool], needed: str = "shown") -> Row:
    return Row(what, str(count(outcomes)), needed, None)


def _claims(what: str, verdicts: list[Verdict], key: str) -> Row:
    return _at_most(f"{what}: claims anything", count([one.claimed for one in verdicts]), key)


def _null(verdicts: list[Verdict]) -> list[Row]:
    by_noise = _curve("nothing hidden, {} noise", "noise", _detected, "shown")(verdicts)
    return [_claims("nothing hidden", verdicts, "null_claims_most"), *by_noise]


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


def _one(verdicts: list[Verdict]) -> list[Row]:
    loud = [one for one in verdicts if one.spec["rho"] >= THRESHOLDS["one_rho_least"]]
    wrong = [one.verdict == "named" and not one.first for one in loud]
    widths = [one.width for one in loud if one.width]
    width = f"mean {np.mean(widths):.2f}" if widths else "none"
    return [
        *_curve("one cause, rho {:g}: detected", "rho", _detected)(verdicts),
        _at_least("one cause: class right first", [one.first for one in loud], "one_first_least"),
        _at_least("one cause: in the first three", [one.three for one in loud], "one_three_least"),
        _shown("one cause: one confident wrong name", wrong),
        Row("one cause: names in the first class", width, "shown", None),
    ]


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


def _unknown(verdicts: list[Verdict]) -> list[Row]:
    unknown, named = ([one.verdict == of for one in verdicts] for of in ("unknown", "named"))
    return [
        _at_least("not in the catalogue: unknown", unknown, "unknown_least"),
        _shown("not in the catalogue: one confident wrong name", named),
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
    "rows": _curve("one cause, rho 0.25, {} rows: detected", "rows", _detected),
    "ablation": _ablation,
    "weeks": _curve(
        "nutation left out, {:g} weeks: told from precession",
        "weeks",
        lambda one: one.first and one.said == "nutation" and one.verdict == "named",
    ),
    "degenerate": _degenerate,
    "two": _two,
    "unknown": _unknown,
    "region": _placed("a region: overlap of rows", "region_iou", "region_iou_least", least=True),
    "curve": _placed("a curve: distance [deg]", "curve_deg", "curve_deg_most", least=False),
    "moment": _placed("a moment: rows between", "moment_rows", "moment_rows_most", least=False),
    "zero": lambda those: [_claims("control, amplitude zero", those, "zero_claims_most")],
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
