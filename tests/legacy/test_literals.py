"""Every constant of the Fortran stands in the port, with its kind; and the port has no other."""

import ast
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from pyport import legacy
from pyport.parity.compiled.build import patched

FORTRAN = Path(__file__).parents[2] / "legacy_fortran"
PORT = Path(legacy.__file__).parent

#: A number: digits, perhaps a fraction, perhaps an exponent; no part of a name or an operator.
NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d*(?![a-z]{2}))?(?:d[+-]?\d+)?)", re.IGNORECASE)


def fortran_constants(routine):
    """Return the constants of a routine's statements: pairs of value and kind."""
    found = set()
    for line in patched(FORTRAN / "published" / routine, _patches()).splitlines():
        if line[:1] in {"c", ""} or re.match(r"\s*(subroutine|function|real|implicit)", line):
            continue
        statement = re.sub(r"^     \*", "", line.split("!")[0])  # the continuation mark
        statement = re.sub(r"\bp\(\d+\)", "", statement)  # indices have a test of their own
        for text in NUMBER.findall(re.sub(r"\.(and|or|[gl][te]|eq)\.", " ", statement)):
            found.add(_value_and_kind(text))
    return found


def _patches():
    return sorted((FORTRAN / "patches").glob("*.patch"))


def _value_and_kind(text):
    if "d" in text.lower():
        return float(text.lower().replace("d", "e")), "REAL*8"
    return (float(text), "REAL*4") if "." in text else (float(text), "INTEGER")


#: What the port writes for each constant of the Fortran, routine by routine. REAL*8 stands in
#: Python floats; REAL*4 in numpy.float32; an INTEGER takes the kind of its partner in both.
PORTED = {
    "model.f": {
        (3.141592653589793, "REAL*8"): 3.141592653589793,
        (1.0, "REAL*8"): 1.0,
        (180.0, "REAL*8"): 180,
        (360.0, "REAL*8"): 360.0,
        (0.0, "REAL*8"): 0,
        (0.0, "REAL*4"): 0,
        (1.0, "INTEGER"): 1,
        (2.0, "INTEGER"): 2,
        (180.0, "INTEGER"): 180,
    },
    "modela.f": {
        (3.141593, "REAL*4"): np.float32(3.141593),
        (360.0, "REAL*4"): np.float32(360),
        (180.0, "REAL*4"): 180,
        (0.0, "REAL*4"): 0,
        (2.0, "INTEGER"): 2,
    },
    "hjump.f": {
        (3.141593, "REAL*4"): np.float32(3.141593),
        (0.0, "REAL*4"): 0,
        (0.0, "INTEGER"): np.float32(0),
        (1.0, "INTEGER"): np.float32(1),
        (180.0, "INTEGER"): 180,
        (65.0, "INTEGER"): 65,
        (7.0, "INTEGER"): 7,
        (2.0, "INTEGER"): 2,
        (55.0, "INTEGER"): 55,
        (95.0, "INTEGER"): 95,
        (90.0, "INTEGER"): 90,
        (15.0, "INTEGER"): 15,
    },
}


def port_constants(module):
    """Return the constants of a module of the port, indices of `p` left out."""
    values = set()
    tree = ast.parse((PORT / module).read_text())
    indices = {id(node.slice) for node in ast.walk(tree) if isinstance(node, ast.Subscript)}
    for node in ast.walk(tree):
        number = isinstance(node, ast.Constant) and isinstance(node.value, int | float)
        if number and id(node) not in indices:
            values.add(float(node.value))
    return values


@pytest.mark.parametrize("routine", PORTED)
def test_each_constant_of_the_fortran_is_accounted_for(routine):
    """The routine's constants are those of the table above, value and kind."""
    assert fortran_constants(routine) == set(PORTED[routine])


@pytest.mark.parametrize("routine", PORTED)
def test_port_has_these_constants_and_no_other(routine):
    """The port's module writes the same values and nothing else."""
    assert port_constants(routine.replace(".f", ".py")) == {value for value, _ in PORTED[routine]}


def test_pi_has_the_kind_and_the_digits_of_the_text():
    """Three pis: REAL*8 with all digits in Model, REAL*4 3.141593 in ModelA and in Hjump."""
    model, modela, hjump = (
        runpy.run_path(str(PORT / f"{name}.py"))["PI"] for name in ("model", "modela", "hjump")
    )

    assert (type(model), model.hex()) == (float, "0x1.921fb54442d18p+1")
    for single in (modela, hjump):
        assert (type(single), float(single).hex()) == (np.float32, "0x1.921fb80000000p+1")


@pytest.mark.parametrize("routine", ["model.f", "modela.f"])
def test_each_parameter_is_used_as_often_as_in_the_fortran(routine):
    """p(1) to p(12) stand in the port as often as in the routine, in the same order of terms."""
    text = (FORTRAN / "published" / routine).read_text()
    statements = [line for line in text.splitlines() if not re.match(r"c|\s*real", line)]
    fortran = [int(i) for line in statements for i in re.findall(r"\bp\((\d+)\)", line)]
    source = (PORT / routine.replace(".f", ".py")).read_text()
    if routine == "model.f":
        port = [int(i) + 1 for i in re.findall(r"\bp\[(\d+)\]", source.partition("def _model")[2])]
    else:
        port = [int(i) for i in re.findall(r"\bp(\d+)\b", source.partition("= p\n")[2])]

    assert port == fortran


def test_results_are_real4():
    """Every routine of the port returns REAL*4, as the Fortran stores it."""
    az, alt, p = np.float32(0.5), np.float32(0.5), np.full(12, 0.01, dtype=np.float32)
    results = [*legacy.model(az, alt, p), *legacy.modela(az, alt, p), legacy.hjump(az, alt)]

    assert {type(result) for result in results} == {np.float32}
