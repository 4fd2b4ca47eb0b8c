"""Apply unified diffs strictly: every line of context where the patch says, or nothing at all.

`patch` is not on every machine, and forgives what must not be forgiven here (fuzz, offsets).
"""

from __future__ import annotations

import re
from pathlib import Path

HUNK = re.compile(r"@@ -(\d+)(?:,(\d+))? \+\d+(?:,\d+)? @@")
TARGET = re.compile(r"^\+\+\+ (?:\S*/)?(\S+)", re.MULTILINE)


class PatchDoesNotApply(Exception):  # noqa: N818 - reads as the sentence it is
    """A patch whose context is not what the file holds."""


def apply_patch(lines: list[str], patch: str) -> list[str]:
    """Return `lines` (without newlines) changed by a unified diff of one file."""
    rows = patch.splitlines()
    first = next((i for i, row in enumerate(rows) if HUNK.match(row)), len(rows))
    result: list[str] = []
    position = 0
    for number, row in enumerate(rows[first:], start=first + 1):
        if header := HUNK.match(row):
            start = int(header[1]) - (header[2] != "0")
            result += lines[position:start]
            position = start
            continue
        mark, text = row[:1], row[1:]
        if not mark or mark not in " -+":
            raise PatchDoesNotApply(f"line {number}: neither context nor change: {row!r}")
        if mark != "+":
            if lines[position : position + 1] != [text]:
                raise PatchDoesNotApply(
                    f"line {number}: line {position + 1} of the source is not {text!r}"
                )
            position += 1
        if mark != "-":
            result.append(text)
    return result + lines[position:]


def patched(source: Path, patches: list[Path]) -> str:
    """Return the text of `source` changed by those of the patches that name it, in order."""
    lines = source.read_text(encoding="ascii").splitlines()
    for path in patches:
        text = path.read_text(encoding="ascii")
        target = TARGET.search(text)
        if target is None:
            raise PatchDoesNotApply(f"{path}: no '+++ FILE' line")
        if target[1] == source.name:
            try:
                lines = apply_patch(lines, text)
            except PatchDoesNotApply as error:
                raise PatchDoesNotApply(f"{path}: {error}") from None
    return "\n".join(lines) + "\n"
