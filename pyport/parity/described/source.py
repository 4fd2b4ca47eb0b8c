"""What the text of Fortran files says beyond what NumPy's crackfortran reports."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pyport.arguments import nearest
from pyport.errors import BadInput


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


#: Marks what `pyport parity init` could not find out.
UNKNOWN = "?"

_HEADER = re.compile(r"\s*\[+\s*([\w.\-\"]+)\s*\]+")
_KEY = re.compile(r"\s*\"?([\w\-]+)\"?\s*=")
NUMBERS = (int, float)


class Lines:
    """Where each table of a file begins, and its keys; tables of one name in their order."""

    def __init__(self, text: str):
        self.tables: dict[str, list[dict[str, int]]] = {"": [{"": 1}]}
        keys = self.tables[""][0]
        for number, line in enumerate(text.splitlines(), start=1):
            if header := _HEADER.match(line):
                keys = {"": number}
                self.tables.setdefault(header[1], []).append(keys)
            elif key := _KEY.match(line):
                keys.setdefault(key[1], number)


class Table:
    """One table of the file, whose keys are taken one by one."""

    def __init__(self, path: Path, lines: Lines, name: str, number: int, content: dict[str, Any]):
        self.path, self.lines, self.name, self.content = path, lines, name, dict(content)
        tables = lines.tables.get(name, [])
        self.keys = tables[number] if number < len(tables) else {}

    def wrong(self, text: str, key: str = "") -> BadInput:
        """Return the error at a key."""
        place = f"[{self.name}]: " if self.name else ""
        return BadInput(place + text, self.path, self.keys.get(key, self.keys.get("", 1)))

    def take(self, key: str, kind: type | tuple[type, ...], default: Any = ...) -> Any:  # noqa: ANN401
        """Return and remove a value of the right type."""
        if key not in self.content:
            if default is ...:
                raise self.wrong(f"`{key}` is missing")
            return default
        value = self.content.pop(key)
        if isinstance(value, str) and value.strip() == UNKNOWN:
            raise self.wrong(f"`{key}` is still {UNKNOWN!r}: fill in what init could not tell", key)
        right = isinstance(value, kind) and not (isinstance(value, bool) and kind is not bool)
        if not right:
            names = " or ".join(
                one.__name__ for one in (kind if isinstance(kind, tuple) else (kind,))
            )
            raise self.wrong(f"`{key}` = {value!r}: expected {names}", key)
        return value

    def words(self, key: str, default: tuple[str, ...] = ()) -> tuple[str, ...]:
        """Return and remove a list of texts."""
        value = self.take(key, list, list(default))
        if not all(isinstance(one, str) for one in value):
            raise self.wrong(f"`{key}` = {value!r}: expected a list of texts", key)
        return tuple(value)

    def pair(self, key: str) -> tuple[float, float] | None:
        """Return and remove two numbers, the lower one first."""
        value = self.take(key, list, None)
        if value is None:
            return None
        good = len(value) == 2 and all(_number(one) for one in value) and value[0] <= value[1]
        if not good:
            raise self.wrong(f"`{key}` = {value!r}: expected [LOW, HIGH], two numbers", key)
        return float(value[0]), float(value[1])

    def paths(self, key: str) -> tuple[Path, ...]:
        """Return and remove names of files, from the folder of the description."""
        return tuple(self.path.parent / one for one in self.words(key))

    def callable(self, key: str, text: str) -> str:
        """Return a ``module:function``."""
        if not re.fullmatch(r"[\w.]+:\w+", text):
            raise self.wrong(f"`{key}` = {text!r}: expected 'module:function'", key)
        return text

    def tables(self, key: str) -> list[dict[str, Any]]:
        """Return and remove a list of tables."""
        value = self.take(key, list, [])
        if not all(isinstance(one, dict) for one in value):
            raise self.wrong(f"`{key}`: expected tables, [[{key}]]", key)
        return value

    def done(self, known: str) -> None:
        """Refuse the keys that are left; name the one that was meant."""
        for key in self.content:
            near = nearest(key, known.split())
            meant = f"did you mean `{near}`?" if near else f"expected one of {known}"
            raise self.wrong(f"`{key}` is not known: {meant}", key)


def _number(value: object) -> bool:
    return isinstance(value, NUMBERS) and not isinstance(value, bool) and not math.isnan(value)
