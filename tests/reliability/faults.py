"""Let the program fail anywhere and look at what it says: python tests/reliability/faults.py.

A fault is an exception that no part of the program expects, raised where one of
its functions is called: the first call, the last, and some drawn between them.
Each must end the command with status 70, one line on standard error and a report
with the traceback, and leave every file of its answer the old one or the new one.
Where a reader takes any error of a library for bad input, status 2 will do. `pyport parity` is
left out: whatever its ports raise is their answer, a broken promise.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import Any

from torture import ALWAYS, lost, start, warm
from victims import Victim, prepare, victims

import pyport

PROGRAM = str(Path(pyport.__file__).parent)
#: What raises: the last resort itself cannot be tested by its failing, nor can what imports.
NOT_HERE = ("/cli/__init__.py", "/cli/manners.py")


class Injected(Exception):  # noqa: N818 - no error of anybody's
    """What no part of the program expects."""


def _is_ours(frame: FrameType) -> bool:
    name = frame.f_code.co_filename
    return name.startswith(PROGRAM) and not name.endswith(NOT_HERE)


def calls(words: tuple[str, ...]) -> int:
    """Run a command in this process and count the calls of the program's functions."""
    count = 0

    def look(frame: FrameType, event: str, _: Any) -> None:
        nonlocal count
        count += event == "call" and _is_ours(frame)

    sys.setprofile(look)
    try:
        warm(words)
    finally:
        sys.setprofile(None)
    return count


def fail_at(call: int) -> None:
    """Let the call of that number, from 0, raise in this process."""
    left = call

    def look(frame: FrameType, event: str, _: Any) -> None:
        nonlocal left
        if event == "call" and _is_ours(frame):
            left -= 1
            if left < 0:
                sys.setprofile(None)
                raise Injected(f"in {frame.f_code.co_qualname}")

    sys.setprofile(look)


def wrong(victim: Victim, call: int, old: Path, new: Path, folder: Path) -> tuple[int, list[str]]:
    """Run a command that fails at a call; return its status and what is wrong with its end."""
    now, said = folder / "now", folder / "said"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(old, now)
    words = (*victim.new, str(now / victim.out))

    def before() -> None:
        os.chdir(folder)
        fail_at(call)

    _, ended = os.waitpid(start(words, said, before), 0)
    status = os.waitstatus_to_exitcode(ended)
    lines = said.read_text().splitlines()
    reports = list(folder.glob("pyport-fault-*.txt"))
    found = [f"{name} is neither old nor new" for name in lost(now, old, new)]
    if status == 0:  # raised where nobody can be told, as in the end of an object
        return status, found + [f"{name} is not new" for name in lost(now, new)]
    if len(lines) != 1 or "Traceback" in lines[0]:
        found.append(f"{len(lines)} lines: {lines[:1]} ... {lines[-1:]}")
    if status == 70 and not (len(reports) == 1 and "Injected" in reports[0].read_text()):
        found.append("no report with the traceback")
    if status not in {2, 70}:
        found.append(f"status {status}")
    return status, found


def main() -> int:
    """Let every command fail so often; return 1 where an end is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commands", nargs="*", help="all, when none is named")
    parser.add_argument("--faults", type=int, default=25, help="of each command")
    parser.add_argument("--seed", type=int, help="printed; drawn unless given")
    told = parser.parse_args()
    seed = random.SystemRandom().randrange(10**6) if told.seed is None else told.seed
    os.environ.update(ALWAYS)
    print(
        f"seed {seed}\n{'command':<22}{'calls':>9}{'70':>6}{'2':>6}{'0':>6}{'wrong':>7}", flush=True
    )
    bad = 0
    with tempfile.TemporaryDirectory(prefix="faults-") as name:
        folder = Path(name)
        prepare(folder)
        for victim in victims(folder).values():
            if victim.name == "parity" or (told.commands and victim.name not in told.commands):
                continue
            bad += bool(_fail(victim, told.faults, seed, folder))
    print("every fault is one line and a report" if not bad else f"{bad} commands end wrongly")
    return int(bad > 0)


def _fail(victim: Victim, faults: int, seed: int, folder: Path) -> list[str]:
    """Let a command fail so often, print what came of it, and return what is wrong."""
    place = folder / victim.name.replace(" ", "-").replace(",", "")
    old, new = place / "old", place / "new"
    old.mkdir(parents=True)
    victim.prepare(old)
    warm((*victim.old, str(old / victim.out)))
    shutil.copytree(old, new)
    count = calls((*victim.new, str(new / victim.out)))
    rng = random.Random(f"{seed} {victim.name}")  # noqa: S311 - no secret
    drawn = rng.sample(range(count), min(count, faults))
    statuses: Counter[int] = Counter()
    found = []
    for call in sorted({0, count - 1, *drawn}):
        status, said = wrong(victim, call, old, new, place / "try")
        statuses[status] += 1
        found += [f"call {call}: {one}" for one in said]
    print(
        f"{victim.name:<22}{count:>9}{statuses[70]:>6}{statuses[2]:>6}{statuses[0]:>6}"
        f"{len(found):>7}",
        *(f"\n    {one}" for one in found),
        flush=True,
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
