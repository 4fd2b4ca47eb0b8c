"""The kit on a program that is not the RT32's: every way of passing a value that FORTRAN 77 has."""

import json
import os
import re
import shutil
import subprocess
import sys
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import pyport
from pyport.cli.parity import command
from pyport.errors import BadInput
from pyport.parity.compare import Pair
from pyport.parity.compiled import oracle
from pyport.parity.described import init, inputs
from pyport.parity.described.functions import ask_port
from pyport.parity.described.loading import load
from pyport.parity.evidence.mutants import modules_of, mutated
from pyport.parity.evidence.shrink import failing, minimal, search
from pyport.parity.promise import hold, kept
from pyport.parity.run import asker, run

PROGRAM = Path(__file__).parent / "program"

pytestmark = [pytest.mark.oracle, pytest.mark.usefixtures("oracle")]


@pytest.fixture(scope="module")
def program():
    """Return the description of the program."""
    return load(PROGRAM / "parity.toml")


def test_every_routine_of_the_port_is_the_program(program):
    """Bit for bit at edges and random points, whatever way a value is passed."""
    parity = run(program, 2000, jobs=1)
    compared = parity.comparisons(program.ports[0])

    assert parity.promise_kept
    assert len(program.routines) == 30
    assert len(compared) == 51
    assert min(one.points for one in compared) > 2000
    assert not [str(one) for one in compared if one.differing]


#: Routine, and what a careless hand makes of its port: a sign turned, the last digit of a constant
#: changed, a REAL*8 kept REAL*4.
SLIPS = {
    "TURNED": [
        ("w = w - math.copysign(2.0 * PI, a)", "w = w + math.copysign(2.0 * PI, a)"),
        ("PI = 3.141592653589793\n", "PI = 3.141592653589794\n"),
        ("w = math.fmod(a, 2.0 * PI)", "w = float(real4(math.fmod(a, 2.0 * PI)))"),
    ],
    "SIDER": [
        ("t = (float(mjd) - 51544.5)", "t = (float(mjd) + 51544.5)"),
        ("8640184.812866", "8640184.812867"),
        ("s / 86400.0 * TWOPI +", "float(real4(s)) / 86400.0 * TWOPI +"),
    ],
    "AIRREF": [
        ("(1.0 - float(real4(0.00117))", "(1.0 + float(real4(0.00117))"),
        ("0.0031376 /", "0.0031377 /"),
        ("t2 = 1.0 / math.tan(z)", "t2 = float(real4(1.0 / math.tan(z)))"),
    ],
    "BISECT": [
        ("(x * x - 2.0) * x - 5.0", "(x * x - 2.0) * x + 5.0"),
        ("(x * x - 2.0) * x", "(x * x - 2.1) * x"),
        ("root = 0.5 * (lo + hi)", "root = float(real4(0.5 * (lo + hi)))"),
    ],
    "ENCODE": [
        ("int(math.copysign(count + (abs(x)", "int(math.copysign(count - (abs(x)"),
        ("count > 196608 or", "count > 196609 or"),
        ("x = az / (PI / 131072.0)", "x = float(real4(az / (PI / 131072.0)))"),
    ],
    "DECODE": [
        ("return count * (PI / 131072.0)", "return -count * (PI / 131072.0)"),
        ("return count * (PI / 131072.0)", "return count * (PI / 131073.0)"),
        ("return count * (PI / 131072.0)", "return float(real4(count * (PI / 131072.0)))"),
    ],
    "HADEC": [
        ("+ math.sin(dec) * math.cos(phi)", "- math.sin(dec) * math.cos(phi)"),
        ("TWOPI = 6.283185307179586", "TWOPI = 6.283185307179587"),
        ("r = math.sqrt(x * x + y * y)", "r = float(real4(math.sqrt(x * x + y * y)))"),
    ],
    "SUNPOS": [
        ("math.asin(math.sin(e)", "-math.asin(math.sin(e)"),
        ("real4(1.915)", "real4(1.916)"),
        ("rad = 1.745329251994330e-2", "rad = float(real4(1.745329251994330e-2))"),
    ],
    "WRAPIT": [
        ("+ nturn * TWOPI", "- nturn * TWOPI"),
        ("1.5 * TWOPI", "1.6 * TWOPI"),
        ("nturn, driven - now", "nturn, float(real4(driven - now))"),
    ],
    "PATHL": [
        ("math.exp(-h / 8434.5)", "math.exp(h / 8434.5)"),
        ("d = 2.2768 *", "d = 2.2769 *"),
        ("d = 2.2768 * math.exp(-h / 8434.5)", "d = float(real4(2.2768 * math.exp(-h / 8434.5)))"),
    ],
}


