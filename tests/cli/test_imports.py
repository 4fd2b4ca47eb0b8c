"""The floors of the program: no import leads up, none in a circle."""

from collections import Counter
from pathlib import Path

import pytest
from click.testing import CliRunner

import pyport
from pyport.cli import pyport as program
from pyport.cli.dev.imports import FLOORS, arrows, faults, imports

FOUND = imports(Path(pyport.__file__).parent)


def test_no_import_leads_up_or_in_a_circle():
    """Every arrow of the program leads to a floor below."""
    assert faults(FOUND) == []


@pytest.mark.parametrize(
    ("module", "other", "said"),
    [
        ("pyport.effects.base", "pyport.diagnosis.case", "pyport.effects.base imports"),
        ("pyport.noise.estimation.estimate", "pyport.steering.grid", "which is not below it"),
        ("pyport.models.model", "pyport.models.toml", "a circle: "),
        ("pyport.attic", "pyport.errors", "attic stands on no floor"),
    ],
)
def test_what_climbs_is_found(module, other, said):
    """An import from above, from beside, in a circle, and a room that nobody placed."""
    found = {**FOUND, module: FOUND.get(module, frozenset()) | {other}}

    assert any(said in line for line in faults(found))


def test_imports_inside_functions_and_for_types_count():
    """`from pyport.models import toml` in a function of `formats`, a type of `models` there."""
    assert "pyport.models.toml" in FOUND["pyport.formats.models"]
    assert "pyport.correction.use" in FOUND["pyport.api"]
    assert "recordings" in arrows(FOUND)["noise"]


@pytest.mark.slow
def test_the_picture_has_every_room():
    """Each with its floor, from the top."""
    done = CliRunner().invoke(program, ["dev", "imports"])
    rooms = [line.split()[0] for line in done.stdout.splitlines() if line]
    above = [name for floor in reversed(FLOORS) for name in floor if name in arrows(FOUND)]

    assert done.exit_code == 0
    assert rooms == [*above, "all"]


def test_no_floor_has_more_than_a_dozen_files():
    """A folder that grows beyond what one looks through at a glance is parted."""
    floors = Counter(path.parent for path in Path(pyport.__file__).parent.rglob("*.py"))

    assert [str(folder) for folder, files in floors.items() if files > 12] == []
