"""Which code a seal speaks of: what turns recordings into a report, and what draws and judges.

A part's hash is that of its syntax without comments, docstrings and layout, so that words about
the code void no proof, while any change of what it does is another program.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from pyport.files import sha256

PACKAGE = Path(__file__).parents[3]
#: What modules of a room read beside Python.
_DATA = frozenset({".c", ".h", ".csv", ".toml"})


@dataclass(frozen=True)
class Unit:
    """Code that is sealed as one: modules, and all that they import of the package.

    `roots`: where it begins, dotted names without the package's.
    `without`: rooms that are not entered: they draw what is said and decide nothing of it.
    """

    roots: tuple[str, ...]
    without: frozenset[str] = frozenset()


#: From a file of recordings to report.json, as `pyport diagnose` goes.
SOLVER = Unit(("pipeline",), frozenset({"page", "plots"}))
#: What draws cases, hides, opens, judges and scores them, and the baselines.
EXAMINER = Unit(("examiner.sealed.again", "examiner.sealed.cell"))


def parts(unit: Unit, package: Path = PACKAGE) -> dict[str, str]:
    """Return the SHA-256 of every part of a unit by its path in the package.

    Parts are the modules that the roots reach by imports, wherever in a file these stand, all of a
    room that imports by name, and the data that lie in the rooms of those modules.

    `package`: the folder of the package, this one or another checkout's.
    """
    files = modules(package)
    found: dict[str, str] = {}
    rooms: set[str] = set()
    queue = [f"{package.name}.{root}" for root in unit.roots]
    while queue:
        name = queue.pop()
        place = files[name].relative_to(package)
        room = place.parts[0]
        if place.as_posix() in found or room in unit.without:
            continue
        tree = ast.parse(files[name].read_text(encoding="utf-8"))
        found[place.as_posix()] = hashlib.sha256(spelled(tree).encode()).hexdigest()
        rooms.add(room)
        queue += imported(tree, package.name, files)
        if by_name(tree):
            queue += [one for one in files if one.rpartition(".")[0] == name]
        parent = name.rpartition(".")[0]
        queue += [parent] if parent != package.name else []
    for room in rooms:
        for path in (package / room).rglob("*"):
            if path.suffix in _DATA and path.is_file():
                found[path.relative_to(package).as_posix()] = sha256(path)
    return dict(sorted(found.items()))


def whole(parts_: dict[str, str]) -> str:
    """Return one SHA-256 for all parts: of their lines as sha256sum prints them."""
    lines = "".join(f"{digest}  {path}\n" for path, digest in parts_.items())
    return hashlib.sha256(lines.encode()).hexdigest()


def changes(before: dict[str, str], now: dict[str, str]) -> list[str]:
    """Return a line for every part that is new, gone or not what it was."""
    lines = [f"new: {path}" for path in sorted(now.keys() - before.keys())]
    lines += [f"gone: {path}" for path in sorted(before.keys() - now.keys())]
    both = sorted(before.keys() & now.keys())
    return lines + [f"changed: {path}" for path in both if before[path] != now[path]]


def modules(package: Path) -> dict[str, Path]:
    """Return the file of every module of a package by its dotted name."""
    names = {}
    for path in sorted(package.rglob("*.py")):
        words = path.relative_to(package.parent).with_suffix("").parts
        names[".".join(words[:-1] if words[-1] == "__init__" else words)] = path
    return {name: path for name, path in names.items() if "fortran" not in name.split(".")}


def imported(tree: ast.Module, package: str, known: Collection[str]) -> Iterator[str]:
    """Yield the known modules that a file imports, wherever in it; not the package itself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [(alias.name, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [(f"{node.module}.{alias.name}", node.module) for alias in node.names]
        else:
            continue
        for longest, home in names:
            name = longest if longest in known else home
            # The package itself imports nothing before it is asked for a name.
            if name in known and name != package:
                yield name


def by_name(tree: ast.Module) -> bool:
    """Tell whether a file imports by a name that it makes up: any module of its room, then."""
    return any(
        getattr(node, "attr", getattr(node, "id", "")) == "import_module" for node in ast.walk(tree)
    )


def spelled(node: object) -> str:
    """Return syntax as text that is the same in every version of Python.

    Texts that are statements are left out, and what some versions have more of: empty lists, and
    empty texts between the braces of an f-string.
    """
    if isinstance(node, list):
        return "[" + ",".join(spelled(one) for one in node if not _is_comment(one)) + "]"
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = dict(ast.iter_fields(node))
    if isinstance(node, ast.JoinedStr):
        fields["values"] = [one for one in node.values if getattr(one, "value", None) != ""]
    some = (f"{name}={spelled(one)}" for name, one in fields.items() if one != [])
    return f"{type(node).__name__}({','.join(some)})"


def _is_comment(node: object) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