@pytest.mark.parametrize(("name", "slip"), [(name, k) for name in SLIPS for k in range(3)], ids=str)
def test_slip_is_caught_with_a_minimal_input(program, name, slip):
    """Each slip in each of ten routines breaks the promise, at an input simpler than the first."""
    port, routine = program.ports[0], program.routine(name)
    modules = modules_of(program, port)
    source = modules["antenna_port"].read_text()
    was, became = SLIPS[name][slip]
    assert source.count(was) == 1
    ask = asker(program)
    batch = inputs.some(program, routine, 4000, 5)
    with mutated(program, port, modules, "antenna_port", source.replace(was, became)) as functions:
        function = functions[name]
        actual = ask_port(program, port, routine, batch, function)
        expected = ask("reference", routine, batch)
        held = hold(program, port, Pair(routine, batch, expected, actual, actual.raised))
        assert not kept(port, routine, held)
        found = minimal(port, routine, held, partial(failing, program, ask, function=function))
    worst = next(one.worst for one in held.beyond if one.output == found.output and one.worst)

    assert found.expected != found.actual
    assert len(str(found.inputs)) <= len(str(worst.inputs))


def test_port_is_whole_again_after_a_mutant(program):
    """What a mutant replaced is what it was."""
    port = program.ports[0]
    modules = modules_of(program, port)
    source = modules["antenna_port"].read_text().replace("PI = 3.14", "PI = 0.14")
    with mutated(program, port, modules, "antenna_port", source) as functions:
        assert functions["TURNED"](0.5) != 0.5
    at = {"a": np.array([0.5])}

    assert ask_port(program, port, program.routine("TURNED"), at)["turned"] == [0.5]


def test_hypothesis_finds_what_random_points_do_not(program):
    """A slip at one value alone, a threshold, is found and made simple."""
    routine = program.routine("TURNED")
    port = program.ports[0]
    modules = modules_of(program, port)
    source = modules["antenna_port"].read_text().replace("abs(w) >= PI", "abs(w) > PI")
    with mutated(program, port, modules, "antenna_port", source):
        found = search(program, port, routine, asker(program), 300)

    assert search(program, port, routine, asker(program), 300) is None
    assert found.inputs["A"] in {"0x1.921fb54442d18p+1", "-0x1.921fb54442d18p+1"}


def described(folder, routine, more=""):
    """Write and read a description of one routine of the program."""
    for name in ("antenna.f", "site.inc"):
        shutil.copy(PROGRAM / name, folder)
    text = (
        f'[fortran]\nfiles = ["antenna.f"]\ninclude = ["site.inc"]\n{more}\n[[routine]]\n{routine}'
    )
    (folder / "parity.toml").write_text(text)
    return load(folder / "parity.toml")


def ask(description, **values):
    """Ask the only routine of a description."""
    routine = description.routines[0]
    batch = {k: np.array(v, routine.by_key[k].type.dtype()) for k, v in values.items()}
    return oracle.of(description.path, "reference").ask(routine, batch)


HALTS = """name = "HALTS"
argument = [
  { name = "X", kind = "real*4" },
  { name = "Y", kind = "real*4", intent = "out" },
]
"""
GOOD = HALTS.replace('"X", kind = "real*4"', '"X", kind = "real*4", range = [0.0, 9.0]')


def test_stop_is_named_with_its_input(tmp_path):
    """A routine that ends the program says at which input; the next question is answered."""
    description = described(tmp_path, HALTS)

    with pytest.raises(BadInput, match=r"HALTS ends the program .* at X=-0x1p\+1"):
        ask(description, x=[4, 1, 9, -2, 16, -1])
    assert ask(description, x=[4])["y"].tolist() == [2]


def test_changed_input_is_named(tmp_path):
    """An argument described as an input that the routine changes is one line."""
    text = 'name = "DECODE"\nargument = [\n'
    text += '{ name = "ICOUNT", kind = "integer*4" }, { name = "AZ", kind = "real*8" },\n'
    text += '{ name = "UNUSED", kind = "integer*4", intent = "out" }]\n'
    description = described(tmp_path, text)

    with pytest.raises(BadInput, match=r"DECODE changes its argument AZ.*expected inout"):
        ask(description, icount=[3], az=[0.0])


def test_what_is_not_supported_is_said_by_name(tmp_path):
    """COMPLEX and alternate returns are left out by name; the rest is described."""
    text = init.described([PROGRAM / "antenna.f"], tmp_path / "parity.toml")

    assert "subroutine COMPLX is left out: its argument Z: COMPLEX is not supported." in text
    assert "subroutine ESCAPE is left out: an argument * (alternate return)" in text
    assert text.count("[[routine]]") == 25
    assert "thresholds = [0.05]" in text
    assert "# entry DECODE(ICOUNT, AZ)" in text
    assert "sequence = true  # ? it remembers (DATA KOUNT, SUM)" in text


