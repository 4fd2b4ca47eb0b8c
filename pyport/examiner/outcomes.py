"""Cases put to the program: outcomes are kept, and a run that was stopped goes on."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pyport.examiner import program

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Case = TypeVar("Case", bound="DataclassInstance")
Outcome = dict[str, Any]


def run(
    wanted: Sequence[Case], examine: Callable[[Case], Outcome], file: Path, jobs: int = 1
) -> Iterator[Outcome]:
    """Yield what comes out of every case: what the file has of this program, then the others.

    Cases are frozen dataclasses of numbers and texts, whose fields are part of the outcome.
    Every outcome is appended to the file as soon as it is there; a run that was killed goes on.
    """
    kept = read(file, type(wanted[0])) if wanted else {}
    rest = []
    for case in wanted:
        if (outcome := kept.get(case)) is None:
            rest.append(case)
        else:
            yield outcome
    file.parent.mkdir(parents=True, exist_ok=True)
    for outcome in _outcomes(rest, examine, jobs):
        with file.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(outcome) + "\n")
        yield outcome


def _outcomes(
    rest: Sequence[Case], examine: Callable[[Case], Outcome], jobs: int
) -> Iterator[Outcome]:
    if jobs == 1:
        yield from map(examine, rest)
        return
    with ProcessPoolExecutor(jobs) as pool:
        for done in as_completed([pool.submit(examine, case) for case in rest]):
            yield done.result()


def read(file: Path, kind: type[Case]) -> dict[Case, Outcome]:
    """Return the outcomes that a file has of the present program; a line cut short is none."""
    found: dict[Case, Outcome] = {}
    if not file.is_file():
        return found
    for line in file.read_text(encoding="utf-8").splitlines():
        try:
            outcome = json.loads(line)
        except ValueError:
            continue
        if outcome.get("program") == program.version():
            names = [field.name for field in dataclasses.fields(kind)]
            found[kind(*(outcome[name] for name in names))] = outcome
    return found
