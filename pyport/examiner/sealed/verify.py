"""A proof checked from the history alone: nothing that lies beside it is believed."""

from __future__ import annotations

import hashlib
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner.sealed import solve
from pyport.examiner.sealed.prove import (
    ANSWERS,
    OPENED,
    SCORE,
    SEALED,
    STAGES,
    VERDICTS,
    WHO,
    read_lines,
)
from pyport.examiner.sealed.record import code
from pyport.examiner.sealed.record.files import commitment
from pyport.examiner.sealed.record.history import History
from pyport.examiner.sealed.record.published import read_seal
from pyport.examiner.sealed.seal import Folder
from pyport.files import write_file

#: Numbers of a verdict may differ by so much between machines, in parts of themselves.
_ALIKE = 1e-6


@dataclass(frozen=True)
class Check:
    """What was looked at, what was seen, and whether it is as it should be."""

    what: str
    said: str
    passed: bool


@dataclass(frozen=True)
class Chain:
    """The three commits of a proof and what stood in them.

    `held`: the files of the set by name, as they stood in the commit that added them.
    """

    history: History
    place: Path
    commits: tuple[str, ...]
    held: dict[str, bytes]


def verify(place: Path, again: int | None, jobs: int = 1) -> Iterator[Check]:
    """Yield every check of a published set.

    `place`: its folder in a repository.
    `again`: how many cases are made and judged again, drawn at random; None for all.
    Raises `BadInput`: there is no such set in the history, or its files cannot be read.
    """
    history = History.of(place)
    found = {name: history.commits(place / name) for names, _, _ in STAGES for name in names}
    missing = [name for name, commits in found.items() if not commits]
    if missing:
        raise BadInput(f"the history has no {missing[0]}: expected a proof of three commits", place)
    for name, commits in found.items():
        many = f"{len(commits)} commits touch it, {commits[-1][:12]} the last"
        one = f"added by {commits[0][:12]}"
        yield Check(f"{name} was never changed", one if len(commits) == 1 else many,
                    len(commits) == 1 and history.holds(place / name))  # fmt: skip
    firsts = tuple(found[names[0]][0] for names, _, _ in STAGES)
    held = {name: history.blob(commits[0], place / name) for name, commits in found.items()}
    chain = Chain(history, place, firsts, held)
    yield from _order(chain)
    with tempfile.TemporaryDirectory(prefix="proof-") as name:
        folder = Folder(Path(name) / "set")
        write_file(folder.seal, chain.held[SEALED])
        sealed = read_seal(folder.seal)
        package = history.unpack(chain.commits[0], "pyport", Path(name) / "code")
        yield from _code(sealed, package)
        yield from _hashes(chain, sealed, folder)
        if again != 0:
            yield from _again(chain, sealed, folder, package, again, jobs)


def _order(chain: Chain) -> Iterator[Check]:
    """Check that each stage has a commit, after that of the one before, and holds no more."""
    history, place = chain.history, chain.place
    short = " < ".join(one[:12] for one in chain.commits)
    ordered = all(map(history.before, chain.commits, chain.commits[1:]))
    yield Check("sealed, then answered, then opened", short, ordered)
    expected: set[str] = set()
    for commit, (names, _, what) in list(zip(chain.commits, STAGES, strict=True))[:-1]:
        expected |= {*names}
        there = history.files(commit, place)
        said = f"{', '.join(sorted(there))} in {commit[:12]}"
        yield Check(f"{what.lower()}: the set holds no more by then", said, there == expected)
        touched = history.touched(commit)
        said = f"{len(touched)} file" + "s" * (len(touched) > 1)
        yield Check(f"{what.lower()}: a commit of its own", said, len(touched) == len(names))


def _code(sealed: dict[str, Any], package: Path) -> Iterator[Check]:
    """Check that program and examiner are those that stood in the history at the sealing."""
    for who, unit in (("solver", code.SOLVER), ("examiner", code.EXAMINER)):
        parts = code.parts(unit, package)
        said = f"{code.whole(parts)[:16]}, {len(parts)} parts"
        same = code.whole(parts) == sealed[f"{who}_sha256"]
        yield Check(f"the {who} is that of the sealing commit", said, same)


