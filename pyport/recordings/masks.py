"""Masks: which lines of a file are not to be used, kept beside it and undone step by step.

The mask of `night.csv` is `night.csv.mask`; the recordings themselves are
never touched. Every line is a step: `+` masks and `-` unmasks the lines that it
lists, `#` and a checksum of those rows guard against a file that changed, and
what follows `|` is the reason.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.columns import SET_ASIDE
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats.text import read_text
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings

_TITLE = "pyport mask: + masks, - unmasks the lines listed | reason"
_STEP = re.compile(r"([+-]) ([\d\-, ]+) #([0-9a-f]{8}) \| ?(.*)")
#: No more lines than a table can have.
LARGEST_LINE = 10**9


@dataclass(frozen=True)
class Step:
    """A step of a mask: lines masked (or unmasked) together, and why."""

    masks: bool
    lines: tuple[int, ...]
    checksum: str
    reason: str


def path_of(file: Path) -> Path:
    """Return where the mask of a file stands."""
    return file.with_name(f"{file.name}.mask")


def steps(file: Path) -> list[Step]:
    """Return the steps of a file's mask, none where it has no mask.

    Raises `BadInput`: a line of the mask is no step.
    """
    path = path_of(file)
    if not path.is_file():
        return []
    found = []
    for number, text in enumerate(read_text(path).splitlines(), 1):
        if text == _TITLE or not text.strip():
            continue
        match = _STEP.fullmatch(text)
        if match is None:
            wanted = "expected such as '+ 12 40-44 #0123abcd | reason'"
            raise BadInput(f"this is {text[:60]!r}, {wanted}", path, number)
        sign, lines, checksum, reason = match.groups()
        found.append(Step(sign == "+", parse_lines(lines, path, number), checksum, reason))
    return found


def parse_lines(text: str, file: Path | None = None, number: int | None = None) -> tuple[int, ...]:
    """Return the lines that `12 40-44` or `12,40-44` lists.

    Raises `BadInput`: it is no such list.
    """
    found: list[int] = []
    for part in text.replace(",", " ").split():
        first, dash, last = part.partition("-")
        if not first.isdigit() or (dash and not last.isdigit()):
            raise BadInput(f"lines are {text[:40]!r}, expected such as 12,40-44", file, number)
        low, high = int(first), int(last or first)
        if not low <= high <= LARGEST_LINE or high - low > 10**7:
            raise BadInput(f"lines are {text[:40]!r}, expected rising numbers", file, number)
        found += range(low, high + 1)
    if not found:
        raise BadInput("no lines are listed, expected such as 12,40-44", file, number)
    return tuple(sorted(set(found)))


def spelled(lines: Iterable[int]) -> str:
    """Return lines as `12 40-44`."""
    runs: list[list[int]] = []
    for line in sorted(lines):
        if runs and line == runs[-1][-1] + 1:
            runs[-1][1:] = [line]
        else:
            runs.append([line])
    return " ".join("-".join(map(str, run)) for run in runs)


def masked(raw: Raw) -> Raw:
    """Return the cells of a file with what its mask masks excluded, each with its reason.

    Raises `BadInput`: the mask lists a line that is no recording, or one that has changed since.
    """
    reasons = standing(raw, steps(raw.file))
    return set_aside(raw, {n: f"masked: {why}" if why else "masked" for n, why in reasons.items()})


def set_aside(raw: Raw, reasons: Mapping[int, str]) -> Raw:
    """Return the cells of a file with some lines excluded, each with its reason."""
    if not reasons:
        return raw
    recorded = raw.words(SET_ASIDE) if SET_ASIDE in raw.columns else np.full(len(raw.line), "")
    aside = [
        why or reasons.get(line, "") for why, line in zip(recorded, raw.line.tolist(), strict=True)
    ]
    return replace(raw, columns={**raw.columns, SET_ASIDE: np.array(aside, object)})


def standing(raw: Raw, taken: Sequence[Step]) -> dict[int, str]:
    """Return the lines that are masked after these steps, each with its reason."""
    reasons: dict[int, str] = {}
    for number, step in enumerate(taken, 1):
        if checksum(raw, step.lines) != step.checksum:
            wrong = f"step {number} masks lines of {raw.file.name} that have changed since"
            raise BadInput(f"{wrong}: undo it, or delete the mask", path_of(raw.file))
        for line in step.lines:
            if step.masks:
                reasons[line] = step.reason
            else:
                reasons.pop(line, None)
    return reasons


def checksum(raw: Raw, lines: Sequence[int]) -> str:
    """Return a checksum of the cells of some lines; of a line that is no recording, of nothing."""
    rows = np.flatnonzero(np.isin(raw.line, lines))
    cells = [
        [str(cell) for cell in column[rows].tolist()]
        for name, column in raw.columns.items()
        if name != SET_ASIDE
    ]
    text = repr((raw.line[rows].tolist(), cells))
    return f"{zlib.crc32(text.encode()):08x}"


def add(raw: Raw, lines: Sequence[int], reason: str, *, masks: bool = True) -> Step:
    """Mask (or unmask) some lines of a file as a further step of its mask.

    Raises `BadInput`: one of the lines is no recording.
    """
    known = set(raw.line.tolist())
    strange = [line for line in lines if line not in known]
    if strange:
        raise BadInput(f"line {strange[0]} is no recording of this file", raw.file, strange[0])
    step = Step(masks, tuple(lines), checksum(raw, lines), " ".join(reason.split()))
    write(raw.file, [*steps(raw.file), step])
    return step


def undo(file: Path) -> Step:
    """Take back the last step of a file's mask.

    Raises `BadInput`: there is no step.
    """
    taken = steps(file)
    if not taken:
        raise BadInput("no step of a mask to undo", file)
    write(file, taken[:-1])
    return taken[-1]


def write(file: Path, taken: Sequence[Step]) -> None:
    """Write the steps of a file's mask; without any the mask is removed."""
    path = path_of(file)
    if not taken:
        path.unlink(missing_ok=True)
        return
    with write_whole(path) as out:
        out.write(_TITLE + "\n")
        for step in taken:
            sign = "+" if step.masks else "-"
            out.write(f"{sign} {spelled(step.lines)} #{step.checksum} | {step.reason}\n")


