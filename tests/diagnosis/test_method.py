"""The page on the method lists every number that the noise and the diagnosis decide by."""

import ast
from pathlib import Path

import pytest

from pyport.cli.dev.listed import markdown, put_between, read, shipped
from pyport.errors import BadInput

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "method.md"
PACKAGES = ("least_squares", "noise", "diagnosis", "watch")
#: How wide and how long a text is on the terminal: no decision.
LAYOUT = {"_WIDTH", "_SHOWN", "_LIMITS"}
NUMBERS_OF_NUMPY = {"array", "arange", "geomspace"}


def is_number(node):
    """Tell whether an expression is one number, or several in a tuple, a range or an array."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) and is_number(node.right)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.Tuple | ast.List):
        return bool(node.elts) and all(is_number(one) for one in node.elts)
    if isinstance(node, ast.Call):
        called = node.func
        name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
        return name in NUMBERS_OF_NUMPY | {"range"} and all(is_number(one) for one in node.args)
    # Units and other constants: DEG, ARCSEC, np.inf.
    return isinstance(node, ast.Name | ast.Attribute) and (
        getattr(node, "id", "").isupper() or getattr(node, "attr", "") == "inf"
    )


def constants_of(text):
    """Return {name: value as written} of the upper-case numeric constants of a module."""
    found = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            pairs = [(node.target, node.value)]
        elif isinstance(node, ast.Assign):
            pairs = [(target, node.value) for target in node.targets]
        else:
            continue
        for target, value in pairs:
            several = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
            each = zip(target.elts, value.elts, strict=True) if several else [(target, value)]
            for name, own in each:
                if isinstance(name, ast.Name) and name.id.isupper() and is_number(own):
                    found[name.id] = ast.unparse(own)
    return found


def constants():
    """Return {dotted name below pyport: value as written} of the packages that decide."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / "pyport" / package).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT / "pyport").with_suffix("").parts)
            for name, value in constants_of(path.read_text(encoding="utf-8")).items():
                if name not in LAYOUT:
                    found[f"{module}.{name}"] = value
    return found


def listed(text):
    """Return {dotted name: value as written} of the rows of the page's tables."""
    rows = (line.strip().strip("|").split(" | ") for line in text.splitlines())
    return {
        row[0].strip().strip("`"): row[1].strip().strip("`")
        for row in rows
        if len(row) == 5 and row[0].strip().startswith(tuple(f"`{one}." for one in PACKAGES))
    }


CONSTANTS = constants()
LISTED = listed(PAGE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", sorted(CONSTANTS))
def test_every_constant_is_on_the_page_with_its_value(name):
    """A constant that is added, or changed, is missing here until the page says so."""
    assert name in LISTED, f"docs/method.md has no row for `{name}`"
    assert LISTED[name] == CONSTANTS[name]


def test_the_page_lists_nothing_that_is_gone():
    """A constant that was removed or renamed leaves the page, too."""
    assert sorted(set(LISTED) - set(CONSTANTS)) == []


def test_every_listed_constant_has_a_unit_a_decision_and_a_reason():
    """No cell of a row is empty."""
    text = PAGE.read_text(encoding="utf-8")
    rows = [
        line
        for line in text.splitlines()
        if line.startswith(tuple(f"| `{one}." for one in PACKAGES))
    ]

    assert len(rows) == len(LISTED)
    assert all(cell.strip() for row in rows for cell in row.strip().strip("|").split(" | "))


def test_the_table_of_thresholds_is_the_one_that_the_program_prints():
    """After a change: pyport dev thresholds --into docs/method.md."""
    text = PAGE.read_text(encoding="utf-8")

    assert put_between(text, "thresholds", markdown(shipped())) == text


def test_a_threshold_says_its_unit_its_reason_and_both_wrong_sides():
    """A comment that lacks one of them is refused."""
    (found,) = read("#: [m] How far. So. Smaller: too\n#: near. Larger: too far.\nFAR = 2 * NEAR\n")

    assert found.value == "2 * NEAR"
    assert (found.unit, found.decides, found.reason) == ("m", "How far", "So")
    assert (found.smaller, found.larger) == ("too near", "too far")
    with pytest.raises(ValueError, match="FAR"):
        list(read("#: [m] How far. So. Smaller: too near.\nFAR = 2\n"))


def test_a_page_without_marks_is_refused():
    """A table is never written somewhere else."""
    with pytest.raises(BadInput, match="thresholds"):
        put_between("a page", "thresholds", "")


def test_no_threshold_stands_twice():
    """What `pyport.thresholds` has no module of the diagnosis or the noise defines again."""
    names = {one.name for one in shipped()}
    of_rooms = (name for name in CONSTANTS if not name.startswith("watch."))

    assert [name for name in of_rooms if name.rpartition(".")[2] in names] == []


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("LEAST = 2 * OUTLIER", {"LEAST": "2 * OUTLIER"}),
        ("A, B = 1.0, 2 * DEG", {"A": "1.0", "B": "2 * DEG"}),
        ("A: int = 3", {"A": "3"}),
        ("A = np.array([1.0, np.inf])", {"A": "np.array([1.0, np.inf])"}),
        ("A, B = range(1, 5), (1, 2)", {"A": "range(1, 5)", "B": "(1, 2)"}),
        ("WORDS = 'text'", {}),
        ("NAMES = ('one', 'two')", {}),
        ("FLAG = True", {}),
        ("lower = 3", {}),
        ("def f():\n    INSIDE = 3", {}),
    ],
)
def test_numeric_constants_are_recognised(source, found):
    """Numbers, sums of units, tuples and arrays are; texts, flags and local names are not."""
    assert constants_of(source) == found