def _hashes(chain: Chain, sealed: dict[str, Any], folder: Folder) -> Iterator[Check]:
    """Check that every file names the one before, and every truth is the one that was sealed.

    Answers and truths are written to the folder on the way.
    """
    (head, *said), (opening, *opened) = (read_lines(chain.held[name]) for name in (ANSWERS, OPENED))
    for what, named, of in (
        ("the answers name the seal", head.get("seal_sha256"), chain.held[SEALED]),
        ("the opening names the answers", opening.get("answers_sha256"), chain.held[ANSWERS]),
    ):
        yield Check(what, str(named)[:16], named == hashlib.sha256(of).hexdigest())
    cases = [one["case"] for one in sealed["cases"]]
    answered = sorted((one["by"], one["case"]) for one in said)
    complete = answered == sorted((by, case) for by in WHO for case in cases)
    yield Check("every case is answered once", f"{len(said)} answers", complete)
    for one in said if complete else ():
        solve.keep(Folder(folder.root, one["by"]), one["case"], one["report"])
    by_case = {one["case"]: one for one in opened}
    right = 0
    for one in sealed["cases"]:
        shown = by_case.get(one["case"])
        if shown and commitment(shown["nonce"], shown["truth"]) == one["truth_commitment"]:
            right += 1
            write_file(folder.opened / f"{one['case']}.truth.json", shown["truth"])
    all_open = right == len(cases) == len(opened)
    yield Check("truths are those sealed", f"{right} of {len(cases)}", all_open)


def _again(
    chain: Chain,
    sealed: dict[str, Any],
    folder: Folder,
    package: Path,
    again: int | None,
    jobs: int,
) -> Iterator[Check]:
    """Make recordings again with the code that was sealed, judge the answers to them, compare."""
    cases = sorted(
        case
        for case, truth in _truths(folder)
        if (data := truth["spec"].get("data")) is None or Path(data).is_dir()
    )
    if absent := len(list(folder.opened.glob("*.json"))) - len(cases):
        said = f"{absent} cases have their noise from public recordings that are not here"
        yield Check("made again as far as can be", said, passed=True)
    if again is not None:
        # A sample that could be foreseen could be cheated.
        cases = sorted(random.SystemRandom().sample(cases, min(again, len(cases))))
    answered = all((folder.root / by).is_dir() for by in WHO)
    if not cases or not answered:
        yield Check("recordings and score made again", "nothing to make them from", passed=False)
        return
    made = _run(folder, package, jobs, cases)
    hashes = {one["case"]: one["recordings_sha256"] for one in sealed["cases"]}
    same = [case for case in cases if made["recordings"][case] == hashes[case]]
    said = f"{len(same)} of {len(cases)}"
    if len(same) < len(cases):
        said += f"; first other one {min({*cases} - {*same})}, sealed with {sealed['libraries']}"
    yield Check("recordings made again are those sealed", said, len(same) == len(cases))
    published = {one["case"]: one for one in read_lines(chain.held[VERDICTS])}
    agree = [one for one in made["verdicts"] if alike(one, published.get(one["case"]))]
    said = f"{len(agree)} of {len(cases)}"
    yield Check("verdicts judged again are those published", said, len(agree) == len(cases))
    if len(cases) == len(sealed["cases"]):
        score = json.loads(chain.held[SCORE])
        for key in ("passed", "table", "beside"):
            said = f"{len(made['table'])} rows" if key == "table" else ""
            yield Check(f"score computed again: {key}", said, made[key] == score[key])
        yield Check("no other verdict", f"{len(published)}", len(published) == len(cases))


def _truths(folder: Folder) -> Iterator[tuple[str, dict[str, Any]]]:
    for path in folder.opened.glob("*.json"):
        yield path.name.removesuffix(".truth.json"), json.loads(path.read_text(encoding="utf-8"))


def _run(folder: Folder, package: Path, jobs: int, cases: list[str]) -> dict[str, Any]:
    # From this folder, where paths of data lead on from, and with none of the code in it.
    words = [sys.executable, "-P", "-m", "pyport.examiner.sealed.again"]
    done = subprocess.run(  # noqa: S603 - the code that was sealed
        [*words, str(folder.root), str(jobs), *cases],
        env={**os.environ, "PYTHONPATH": str(package.parent), "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise BadInput(f"the sealed code ended with: {done.stderr.strip()[-300:]}", package)
    found: dict[str, Any] = json.loads((folder.root / "again.json").read_text(encoding="utf-8"))
    return found


def alike(one: Any, other: Any) -> bool:  # noqa: ANN401 - whatever JSON holds
    """Tell whether two verdicts say the same, numbers to a millionth."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=_ALIKE, abs_tol=_ALIKE)
    return bool(one == other)
