"""Models of mounts other than alt-azimuth ones, carried to tables, grids and other recordings."""

from __future__ import annotations

import csv
from decimal import Decimal

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import EarthLocation
from click.testing import CliRunner

import pyport
from pyport.angles import ARCSEC, DEG
from pyport.cli import pyport as program
from pyport.effects import Site, catalogue
from pyport.formats.model_file import ModelFile
from pyport.formats.rest import rest_of
from pyport.models.model import Model, Term
from pyport.mounts import KINDS

LATITUDE_DEG = 41.3
POLAR = """equatorial
T  240   4.1   0.000   0.0000
  IH        -80.0     1.0
  FO        +35.0     0.7
END
"""
HERE = ("--set", f"latitude_deg={LATITUDE_DEG}")


def run(*words, fails=False):
    """Return what a command says, or how it fails."""
    done = CliRunner().invoke(program, [str(one) for one in words])
    assert (done.exit_code != 0) == fails, done.output
    return done.exception if fails else done.output


def moved(az_deg, el_deg):
    """Return what the model moves a direction by, in azimuth and elevation [deg]."""
    fork, latitude = KINDS["fork"], LATITUDE_DEG * DEG
    az, el = np.array([az_deg * DEG]), np.array([el_deg * DEG])
    first, second = fork.angles(az, el, latitude)
    # TPOINT's IH and FO are what is taken off the readings: an hour angle later, a tube lower.
    turn, drop = 80 / 3600 * DEG, 35 / 3600 * DEG * np.cos(first)
    there = fork.sky(first + turn, second - drop, latitude)
    around = (there[0] - az + np.pi) % (2 * np.pi) - np.pi
    return np.array([around[0], there[1][0] - el[0]]) / DEG


def cells(text):
    """Return the rows of a CSV file by column."""
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


@pytest.fixture
def old(tmp_path):
    """Return a file of TPOINT's with a model of an equatorial mount."""
    path = tmp_path / "old.mod"
    path.write_text(POLAR)
    return path


def test_a_table_of_an_equatorial_mount_is_of_azimuth_and_elevation(old, tmp_path):
    """Its offsets in hour angle and declination are turned onto the sky."""
    table, grid = tmp_path / "t.txt", ("--az", "0:270:90", "--zd", "20:60:20")
    run("table", "--model", old, "--refraction", "none", "-o", table, *grid, *HERE)
    rows = [line.split() for line in table.read_text().splitlines()]
    rows = [[float(one) for one in row] for row in rows if len(row) == 4]

    assert len(rows) == 12
    for az, zd, d_az, d_zd in rows:
        assert (d_az, -d_zd) == pytest.approx(tuple(moved(az, 90 - zd)), abs=3e-5)


def test_a_grid_of_what_a_file_cannot_name_is_of_azimuth_and_elevation(tmp_path):
    """On the meridian the flexure of a fork is along elevation: the tube looks up at the pole."""
    site, fork = Site(LATITUDE_DEG * DEG), KINDS["fork"]
    flexure = Term(catalogue(fork)["fork_flexure"], values=(35 * ARCSEC,))
    model = Model("fork", (flexure,), mount=fork, site=site)
    empty = ModelFile("tpoint", (), "empty", Decimal(90), {})
    rest_of(model, empty, ["fork_flexure"], tmp_path / "rest.csv", {})
    rows = cells((tmp_path / "rest.csv").read_text())
    found = {
        (float(row["az_deg"]), float(row["el_deg"])): [
            float(row[f"d_{axis}_arcsec"]) for axis in ("xel", "el")
        ]
        for row in rows
    }

    assert found[0.0, 60.0] == pytest.approx([0, 35], abs=0.01)
    assert found[180.0, 60.0] == pytest.approx([0, -35], abs=0.01)
    # In the east, by hand: a step in declination is along the great circle through the pole.
    assert found[90.0, 20.0] == pytest.approx([7.12, -5.88], abs=0.01)