#: Odd multipliers that spread the bits of a row's numbers over one word.
_SPREAD = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93, 1)


def repeated(raw: Raw, recordings: Recordings) -> dict[int, int]:
    """Return the rows that repeat an earlier one in every cell, and the line of that one.

    Only rows that tell their time: two measurements of one moment, place, antenna
    and value are one. Without a time equal rows may be two measurements.

    `raw`: the cells of a file, n rows.
    `recordings`: what they mean, none of the n excluded yet.
    """
    at = recordings.at
    if "time" not in at:
        return {}
    time = at.column("time")
    suspects = np.flatnonzero(_shared(time, at.az, at.el, recordings.x, recordings.y))
    suspects = suspects[np.isfinite(time[suspects])]
    first: dict[tuple[str, ...], int] = {}
    found: dict[int, int] = {}
    for row in suspects.tolist():
        cells = tuple(str(column[row]) for column in raw.columns.values())
        earlier = first.setdefault(cells, row)
        if earlier != row:
            found[row] = int(raw.line[earlier])
    return found


def _shared(*columns: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell the rows whose numbers may be those of another row, shape (n,)."""
    mixed = np.zeros(len(columns[0]), np.uint64)
    for column, factor in zip(columns, _SPREAD, strict=True):
        bits = (np.nan_to_num(column) + 0.0).view(np.uint64)
        mixed = (mixed ^ bits) * np.uint64(factor)
        mixed ^= mixed >> np.uint64(29)
    order = np.argsort(mixed)
    same = np.diff(mixed[order]) == 0
    shared = np.zeros(len(mixed), bool)
    shared[order[1:][same]] = True
    shared[order[:-1][same]] = True
    return shared
