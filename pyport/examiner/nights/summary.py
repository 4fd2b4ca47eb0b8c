"""What came out of the watched nights, as tables."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pyport.examiner import program
from pyport.examiner.nights import nights
from pyport.examiner.nights.nights import Case


def outcomes(
    cases: list[Case], file: Path, pointings_per_false_alarm: float
) -> Iterator[dict[str, Any]]:
    """Yield what comes out of every case, those first that the file has of this program."""
    kept = {}
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else []:
        one = json.loads(line)
        if one["program"] == [program.version(), pointings_per_false_alarm]:
            kept[one["kind"], one["number"], one["seed"], one["step"]] = one
    file.parent.mkdir(parents=True, exist_ok=True)
    for case in cases:
        found = kept.get((case.kind, case.number, case.seed, case.step))
        if found is None:
            found = nights.examine(case, pointings_per_false_alarm)
            found["program"] = [program.version(), pointings_per_false_alarm]
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(found) + "\n")
        yield found


def of_nulls(found: Iterable[dict[str, Any]], pointings_per_false_alarm: float) -> str:
    """Return the table of nights without change: pointings and alarms in each kind of noise."""
    some = list(found)
    lines = ["noise                   pointings  alarms  of what"]
    for kind in dict.fromkeys(one["kind"] for one in some):
        own = [one for one in some if one["kind"] == kind]
        pointings = sum(one["pointings"] for one in own)
        raised = [each["is"]["effect"] for one in own for each in one["raised"]]
        lines.append(f"{kind:22} {pointings:10d} {len(raised):7d}  {', '.join(raised)}")
    total = sum(one["pointings"] for one in some)
    raised_all = sum(len(one["raised"]) for one in some)
    count = len(some) * (nights.NIGHTS - nights.NIGHTS // 2)
    lines.append(f"{'all':22} {total:10d} {raised_all:7d}")
    promised = total / pointings_per_false_alarm
    lines.append(f"{count} nights; {promised:.1f} false alarms are promised at most, on average")
    return "\n".join(lines)


def of_steps(found: Iterable[dict[str, Any]]) -> str:
    """Return the table of steps: delays beside the best possible ones, names and dates."""
    some = list(found)
    lines = [
        "                 delay [pointings]      best possible     named  dated    before",
        "sigma   seen  median  mean  90 %   median  mean  90 %    right  +-1      the step",
    ]
    for size in [*sorted({one["size"] for one in some}), None]:
        own = [one for one in some if size in (None, one["size"])]
        seen = [one for one in own if one["delay"] is not None and one["best"] is not None]
        delay = np.array([one["delay"] for one in seen])
        best = np.array([one["best"] for one in seen])
        right = np.mean([one["right"] for one in seen])
        dated = np.mean([abs(one["since_off"]) <= 1 for one in seen])
        before = sum(one["false"] for one in own)
        lines.append(
            f"{'all' if size is None else f'{size:3.0f}'}   {len(seen):4d}/{len(own):<4d}"
            f"{_three(delay)}    {_three(best)}   {right:6.0%} {dated:6.0%} {before:6d}"
        )
    return "\n".join(lines)


def _three(values: Any) -> str:  # noqa: ANN401 - an array
    return f"{np.median(values):5.0f} {values.mean():6.1f} {np.quantile(values, 0.9):5.0f}"
