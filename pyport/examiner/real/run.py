"""Every set, one after the other or several at a time."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from pyport.examiner import program
from pyport.examiner.real import sets
from pyport.examiner.real.measures import Row, measure
from pyport.examiner.real.published import Check


def chosen(names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the sets whose names begin with one of some, all for none.

    Raises `KeyError`: no set's name begins so.
    """
    entries = sets.catalogue()
    for name in names:
        if not any(one["name"].lower().startswith(name.lower()) for one in entries):
            raise KeyError(name)
    begins = tuple(name.lower() for name in names) or ("",)
    return [one for one in entries if one["name"].lower().startswith(begins)]


def rows(
    entries: list[dict[str, Any]], data: Path | None, subsets: int, file: Path, jobs: int = 1
) -> Iterator[Row | str]:
    """Yield what came out of each set, or why it could not be examined.

    Every row is appended to the file as soon as it is there, and what the file has of the present
    program is not done again: a run that was stopped goes on.
    """
    kept = read(file, subsets)
    rest = [one for one in entries if one["name"] not in kept]
    yield from (kept[one["name"]] for one in entries if one["name"] in kept)
    call = partial(_row, data=data, subsets=subsets)
    for row in _each(call, rest, jobs):
        if isinstance(row, Row):
            file.parent.mkdir(parents=True, exist_ok=True)
            told = {"program": program.version(), "subsets": subsets, "row": asdict(row)}
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(told) + "\n")
        yield row


def read(file: Path, subsets: int) -> dict[str, Row]:
    """Return the rows that a file has of the present program and as many subsets."""
    found: dict[str, Row] = {}
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else ():
        try:
            told = json.loads(line)
        except ValueError:
            continue
        if (told["program"], told["subsets"]) == (program.version(), subsets):
            found[told["row"]["name"]] = _row_of(told["row"])
    return found


def _row_of(told: dict[str, Any]) -> Row:
    lists: dict[str, Any] = {
        key: tuple(one) if isinstance(one, list) else one for key, one in told.items()
    }
    lists["checks"] = tuple(Check(**one) for one in told["checks"])
    return Row(**lists)


def _each(
    call: Callable[[dict[str, Any]], Row | str], entries: list[dict[str, Any]], jobs: int
) -> Iterator[Row | str]:
    if jobs == 1:
        yield from map(call, entries)
        return
    with ProcessPoolExecutor(jobs) as pool:
        for done in as_completed([pool.submit(call, one) for one in entries]):
            yield done.result()


def _row(entry: dict[str, Any], data: Path | None, subsets: int) -> Row | str:
    recordings = sets.read(entry, data)
    if isinstance(recordings, str):
        return f"{entry['name']}: {recordings}"
    return measure(recordings, subsets)