def test_words_of_c_are_names(tmp_path):
    """LONG, INT and VOID are what Fortran calls them, with their thresholds."""
    path = tmp_path / "words.f"
    path.write_text(
        "      SUBROUTINE WORDS(LONG, INT, VOID)\n      DOUBLE PRECISION LONG, INT, VOID\n"
        "      IF (LONG .LT. 180D0) VOID = LONG + INT\n      END\n"
    )
    text = init.described([path], tmp_path / "parity.toml")

    assert re.findall(r'name = "(\w+)"\nkind', text) == ["LONG", "INT", "VOID"]
    assert "thresholds = [180.0]" in text
    assert "not used" not in text


def test_init_marks_what_it_could_not_tell(tmp_path):
    """What is marked with ? must be filled in: the line is named; then it runs."""
    out = tmp_path / "parity.toml"
    done = CliRunner().invoke(
        command, ["init", str(PROGRAM / "antenna.f"), "--routine", "TURNV", "-o", str(out)]
    )
    assert done.exit_code == 0, done.output
    lines = out.read_text().splitlines()
    marked = next(i for i, line in enumerate(lines, start=1) if line.startswith('shape = "?"'))
    with pytest.raises(BadInput, match=rf"parity\.toml:{marked}: .*`shape` is still"):
        load(out)
    text = out.read_text().replace('shape = "?"', "shape = [3]")
    out.write_text(text.replace("range = [-10, 10]", "value = 3"))

    routine = load(out).routine("TURNV")
    assert [one.intent for one in routine.arguments] == ["in", "inout", "in", "out"]


@pytest.mark.parametrize(
    ("was", "became", "message"),
    [
        ('kind = "real*4" }', 'kind = "real*16" }', r"kind 'real\*16' is not supported"),
        ('intent = "out"', 'intent = "output"', "expected one of in, out, inout, result"),
        ('intent = "out"', 'intnet = "out"', "did you mean `intent`"),
        ('name = "HALTS"', "name = 3", "expected str"),
        ("argument = [", 'port = "nothing"\nargument = [', "expected 'module:function'"),
        ('"Y", kind = "real*4", intent = "out"', '"Y", kind = "real*4"', "has no output"),
        ('{ name = "X"', '{ range = [2.0, 1.0], name = "X"', r"expected \[LOW, HIGH\]"),
        ("argument = [", "argument = [[", "no TOML"),
    ],
)
def test_wrong_description_is_one_line(tmp_path, was, became, message):
    """What a description says wrong is one line with file and line."""
    assert was in HALTS
    with pytest.raises(BadInput, match=r"parity\.toml:\d+: .*" + message):
        described(tmp_path, HALTS.replace(was, became))


def test_fortran_that_does_not_compile_is_one_line(tmp_path):
    """The compiler's first message, with the file's line."""
    description = described(tmp_path, HALTS)
    path = tmp_path / "antenna.f"
    path.write_text(path.read_text().replace("JY = IY\n", "JY = = IY\n", 1))

    with pytest.raises(BadInput, match=r"does not compile: antenna\.f:25:.*Error"):
        ask(description, x=[1])


def test_port_that_is_missing_is_one_line(tmp_path):
    """A port's module that is not there is named with where it was looked for."""
    description = described(tmp_path, GOOD.replace("argument", 'port = "nowhere:f"\nargument'))

    with pytest.raises(BadInput, match="nowhere:f: No module named 'nowhere': expected a module"):
        run(description, 10, jobs=1)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("unfinished", "def f(x:\n    return x\n", "SyntaxError: .*unfinished.py, line 1"),
        ("divides", "a = 1\nb = 1 / 0\n", r"ZeroDivisionError: .*\(divides.py, line 2\)"),
        ("ends", "import sys\nsys.exit(0)\n", r"SystemExit: 0 \(ends.py, line 2\)"),
    ],
)
def test_port_that_cannot_be_imported_is_one_line(tmp_path, name, text, message):
    """It is the user's module that is at fault: its file and line are named."""
    (tmp_path / f"{name}.py").write_text(text)
    description = described(tmp_path, GOOD.replace("argument", f'port = "{name}:f"\nargument'))

    with pytest.raises(BadInput, match=rf"parity\.toml.*{name}:f: {message}"):
        run(description, 10, jobs=1)


def test_port_that_ends_the_program_is_not_equal(tmp_path):
    """Neither does it end the comparison with status 0: that it ends is its answer."""
    (tmp_path / "quits.py").write_text("import sys\ndef f(x):\n    sys.exit(0)\n")
    description = described(tmp_path, GOOD.replace("argument", 'port = "quits:f"\nargument'))
    answer = CliRunner().invoke(
        command, ["--config", str(description.path), "--points", "10", "--jobs", "1"]
    )

    assert answer.exit_code == 1, answer.output
    assert "SystemExit: 0" in answer.output


