"""`pyport dev imports`: which part of the program imports which, floor by floor."""

from __future__ import annotations

import ast
import sys
from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import click

from pyport.cli.manners import in_json, say
from pyport.examiner.sealed.record.code import imported, modules

#: The floors, from the ground up: a room imports rooms of floors below its own, and nothing else.
FLOORS = (
    ("angles", "errors", "files", "toml_text"),
    ("arguments", "runs", "thresholds"),
    ("mounts",),
    ("columns",),
    ("effects", "least_squares"),
    ("legacy", "pointing", "recordings"),
    ("models",),
    ("formats",),
    ("correction", "noise", "steering"),
    ("fitting",),
    ("diagnosis", "prediction"),
    ("report",),
    ("page", "planning"),
    ("plots",),
    ("pipeline", "watch"),
    ("answers",),
    ("api",),
    ("parity", "studies"),
    ("examiner",),
    ("cli",),
    ("__main__",),
)

Imports = Mapping[str, frozenset[str]]


def imports(package: Path) -> dict[str, frozenset[str]]:
    """Return for each module of a package, by dotted name, those of it that its text imports.

    Imports inside functions and for annotations alone count like any other.
    """
    files = modules(package)
    return {
        name: frozenset(imported(ast.parse(path.read_text(encoding="utf-8")), package.name, files))
        - {name}
        for name, path in files.items()
    }


def room(module: str) -> str:
    """Return the part of the package that a module stands in."""
    return module.split(".")[1] if "." in module else ""


def arrows(found: Imports) -> dict[str, set[str]]:
    """Return for each room the rooms that it imports."""
    out: dict[str, set[str]] = {}
    for module, others in found.items():
        if room(module):
            out.setdefault(room(module), set()).update(map(room, others))
    return {one: others - {one} for one, others in out.items()}


def faults(found: Imports) -> list[str]:
    """Return a line for every import that does not lead to a floor below, and for a circle."""
    floor = {name: number for number, rooms in enumerate(FLOORS) for name in rooms}
    lines = [f"{name} stands on no floor" for name in sorted(arrows(found)) if name not in floor]
    for module, others in sorted(found.items()):
        here = floor.get(room(module), len(FLOORS))
        climbing = (one for one in sorted(others) if room(one) != room(module))
        # On the ground the circles alone count.
        lines += [
            f"{module} imports {one}, which is not below it"
            for one in climbing
            if floor.get(room(one), -1) >= max(here, 1)
        ]
    try:
        TopologicalSorter(found).prepare()
    except CycleError as circle:
        lines.append(f"a circle: {' > '.join(circle.args[1])}")
    return lines


def picture(package: Path, found: Imports) -> str:
    """Return the floors from the top, with files, lines and arrows of each room."""
    leads = arrows(found)
    lines: list[str] = []
    of_all = [0, 0]
    for rooms in reversed(FLOORS):
        for one in (name for name in rooms if name in leads):
            at = package / one
            files = sorted(at.rglob("*.py")) if at.is_dir() else [at.with_suffix(".py")]
            files = [path for path in files if "fortran" not in path.parts]
            count = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)
            ground = {name for floor in FLOORS[:2] for name in floor}
            to = " ".join(sorted(leads[one] - ground)) or "-"
            of_all = [of_all[0] + len(files), of_all[1] + count]
            lines.append(f"{one:14}{len(files):4} files {count:6} lines  -> {to}")
        lines.append("")
    lines.append(f"{'all':14}{of_all[0]:4} files {of_all[1]:6} lines")
    return "\n".join(lines).strip()


@click.command("imports", epilog="Example: pyport dev imports")
@in_json
def command(*, as_json: bool) -> None:
    """Print which part of the program imports which, from the top floor down.

    Exit status 1 where an import leads up, or in a circle.
    """
    import pyport

    package = Path(pyport.__file__).parent
    found = imports(package)
    wrong = faults(found)
    answer = {"imports": {name: sorted(to) for name, to in found.items()}, "faults": wrong}
    say(lambda: picture(package, found), answer, as_json=as_json)
    if wrong:
        click.echo("\n".join(wrong), err=True)
        sys.exit(1)
