"""The program under examination, called through its public API and nothing else."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

#: A file of recordings or its columns, as the public API takes them.
Table = str | Path | Mapping[str, Any]
Header = Mapping[str, float | str]


@dataclass(frozen=True)
class Refused:
    """What the program said of recordings that it could not use."""

    why: str


def diagnosed(
    table: Table, header: Header | None = None, model: str = "altaz"
) -> dict[str, Any] | Refused:
    """Return the report of a diagnosis, as report.json holds it."""
    import pyport
    from pyport.errors import BadInput

    try:
        return pyport.diagnose(_given(table), model, header=header).report
    except BadInput as error:
        return Refused(str(error))


def fitted(
    table: Table, header: Header | None = None, model: str = "altaz"
) -> dict[str, Any] | Refused:
    """Return a fit, as fit.json holds it."""
    import pyport
    from pyport.errors import BadInput

    try:
        return pyport.fit(_given(table), model, header=header).report
    except BadInput as error:
        return Refused(str(error))


def _given(table: Table) -> Table:
    return str(table) if isinstance(table, Path) else table


@functools.cache
def version() -> str:
    """Return a hash of every source file of the program: another program, other answers."""
    import pyport

    root = Path(pyport.__file__).parent
    text = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        text.update(str(file.relative_to(root)).encode())
        text.update(file.read_bytes())
    return text.hexdigest()[:16]


def shipped(name: str) -> Path:
    """Return the file of recordings that come with the program."""
    import pyport

    return Path(pyport.__file__).parent / "recordings" / "gmrt" / "data" / f"{name}.csv"
