"""Cases of other mounts put to the program, and how many came out right."""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from pyport.examiner import program
from pyport.examiner.acceptance.drawn import judged
from pyport.examiner.scores import Share, counted
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.faults import UNKNOWN as FORMS
from pyport.examiner.worlds.kinds import STANDS, Spec

MOUNTS = tuple(STANDS)
EMPTY, ONE, TWO, UNKNOWN = PARTS = ("empty", "one", "two", "unknown")
#: What is asked of each part, least and most.
TARGETS = {EMPTY: (0.98, 1.0), ONE: (0.95, 1.0)}
#: Rows of a case, in turn, and kinds of noise.
ROWS, NOISES = (200, 400, 800), ("white", "student-3", "outliers-both-ways")


@dataclasses.dataclass(frozen=True)
class Case:
    """Which case is meant: its mount, part, number and the seed of all."""

    mount: str
    part: str
    number: int
    seed: int

    def spec(self) -> Spec:
        """Return what is to be made: causes by turns, so that all are drawn alike."""
        some, n = STANDS[self.mount], self.number
        first, second = some[n % len(some)], some[(n + 1 + n // len(some)) % len(some)]
        kind, effect = {
            EMPTY: ("null", None),
            ONE: ("one", first),
            TWO: ("two", first if first == second else f"{first}+{second}"),
            UNKNOWN: ("unknown", FORMS[n % len(FORMS)]),
        }[self.part]
        noise = NOISES[n // len(ROWS) % len(NOISES)]
        return Spec(
            self.part, kind, effect, 0.5, ROWS[n % len(ROWS)], noise=noise, mount=self.mount
        )


def cases(mounts: Iterable[str], parts: Iterable[str], count: int, seed: int) -> list[Case]:
    """Return `count` cases of each mount and part; all grow together."""
    mounts, parts = list(mounts), list(parts)
    return [
        Case(mount, part, number, seed)
        for number in range(count)
        for part in parts
        for mount in mounts
    ]


def examine(case: Case) -> dict[str, Any]:
    """Draw a case, put it to the program, and return what came out beside the truth."""
    spec = case.spec()
    # the seed of another mount or number is another
    words = [case.seed, MOUNTS.index(case.mount), PARTS.index(case.part), case.number]
    seed = int(np.random.SeedSequence(words).generate_state(1)[0])
    made, begun = spec.make(seed), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "recordings.csv"
        write_recordings(made, file)
        report = program.diagnosed(file)
    outcome = {
        **dataclasses.asdict(case),
        "program": program.version(),
        "rows": spec.rows,
        "hidden": [one["effect"] for one in made.truth["effects"]],
        "seconds": time.monotonic() - begun,
    }
    if isinstance(report, program.Refused):
        return outcome | {"refused": report.why}
    verdict = judged(spec, seed, made, report)
    found = [
        {key: one.get(key) for key in ("effect", "variant", "verdict", "class")}
        for one in report["findings"]
    ]
    names = {"claimed": verdict.claimed, "found": verdict.found, "wrong": verdict.wrong}
    return outcome | names | {"p_value": report["p_value"], "findings": found}


def right(outcome: dict[str, Any]) -> bool:
    """Tell whether a case came out as it should.

    Nothing is found where nothing is hidden; what is hidden is found, each cause of two, by its
    name or in a class of few that recordings cannot distinguish; of what nobody can name no name
    is given.
    """
    if "refused" in outcome:
        return False
    if outcome["part"] == EMPTY:
        return not outcome["claimed"]
    if outcome["part"] == UNKNOWN:
        return not outcome["wrong"]
    return all(outcome["found"])


def sharp(outcome: dict[str, Any]) -> bool:
    """Tell whether each cause that is hidden was given its one name."""
    classes = [set(one["class"]) for one in outcome.get("findings", ())]
    return all({name} in classes for name in outcome["hidden"])


def share(outcomes: Iterable[dict[str, Any]]) -> Share:
    """Return how many of some cases came out right."""
    return counted([right(one) for one in outcomes])


def text(outcomes: list[dict[str, Any]]) -> str:
    """Return a table of shares by mount and part, and what was said in the others."""
    lines = [f"{'mount':8s}{'part':10s}{'right':>10s}  {'% (95 %)':20s}{'one name':>9s}  target"]
    for mount in dict.fromkeys(one["mount"] for one in outcomes):
        for part in PARTS:
            own = [one for one in outcomes if (one["mount"], one["part"]) == (mount, part)]
            if not own:
                continue
            found = share(own)
            low = TARGETS.get(part)
            target = "" if low is None else f"{100 * low[0]:.0f} %: {found.judged(*low)}"
            count = f"{found.hits}/{found.of}"
            named = str(sum(map(sharp, own))) if part in (ONE, TWO) else ""
            line = f"{mount:8s}{part:10s}{count:>10s}  {found!s:20s}{named:>9s}  {target}"
            lines.append(line.rstrip())
    wrong = Counter(_said(one) for one in outcomes if not right(one))
    lines += ["", *(f"{count} x {said}" for said, count in wrong.most_common())]
    return "\n".join(lines)


def _said(outcome: dict[str, Any]) -> str:
    hidden = " and ".join(outcome["hidden"]) or "nothing"
    if "refused" in outcome:
        return f"{outcome['mount']}, {hidden}: refused, {outcome['refused']}"
    found = [f"{one['effect']} {one['variant'] or ''}".strip() for one in outcome["findings"]]
    return f"{outcome['mount']}, {hidden}: found {', '.join(found) or 'nothing'}"
