"""What the text of Fortran files says beyond what NumPy's crackfortran reports."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path


def _text(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8", errors="replace").splitlines()


def _statements(path: Path) -> list[str]:
    """Return the statements of a file, in upper case, continuation lines joined, no comments."""
    free = path.suffix.lower() in {".f90", ".f95", ".f03", ".f08"}
    found: list[str] = []
    open_ = False
    for row in _text(path):
        if not free and row[:1] in {"c", "C", "*", "!"}:
            continue
        line = re.sub(r"!.*", "", re.sub(r"'[^']*'", "''", row)).rstrip()
        if not line.strip():
            continue
        continued = open_ if free else bool(re.match(r"     [^ 0]", line))
        body = line.strip() if free or not continued else line[6:]
        open_ = free and body.endswith("&")
        body = body.strip("&").strip().upper()
        if continued and found:
            found[-1] += body
        else:
            found.append(re.sub(r"^\d+\s+", "", body))
    return found


def pieces(path: Path) -> dict[str, list[str]]:
    """Return the statements of each subprogram of a file by its name."""
    pieces: dict[str, list[str]] = {}
    name = ""
    for statement in _statements(path):
        head = re.match(r"(?:[\w\s*()]*?)\b(?:SUBROUTINE|FUNCTION)\s+(\w+)", statement)
        if head and not statement.startswith("END"):
            name = head[1]
            pieces[name] = []
        elif name:
            pieces[name].append(statement)
    return pieces


def included(path: Path, folder: Path) -> Iterable[str]:
    """Yield the files that a file INCLUDEs, from a folder."""
    for row in _text(path):
        if found := re.match(r"\s*INCLUDE\s*['\"]([^'\"]+)['\"]", row, re.IGNORECASE):
            yield os.path.relpath(path.parent / found[1], folder)


def uses(statements: list[str], name: str) -> tuple[bool, bool, bool]:
    """Return whether a name is read before it is set, whether it is set, passed to a routine."""
    read = written = passed = False
    word = re.compile(rf"(?<![\w.]){name}(?!\w)")
    declaration = re.compile(
        r"(REAL|INTEGER|DOUBLE|LOGICAL|CHARACTER|COMMON|DIMENSION|IMPLICIT|EXTERNAL|SAVE|DATA|"
        r"PARAMETER|INTRINSIC|INCLUDE|ENTRY|EQUIVALENCE|FORMAT)\b(?!\s*=)"
    )
    for statement in statements:
        if declaration.match(statement) or not word.search(statement):
            continue
        if call := re.match(r"(?:IF\s*\(.*\)\s*)?CALL\s+\w+\s*\((.*)\)$", statement):
            passed |= bool(word.search(call[1]))
            continue
        assigned = re.match(
            rf"((?:IF\s*\(.*\)\s*)?)(?:{name})\s*(\((?:[^()]|\([^()]*\))*\))?\s*=(?!=)(.*)",
            statement,
        )
        if assigned:
            if not written and word.search(assigned[1] + (assigned[2] or "") + assigned[3]):
                read = True
            written = True
        elif not written:
            read = True
    return read, written, passed
