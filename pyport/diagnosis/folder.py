"""The folder of a diagnosis: files of one run, and of no other.

report.json is written last and holds the hash of every file beside it. A run
that is killed between two files leaves a folder whose files are not those that
its report names, and that can be seen.
"""

from __future__ import annotations

import json
from collections.abc import Container, Iterable
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.files import sha256, write_whole
from pyport.pointing import kernel

REPORT = "report.json"
#: What a diagnosis writes beside its report.
_COMPANIONS = ("rows.csv", "report.html", "finding-[0-9]*-*.png", "array-places.png")


def finish(folder: Path, report: dict[str, Any], companions: Iterable[Path]) -> dict[str, Any]:
    """Write report.json with what computed it and the hashes of the files beside it; return it.

    What earlier runs left there under names of the program's own is removed.
    """
    files = {path.name: sha256(path) for path in companions}
    whole = report | {"computed_with": kernel.path(), "files": files}
    with write_whole(folder / REPORT) as file:
        json.dump(whole, file, indent=1, allow_nan=False)
        file.write("\n")
    for path in _others(folder, whole["files"]):
        path.unlink(missing_ok=True)
    return whole


def check(folder: Path) -> int:
    """Return how many files stand beside a report, all of them written with it.

    Raises
    ------
    BadInput
        There is no report, or one that names no files, or a file is of another run.
    """
    named = _named(folder / REPORT)
    if not named:
        raise BadInput("no report that names the files beside it: run it again", folder / REPORT)
    for name, expected in sorted(named.items()):
        path = folder / name
        if not path.is_file():
            raise BadInput("this file is missing: run the diagnosis again", path)
        if sha256(path) != expected:
            raise BadInput(
                "this file is not the one that report.json was written with: run the diagnosis"
                " again",
                path,
            )
    for path in _others(folder, named):
        raise BadInput(
            "this file is of another run than report.json: run the diagnosis again", path
        )
    return len(named)


def _others(folder: Path, named: Container[str]) -> list[Path]:
    """Return what stands in a folder under names of a diagnosis's files, and is not named."""
    there = {one for pattern in _COMPANIONS for one in folder.glob(pattern)}
    return sorted(one for one in there if one.name not in named)


def _named(report: Path) -> dict[str, str]:
    """Return name and hash of the files that a report names; nothing where it names none."""
    try:
        files = json.loads(report.read_text(encoding="utf-8"))["files"]
        return {name: str(known) for name, known in files.items() if Path(name).name == name}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}
