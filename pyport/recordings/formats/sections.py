"""The `$section` lines that the Field System's pointing files are made of."""

from __future__ import annotations

from pathlib import Path

from pyport.errors import BadInput
from pyport.recordings.formats.lines import Line, lines_of


def sections(path: Path) -> dict[str, list[Line]]:
    """Return the lines of every section under its name; comments (`*`) and blanks are left out.

    Raises `BadInput`: the file holds no section, or one of them twice.
    """
    found: dict[str, list[Line]] = {}
    current: list[Line] = []
    for line in lines_of(path):
        text = line.text.strip()
        if text.startswith("$"):
            name = text[1:].split()[0].lower() if text[1:].split() else ""
            if name in found:
                raise line.error(f"a second section ${name}, expected one")
            current = found[name] = []
        elif text and not text.startswith("*"):
            current.append(line)
    if not found:
        raise BadInput("no line begins with $, expected sections such as $data", path)
    return found


def section(found: dict[str, list[Line]], name: str, path: Path) -> list[Line]:
    """Return a section's lines.

    Raises `BadInput`: there is none, or it is empty.
    """
    if not found.get(name):
        raise BadInput(f"no section ${name} with lines in it, expected one", path)
    return found[name]
