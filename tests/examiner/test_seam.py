"""The examiner does not share the pupil's notes."""

import ast
from pathlib import Path

import pytest

import pyport.examiner

ROOT = Path(pyport.examiner.__file__).parent
#: Part -> what of the program outside the examiner its files may import. `acceptance` calls the
#: steps of a diagnosis, whose figures it prints: it draws and judges nothing.
ALLOWED = {
    "worlds": {"angles", "errors", "files"},
    "sealed": {"angles", "errors", "files", "runs"},
    "nights": {"", "errors"},
    "nulls": {"errors"},
    "mounts": set(),
    "ideal": {"angles", "thresholds"},
    "real": {"angles", "errors", "files"},
    "baselines.py": {"errors"},
    "scores.py": set(),
    "program.py": {"", "errors"},
    "__init__.py": set(),
}


def imported(path):
    """Return the full names of everything that a file imports, wherever in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import hides where it leads"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def rooms(path):
    """Return the rooms of the program outside the examiner that a file imports."""
    names = [name.split(".") for name in imported(path)]
    return {"".join(name[1:2]) for name in names if name[0] == "pyport"} - {"examiner"}


def test_every_part_is_held_to_something():
    """A new part of the examiner needs a line above."""
    parts = {path.name for path in ROOT.iterdir() if path.name != "__pycache__"}

    assert parts == {*ALLOWED, "acceptance"}


@pytest.mark.parametrize("part", sorted(ALLOWED))
def test_what_draws_and_judges_imports_nothing_of_the_solver(part):
    """Only `program` calls it, through the public API."""
    at = ROOT / part
    for path in at.rglob("*.py") if at.is_dir() else [at]:
        assert rooms(path) <= ALLOWED[part], path


def test_the_test_sees_imports_inside_functions(tmp_path):
    """An import that is hidden in a function is found too."""
    path = tmp_path / "sly.py"
    path.write_text("def f():\n    from pyport import effects\n")

    assert rooms(path) == {"effects"}