def test_vectorised_port_that_raises_is_one_line(tmp_path):
    """It has no answer at any point."""
    (tmp_path / "alike.py").write_text("def f(x):\n    return 1 if x > 0 else 0\n")
    more = '[[port]]\nname = "python"\npromise = "bits"\nvectorised = true\n'
    routine = GOOD.replace("argument", 'port = "alike:f"\nargument')
    with pytest.raises(BadInput, match="alike:f raised ValueError: The truth value"):
        run(described(tmp_path, routine, more), 10, jobs=1)


def test_pytest_plugin_holds_a_description(tmp_path):
    """One test a routine, port and group; a slip fails with its minimal input."""
    shutil.copytree(PROGRAM, tmp_path / "program")
    config = tmp_path / "program" / "parity.toml"
    head, *routines = config.read_text().split("[[routine]]\n")
    some = [one for one in routines if re.match(r'name = "(KEPLER|ANOMAL|NAMED|RUNGE)"', one)]
    config.write_text("[[routine]]\n".join([head, *some]))
    port = tmp_path / "program" / "antenna_port.py"
    text = port.read_text()
    port.write_text(text.replace("return e - ecc * math.sin(e) - anom", "return e - anom"))
    installed = any(one.name == "pyport-parity" for one in entry_points(group="pytest11"))
    plugin = [] if installed else ["-p", "pyport.parity.plugin"]
    words = [sys.executable, "-m", "pytest", *plugin, "-p", "no:cacheprovider"]
    words += ["-c", os.devnull, "--rootdir", str(tmp_path), "--parity-points", "50", "-rf", "-q"]
    done = subprocess.run(
        [*words, "--parity-examples", "20", "--parity", "program/parity.toml"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(Path(pyport.__file__).parents[1])},
    )  # fmt: skip
    failed = {line.split()[1].strip(":") for line in done.stdout.splitlines() if "FAILED" in line}

    assert done.returncode == 1, done.stdout
    assert failed == {
        f"program/parity.toml::{routine}-python-{what}"
        for routine in ("KEPLER", "ANOMAL")
        for what in ("edges", "random", "hypothesis")
    }
    assert "minimal: KEPLER(E=" in done.stdout
    assert re.search(r"6 failed, 6 passed", done.stdout)


def test_plugin_imports_little():
    """Every pytest of whoever installed pyport loads the plugin: no NumPy with it."""
    code = "import sys, pyport.parity.plugin; print('numpy' in sys.modules, 'click' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.split() == ["False", "False"]


def test_missing_fortran_is_one_line(tmp_path):
    """Without the Fortran and without stored answers there is nothing to ask."""
    description = described(tmp_path, GOOD)
    (tmp_path / "antenna.f").unlink()

    with pytest.raises(BadInput, match=r"antenna\.f is not there: expected a Fortran file"):
        run(description, 10, jobs=1)


def test_matrix_says_what_other_flags_make_of_it(tmp_path):
    """Each build of the matrix against the reference, kept beside the answers for the report."""
    shutil.copytree(PROGRAM, tmp_path / "program")
    config = tmp_path / "program" / "parity.toml"
    words = ["matrix", "--config", str(config), "--points", "300", "--json"]
    done = CliRunner().invoke(command, words, catch_exceptions=False)
    content = json.loads(done.output)
    plain, fast = content["rows"]

    assert (plain["build"], fast["build"]) == (
        "gfortran -O2",
        "gfortran -O3 -march=native -ffast-math",
    )
    assert len(plain["outputs"]) == 51
    assert sum(one["differing"] for one in fast["outputs"]) > 0
    assert json.loads((config.parent / "answers" / "matrix.json").read_text()) == content


def test_program_has_what_legacy_programs_have(program):
    """500 lines with every way to pass a value, each of them used by a routine that is compared."""
    text = "".join(one.read_text() for one in [*program.files, *program.include])
    variables = [one for routine in program.routines for one in routine.variables]

    assert text.count("\n") >= 500
    for word in ("COMMON /", "COMMON ECC", "SAVE", "ENTRY", "INCLUDE", "EXTERNAL", "IMPLICIT"):
        assert word in text
    for word in ("EQUIVALENCE", "BLOCK DATA", "GO TO (", "(LDA,*)", "C(-3:3)", "CHARACTER*(*)"):
        assert word in text
    assert {str(one.kind) for one in variables if one.kind is not None} >= {
        "real*4", "real*8", "integer*2", "integer*4", "logical*1", "logical*4",
        "character*6", "character*8",
    }  # fmt: skip
    assert {one.intent for one in variables if one.common is not None} == {"in", "inout"}
    assert {len(one.shape) for one in variables} == {0, 1, 2}
