"""The cell that a solver sits in: a process that cannot open the vault.

    python -m pyport.examiner.sealed.cell FORBIDDEN MODULE [ARGUMENT...]

Python's audit hooks see every file that the process opens and every folder
that it lists, and cannot be taken away again.
"""

from __future__ import annotations

import os
import runpy
import sys
from pathlib import Path
from typing import Any

_LOOKING = frozenset({"open", "os.listdir", "os.scandir", "glob.glob"})


def forbid(place: Path) -> None:
    """Let this process open nothing in a folder from now on.

    Raises `PermissionError`: from then on, where something in the folder is asked for.
    """
    forbidden = str(place.resolve())

    def look(event: str, arguments: tuple[Any, ...]) -> None:
        if event not in _LOOKING or not isinstance(arguments[0], str | bytes | os.PathLike):
            return
        wanted = os.path.realpath(os.fsdecode(arguments[0]))
        if wanted == forbidden or wanted.startswith(forbidden + os.sep):
            raise PermissionError(f"{wanted}: the truth is sealed")

    sys.addaudithook(look)


if __name__ == "__main__":
    _, shut, module, *rest = sys.argv
    forbid(Path(shut))
    sys.argv = [module, *rest]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
