"""The examiner does not share the pupil's notes."""

import ast
from pathlib import Path

import pyport.trials

FORBIDDEN = ("effects", "pointing", "fitting", "diagnosis", "legacy", "steering", "report")


def imported(path: Path) -> set[str]:
    """Return the full names of everything that a file imports, wherever in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import hides where it leads"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def test_no_file_of_the_trials_imports_what_is_on_trial():
    """Effects, pointing, fitting and diagnosis are not imported, nor anything built on them."""
    for path in Path(pyport.trials.__file__).parent.rglob("*.py"):
        for name in imported(path):
            for room in FORBIDDEN:
                assert not f"{name}.".startswith(f"pyport.{room}."), f"{path}: {name}"


def test_the_test_sees_imports_inside_functions(tmp_path):
    """An import that is hidden in a function is found too."""
    path = tmp_path / "sly.py"
    path.write_text("def f():\n    from pyport import effects\n")

    assert imported(path) == {"pyport.effects"}
