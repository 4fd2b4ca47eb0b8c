"""A condition that recordings have under a name of their own is given back under it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import pyport
from pyport.cli import pyport as program
from pyport.diagnosis.naming.finding import Parameter
from pyport.diagnosis.naming.words import number
from pyport.effects.empirical.drivers import unit_in_words
from pyport.errors import BadInput

FOLLOWING = """
schema = "pyport.model/1"
name = "altaz"

[[term]]
effect = "elevation_zero"
per = ["antenna"]
coefficients = [{ name = "elevation_zero", value = 20.0, unit = "arcsec" }]

[[term]]
effect = "driven_term"
per = []
variant = "elevation_zero follows temp_F"
member = { term = "elevation_zero", follows = "temp_F", centre = 43.5 }
coefficients = [{ name = "elevation_zero", value = 2.0, unit = "arcsec/temp_F" }]
"""


@pytest.fixture
def model(tmp_path):
    """Return a file of a model whose elevation zero follows a column of a name of its own."""
    path = tmp_path / "model.toml"
    path.write_text(FOLLOWING)
    return path


def run(*arguments):
    """Return what a command prints."""
    done = CliRunner().invoke(program, [str(one) for one in arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_in_python(model):
    """By keyword; one that the model does not follow is refused."""
    asked = pyport.load_model(model)

    assert asked.offsets(10, 45, temp_F=53.5).d_el.value == pytest.approx(40)
    with pytest.raises(BadInput, match="no condition is called 'temp_C': did you mean 'temp_F'"):
        asked.offsets(10, 45, temp_C=53.5)


def test_for_all_rows_of_a_file(model, tmp_path):
    """`apply --set` is a column of one value."""
    targets = tmp_path / "targets.csv"
    targets.write_text("az_deg,el_deg\n10,45\n20,60\n")

    said = run("apply", model, targets, "--set", "temp_F=53.5")

    table = np.genfromtxt(
        [line for line in said.splitlines() if line[:1] != "#"][:3], delimiter=",", names=True
    )
    np.testing.assert_allclose(table["model_d_el_arcsec"], [40, 40])


def test_for_a_grid_a_table_and_a_comparison(model, tmp_path):
    """The grid beside another program's file, a steering table, and two models over the sky."""
    told = "--set", "temp_F=53.5"

    run("convert", model, tmp_path / "model.ctl", *told)
    assert pyport.load_model(tmp_path / "model.ctl").offsets(10, 45).d_el.value == pytest.approx(40)
    bent = tmp_path / "bent.toml"
    bent.write_text(FOLLOWING.replace('term = "elevation_zero"', 'term = "refraction"'))
    run("convert", bent, tmp_path / "bent.ctl", "--rest-as", tmp_path / "rest.csv", *told)
    grid = np.loadtxt((tmp_path / "rest.csv").read_text().splitlines()[4:], delimiter=",")
    np.testing.assert_allclose(grid[grid[:, 1] == 44, 3], 20 / np.tan(np.radians(44)), rtol=0.01)

    coarse = "--az", "0:10:10", "--zd", "10:20:10"
    assert "temp_F" not in run("table", "--model", model, "-o", tmp_path / "t.txt", *coarse, *told)
    assert "temp_F 53.5" in run("compare", model, model, *told)


def test_the_unit_of_a_column_that_has_none_is_said_in_words(model, tmp_path):
    """In the text; the file keeps its own spelling."""
    night = tmp_path / "night.csv"
    rows = (f"{10 * n},{20 + n},0,{n % 7 + 2 * n % 11},{40 + n % 5}" for n in range(36))
    night.write_text("az_deg,el_deg,d_xel_arcsec,d_el_arcsec,temp_F\n" + "\n".join(rows) + "\n")

    said = run("fit", night, "--model", model)
    fitted = json.loads(run("fit", night, "--model", model, "--json"))

    assert "arcsec per unit of temp_F" in said
    assert "arcsec/temp_F" not in said
    assert "arcsec/temp_F" in [one["unit"] for one in fitted["parameters"]]


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("arcsec/truss_north_temp", "arcsec per unit of truss_north_temp"),
        *((one, one) for one in ("arcsec", "arcsec/K", "arcsec/(m/s)", "arcsec/deg", "", "deg")),
        ("s/d", "s/d"),
    ],
)
def test_units_in_words(unit, said):
    """A known unit stays as it is."""
    swing = Parameter("one", 1.0, 0.1, unit)

    assert unit_in_words(unit) == said
    assert unit == "arcsec" or number(swing) == f"1.00 +- 0.10 {said}"
