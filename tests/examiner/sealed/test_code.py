"""What is sealed as the program: its code, whatever is written about it."""

import ast

import pytest

from pyport.examiner.sealed.record import code

FILES = {
    "__init__.py": "",
    "start.py": "from pkg.room import one\n\ndef f():\n    import pkg.shown.page\n",
    "alone.py": "x = 1\n",
    "room/__init__.py": "",
    "room/one.py": '"""Do."""\nfrom pkg.room.two import y  # why\n',
    "room/two.py": "y = 2\n",
    "room/never.py": "z = 3\n",
    "room/data/list.csv": "a\n1\n",
    "shown/__init__.py": "",
    "shown/page.py": "",
}
UNIT = code.Unit(("start",), frozenset({"shown"}))


@pytest.fixture
def package(tmp_path):
    """Return the folder of a small package."""
    for name, text in FILES.items():
        path = tmp_path / "pkg" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "pkg"


def test_a_unit_is_what_its_roots_import(package):
    """Modules by import, packages on the way to them, data of their rooms; no more."""
    found = code.parts(UNIT, package)

    assert [*found] == [
        "room/__init__.py",
        "room/data/list.csv",
        "room/one.py",
        "room/two.py",
        "start.py",
    ]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("room/one.py", '"""Do it better."""\nfrom pkg.room.two import (\n    y)\n'),
        ("room/never.py", "z = 4\n"),
        ("shown/page.py", "w = 5\n"),
        ("alone.py", "x = 6\n"),
    ],
)
def test_words_and_what_is_not_reached_void_nothing(package, name, text):
    """Docstrings, comments, layout, the page, and modules that nothing here imports."""
    before = code.parts(UNIT, package)
    (package / name).write_text(text)

    assert code.whole(code.parts(UNIT, package)) == code.whole(before)


@pytest.mark.parametrize(
    ("name", "text", "change"),
    [
        ("room/two.py", "y = 3\n", ["changed: room/two.py"]),
        ("room/data/list.csv", "a\n2\n", ["changed: room/data/list.csv"]),
        (
            "room/one.py",
            "import pkg.alone\nimport pkg.room.two\n",
            ["new: alone.py", "changed: room/one.py"],
        ),
        (
            "start.py",
            "import pkg.room\n",
            ["gone: room/one.py", "gone: room/two.py", "changed: start.py"],
        ),
    ],
)
def test_a_change_of_code_is_another_program(package, name, text, change):
    """It is named by its file."""
    before = code.parts(UNIT, package)
    (package / name).write_text(text)
    now = code.parts(UNIT, package)

    assert code.whole(now) != code.whole(before)
    assert code.changes(before, now) == change


@pytest.mark.slow
def test_the_program_is_what_decides_and_not_what_shows():
    """Noise, fits, effects and the diagnosis are in it; pages, commands and this test are not."""
    rooms = {path.split("/")[0] for path in code.parts(code.SOLVER)}

    assert {"noise", "fitting", "effects", "diagnosis", "recordings", "thresholds.py"} <= rooms
    assert not rooms & {"page", "plots", "cli", "watch", "studies", "examiner", "__init__.py"}


@pytest.mark.slow
def test_the_examiner_draws_judges_and_scores():
    """Its pages are not in it."""
    found = code.parts(code.EXAMINER)

    assert {
        f"examiner/sealed/{name}.py" for name in ("protocol", "scoring/judge", "scoring/score")
    } <= {*found}
    assert "examiner/worlds/kinds.py" in found
    pages = {f"examiner/sealed/scoring/{name}.py" for name in ("page", "sections", "figures")}
    assert not pages & {*found}


SAMPLE = '''
def f(x: int, *, y=()) -> None:
    """Say."""
    return f"{x!r:>3}{y}" or [], "", 1e-3
'''


def test_every_version_of_python_spells_code_alike():
    """The text is fixed: an f-string, an empty list, an annotation."""
    assert code.whole({"f": code.spelled(ast.parse(SAMPLE))}) == (
        "7765ee140dc2c15c2aac680b2ad7fd950dbf37265289f5e4e0dcb6432b4dafa2"
    )


def test_a_room_that_imports_by_name_is_sealed_whole(package):
    """Which of its modules it will ask for is not written anywhere."""
    (package / "room" / "__init__.py").write_text(
        "import importlib\nfor name in 'never':\n    importlib.import_module(name)\n"
    )

    assert "room/never.py" in code.parts(UNIT, package)
