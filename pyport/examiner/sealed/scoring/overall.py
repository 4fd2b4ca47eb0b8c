"""What a score says of all cases together: skill, honesty, what was confused with what."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

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


def at_most(what: str, rate: Rate, key: str) -> Row:
    """Return a row that passes where a rate is no larger than a threshold."""
    most = THRESHOLDS[key]
    return Row(what, str(rate), f"at most {100 * most:.0f} %", rate.value <= most)


def of_all(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return the rows that cases of every group fill."""
    return [
        *_efficiency(verdicts),
        *_beside(verdicts),
        *_held_out(verdicts),
        *_honesty(verdicts),
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
    names = Counter(name for one in loud for name in one.wrong)
    said = ", ".join(f"{name} {n}" for name, n in names.most_common(5)) or "none"
    rate = count([bool(one.wrong) for one in loud])
    return [
        at_most("found, and something wrong beside it", rate, "beside_most"),
        Row("wrong findings beside right ones", f"{names.total()}: {said}", "shown", None),
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
    share = f"{rate.hits / could:.2f} ({rate.hits} of {could:.1f}; {low:.2f} to {high:.2f})"
    return Row(
        f"{what}: detected, over what an ideal observer detects",
        share,
        "shown" if shown else f"at least {least:g}, inside the interval",
        None if shown else high >= least,
    )


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
    claims = [one for one in known if one.claimed]
    rows = []
    if loud:
        each = [gained / gainable for gained, gainable in loud if gainable > 0]
        pooled = sum(gained for gained, _ in loud) / sum(gainable for _, gainable in loud)
        middle, least = float(np.median(each)), THRESHOLDS["skill_least"]
        result = f"median {middle:.3f}, pooled {pooled:.3f}"
        what = f"held out: skill ({len(each)})"
        rows.append(Row(what, result, f"at least {least:g}", middle >= least))
    if claims:
        worse = count([one.skill is not None and one.skill[0] < -_STEPS for one in claims])
        rows.append(at_most("held out: worse than without findings", worse, "worse_most"))
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
