"""Cases of other mounts put to the program, and how many came out right."""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pyport.examiner import program
from pyport.examiner.mounts import worlds
from pyport.examiner.mounts.worlds import EMPTY, ONE, TWO, UNKNOWN, Case
from pyport.examiner.scores import Share, counted

MOUNTS = ("german", "fork", "xy-ns", "xy-ew")
PARTS = (EMPTY, ONE, TWO, UNKNOWN)
#: What is asked of each part, least and most.
TARGETS = {EMPTY: (0.98, 1.0), ONE: (0.95, 1.0)}
#: A class of more names than this is no answer.
WIDEST_CLASS = 6


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
    world, begun = worlds.draw(case), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "five.toml"
        model.write_text(world.model, encoding="utf-8")
        report = program.diagnosed(world.table, world.header, str(model))
    outcome = {
        **dataclasses.asdict(case),
        "program": program.version(),
        "rows": len(world.table["time_utc"]),
        "sigma_arcsec": world.sigma,
        "hidden": list(world.hidden),
        "twins": world.twins,
        "seconds": time.monotonic() - begun,
    }
    if isinstance(report, program.Refused):
        return outcome | {"refused": report.why}
    found = [
        {key: one.get(key) for key in ("effect", "variant", "verdict", "class")}
        for one in report["findings"]
    ]
    return outcome | {"p_value": report["p_value"], "findings": found}


def right(outcome: dict[str, Any]) -> bool:
    """Tell whether a case came out as it should.

    Nothing is found where nothing is hidden; what is hidden is found, each cause of two, by its
    name or in a class of few that recordings cannot distinguish; of what nobody can name no name
    is given.
    """
    if "refused" in outcome:
        return False
    few = [one for one in outcome["findings"] if len(one["class"]) <= WIDEST_CLASS]
    named = {name for one in few for name in (one["effect"], *one["class"])}
    if outcome["part"] == EMPTY:
        return not named
    if outcome["part"] == UNKNOWN:
        return named <= {UNKNOWN}
    return set(outcome["hidden"]) <= named


def sharp(outcome: dict[str, Any], *, twins: bool = True) -> bool:
    """Tell whether each cause that is hidden was given its one name.

    With `twins`, or a class of that and names that nobody could tell from it in these recordings.
    """
    classes = [set(one["class"]) for one in outcome.get("findings", ())]
    allowed = outcome["twins"] if twins else {}
    return all(
        any(name in one and one <= {name, *allowed.get(name, ())} for one in classes)
        for name in outcome["hidden"]
    )


def share(outcomes: Iterable[dict[str, Any]]) -> Share:
    """Return how many of some cases came out right."""
    return counted([right(one) for one in outcomes])


def text(outcomes: list[dict[str, Any]]) -> str:
    """Return a table of shares by mount and part, and what was said in the others."""
    head = f"{'one name':>9s}{'or twins':>9s}"
    lines = [f"{'mount':8s}{'part':10s}{'right':>10s}  {'% (95 %)':20s}{head}  target"]
    for mount in dict.fromkeys(one["mount"] for one in outcomes):
        for part in PARTS:
            own = [one for one in outcomes if (one["mount"], one["part"]) == (mount, part)]
            if not own:
                continue
            found = share(own)
            low = TARGETS.get(part)
            target = "" if low is None else f"{100 * low[0]:.0f} %: {found.judged(*low)}"
            count = f"{found.hits}/{found.of}"
            named = ["", ""]
            if part in (ONE, TWO):
                named = [str(sum(sharp(one, twins=both) for one in own)) for both in (False, True)]
            names = "".join(f"{one:>9s}" for one in named)
            line = f"{mount:8s}{part:10s}{count:>10s}  {found!s:20s}{names}  {target}"
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