def test_a_latitude_may_be_stated(old, tmp_path):
    """TPOINT's model files tell none."""
    words = ("table", "--model", old, "-o", tmp_path / "t.txt", "--az", "0:90:90", "--zd", "5:9:4")

    assert "latitude_deg" in str(run(*words, fails=True))
    assert "4 rows" in run(*words, *HERE)
    for wrong in ("413", "north"):
        said = str(run(*words, "--set", f"latitude_deg={wrong}", fails=True))
        assert "expected a number between -90 and 90" in said
    assert "moves by 0.00 arcsec rms" in run("compare", old, old, *HERE)


def test_models_are_compared_on_the_side_of_the_pier_that_was_observed_most(tmp_path):
    """The axes are called what the mount calls them."""
    night, german = tmp_path / "night.csv", tmp_path / "german.toml"
    rng = np.random.default_rng(2)
    rows = [
        f"{ha:.4f},{dec:.4f},{-80 + 3 * x:.2f},{9 + 3 * y:.2f},{'west' if ha < 20 else 'east'}"
        for ha, dec, x, y in zip(
            rng.uniform(-60, 60, 90),
            rng.uniform(-10, 60, 90),
            *rng.normal(size=(2, 90)),
            strict=True,
        )
    ]
    head = "ha_deg,dec_deg,d_ha_arcsec,d_dec_arcsec,pier_side"
    about = f"# mount: german\n# latitude_deg: {LATITUDE_DEG}"
    night.write_text("\n".join([about, head, *rows]))
    run("fit", night, "--save", german)
    said = run("compare", german, german, "--recordings", night)

    assert "(pier_side west)" in said
    assert "recordings, cross-declination: rms" in said
    residuals = run("apply", german, night, "--residuals", "-o", tmp_path / "left.csv")
    assert "[arcsec]: cross-declination 2." in residuals


def test_readings_of_a_fork_come_back_in_its_own_angles(old, tmp_path):
    """What `apply` drives to, `apply --inverse` returns to."""
    there, back = tmp_path / "there.csv", tmp_path / "back.csv"
    head = f"# mount: fork\n# latitude_deg: {LATITUDE_DEG}\nha_deg,dec_deg\n"
    there.write_text(f"{head}30,20\n")
    (row,) = cells(run("apply", old, there))
    back.write_text(f"{head}{row['mount_ha_deg']},{row['mount_dec_deg']}\n")
    (true,) = cells(run("apply", old, back, "--inverse"))

    assert float(true["true_ha_deg"]) == pytest.approx(30, abs=1e-6)
    assert float(true["true_dec_deg"]) == pytest.approx(20, abs=1e-6)


def test_a_model_of_another_mount_is_asked_for_directions(old):
    """In azimuth and elevation it answers in them, and says where to drive as ever."""
    model = pyport.load_model(old)
    site = EarthLocation.from_geodetic(0 * u.deg, LATITUDE_DEG * u.deg)
    az, el = np.array([0.0, 90.0, 200.0]), np.array([60.0, 20.0, 45.0])
    true = np.array([moved(*one) for one in zip(az, el, strict=True)])
    x, y = model.offsets(az, el, location=site)

    np.testing.assert_allclose(x.to_value("deg") / np.cos(el * DEG), true[:, 0], atol=3e-5)
    np.testing.assert_allclose(y.to_value("deg"), true[:, 1], atol=3e-5)
    there = model.correct(az, el, location=site)
    np.testing.assert_allclose(there[1].to_value("deg") - el, true[:, 1], atol=3e-5)
    one = model.offsets(az[1], el[1], location=site)
    np.testing.assert_allclose(one.d_xel.value, x[1].value)


def test_readings_are_taken_under_their_own_names(old, tmp_path):
    """An answer of `apply` holds the true angles under them, and is said to."""
    there, answer = tmp_path / "there.csv", tmp_path / "answer.csv"
    there.write_text(f"# mount: fork\n# latitude_deg: {LATITUDE_DEG}\nha_deg,dec_deg\n30,20\n")
    run("apply", old, there, "-o", answer)

    said = "the readings are those under ha_deg, not under mount_ha_deg"
    assert said in run("apply", old, answer, "--inverse", "-o", tmp_path / "back.csv")
    assert said not in run("apply", old, there, "--inverse", "-o", tmp_path / "back.csv")
