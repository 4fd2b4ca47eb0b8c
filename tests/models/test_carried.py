"""A completed model in other programs' files, in the steering table, and applied to files."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from diagnosis.made import recordings

import pyport
from pyport.angles import ARCSEC, DEG
from pyport.cli import pyport as program
from pyport.effects import Circumstances
from pyport.formats.models import load
from pyport.recordings import write
from pyport.steering import read_table

PLAIN = ["mod", "ctl", "txt", "xml", "json"]


def run(*words):
    """Return what a command prints, and its exit status."""
    done = CliRunner().invoke(program, [str(word) for word in words])
    text = done.output
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        text += str(done.exception)
    return text, done.exit_code


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Return a saved model that every program can hold, and its recordings."""
    measured = recordings(400, 2)
    path = tmp_path_factory.mktemp("plain") / "plain.toml"
    done = pyport.fit(measured)
    done.save(path)
    return path, measured, done


@pytest.fixture(scope="module")
def jumping(tmp_path_factory):
    """Return a saved model with a jump of 25 arcsec above a curve, and its recordings."""
    measured = recordings(900, 5, y=lambda at: 25.0 * (at.el > np.radians(55 + 10 * np.cos(at.az))))
    folder = tmp_path_factory.mktemp("jumping")
    path = folder / "new.toml"
    pyport.diagnose(measured).model.save(path)
    write(measured, folder / "night.csv")
    return path, measured, folder / "night.csv"


@pytest.mark.parametrize("suffix", PLAIN)
def test_a_plain_model_goes_there_and_back(plain, tmp_path, suffix):
    """TPOINT, Field System, katpoint, DISCOS, SKA-Mid: the file points as the model does."""
    path, measured, done = plain
    target = tmp_path / f"x.{suffix}"
    text, status = run("convert", path, target)
    x, y = load(str(target)).offsets(measured.at)
    mine = done.model.model.offsets(measured.at)

    assert status == 0, text
    np.testing.assert_allclose((x, y), mine, rtol=0, atol=1e-3 * ARCSEC)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", PLAIN)
def test_what_a_format_cannot_name_is_refused_and_goes_beside_it(jumping, tmp_path, suffix):
    """By name; as a grid with its rms; the file and the grid together are the model."""
    path = jumping[0]
    target, grid = tmp_path / f"x.{suffix}", tmp_path / "grid.csv"
    text, status = run("convert", path, target)

    assert status != 0
    assert "has no name for jump" in text
    assert not target.exists()
    text, status = run("convert", path, target, "--rest-as", grid)
    assert status == 0, text
    assert "jump" in text
    assert "arcsec rms" in text
    with grid.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    at = Circumstances(*(np.radians([float(row[k]) for row in rows]) for k in ("az_deg", "el_deg")))
    held, whole = load(str(target)).offsets(at), load(str(path)).offsets(at)
    rest = [np.array([float(r[k]) for r in rows]) * ARCSEC for k in ("d_xel_arcsec", "d_el_arcsec")]
    np.testing.assert_allclose(np.add(held, rest), whole, rtol=0, atol=2e-3 * ARCSEC)


def test_leaving_out_says_what_is_lost(jumping, tmp_path):
    """25 arcsec above the curve is some 11 arcsec rms of the whole sky."""
    text, status = run("convert", jumping[0], tmp_path / "x.mod", "--leave-out")

    assert status == 0
    assert "left out" in text
    assert "above a curve" in text
    assert 6 < float(re.search(r"\(([\d.]+) arcsec", text)[1]) < 16


@pytest.mark.slow
def test_the_rt32s_table_of_a_completed_model(tmp_path):
    """The published table plus what was found, azimuth from south, as the steering reads it."""
    base = load("rt32-3model")
    measured = recordings(500, 8, y=lambda at: 20 * np.cos(3 * at.az))
    x, y = base.offsets(measured.at)
    found = pyport.diagnose(replace(measured, x=measured.x + x, y=measured.y + y), "rt32-3model")
    model = tmp_path / "new.toml"
    found.model.save(model)
    text, status = run("table", "--model", model, "-o", tmp_path / "new.txt")
    run("table", "-o", tmp_path / "old.txt")
    new, old = (read_table(str(tmp_path / f"{name}.txt")) for name in ("new", "old"))
    az, zd = new.grid.points_deg()
    at = Circumstances(az.ravel() * DEG + np.pi, (90 - zd.ravel()) * DEG)
    terms = replace(load(str(model)), given=None)
    told = terms.offsets(at)

    assert status == 0, text
    assert len(new.grid) == 541 * 95
    np.testing.assert_allclose(
        (new.d_zd_deg - old.d_zd_deg).ravel(), -told[1] / DEG, rtol=0, atol=1.01e-7
    )
    sky = np.abs(zd.ravel()) > 1
    np.testing.assert_allclose(
        (new.d_az_deg - old.d_az_deg).ravel()[sky],
        (told[0] / np.cos(at.el) / DEG)[sky],
        rtol=0,
        atol=1.01e-7,
    )


@pytest.mark.slow
def test_a_table_for_one_condition(tmp_path):
    """A model that follows temperature makes a table for each; without one it is refused."""
    measured = recordings(900, 5, y=lambda at: 1.5 * (at.columns["temperature_c"] - 8))
    model = tmp_path / "warm.toml"
    pyport.diagnose(measured).model.save(model)
    grid = ["--az", "0:350:10", "--zd", "0:80:10", "--refraction", "none"]
    text, status = run("table", "--model", model, "-o", tmp_path / "x.txt", *grid)
    assert status != 0
    assert "temperature_c" in text
    for t in (0, 10):
        run(
            "table",
            "--model",
            model,
            "-o",
            tmp_path / f"{t}.txt",
            *grid,
            "--set",
            f"temperature_c={t}",
        )
    cold, warm = (read_table(str(tmp_path / f"{t}.txt")) for t in (0, 10))

    np.testing.assert_allclose((cold.d_zd_deg - warm.d_zd_deg) * 3600, 15, atol=1)


def test_apply_prints_offsets_and_where_to_drive(jumping, tmp_path):
    """The columns of the file and the model's; rows without a direction stay, blank."""
    path, _, _ = jumping
    targets = tmp_path / "targets.csv"
    targets.write_text("source,az_deg,el_deg\na,10,45\nb,20,80\nc,,\n")
    out = tmp_path / "out.csv"
    text, status = run("apply", path, targets, "-o", out)
    rows = list(csv.DictReader(out.open()))
    model = pyport.load_model(path)
    y = model.offsets([10, 20], [45, 80]).d_el

    assert status == 0, text
    assert "1 rows tell no direction" in text
    assert [row["source"] for row in rows] == ["a", "b", "c"]
    assert float(rows[1]["model_d_el_arcsec"]) == pytest.approx(y[1].value, abs=1e-9)
    assert float(rows[0]["mount_el_deg"]) == pytest.approx(45 + y[0].value / 3600, abs=1e-12)
    assert rows[2]["mount_az_deg"] == ""
    back = tmp_path / "back.csv"
    mount = tmp_path / "mount.csv"
    mount.write_text(
        "az_deg,el_deg\n" + "".join(f"{r['mount_az_deg']},{r['mount_el_deg']}\n" for r in rows[:2])
    )
    run("apply", path, mount, "--inverse", "-o", back)
    told = list(csv.DictReader(back.open()))
    assert [float(r["true_az_deg"]) for r in told] == pytest.approx([10, 20], abs=1e-7)
    assert [float(r["true_el_deg"]) for r in told] == pytest.approx([45, 80], abs=1e-7)


@pytest.mark.parametrize("suffix", ["dat", "xtr"])
def test_apply_refuses_formats_without_its_columns(jumping, tmp_path, suffix):
    """A file of stars would hold the measured places where the mount's are expected."""
    targets, out = tmp_path / "targets.csv", tmp_path / f"commands.{suffix}"
    targets.write_text("# latitude_deg: 53\naz_deg,el_deg,d_xel_arcsec,d_el_arcsec\n10,45,1,2\n")
    text, status = run("apply", jumping[0], targets, "-o", out)

    assert status
    assert f".{suffix} has no place for these columns, expected .csv" in text
    assert not out.exists()


def test_apply_takes_the_rows_that_are_asked_for(jumping, tmp_path):
    """Those for which --where holds; none of them is one line."""
    targets = tmp_path / "targets.csv"
    targets.write_text("source,az_deg,el_deg\na,10,45\nb,20,80\nc,,\n")
    text, status = run("apply", jumping[0], targets, "--where", "el_deg > 50")
    none, refused = run("apply", jumping[0], targets, "--where", "el_deg > 85")

    assert (status, [line.split(",")[0] for line in text.splitlines()]) == (0, ["source", "b"])
    assert (refused, "--where 'el_deg > 85' holds for none of the 3 rows" in none) == (1, True)


def test_apply_keeps_the_files_azimuth(jumping, tmp_path):
    """From south through west where the file counts so."""
    targets = tmp_path / "south.csv"
    targets.write_text("# azimuth_zero: south\naz_deg,el_deg\n-170,45\n")
    text, _ = run("apply", jumping[0], targets, "--json")
    told = json.loads(text)
    x, _ = pyport.load_model(jumping[0]).offsets(10.0, 45.0)

    turn = x.value / 3600 / np.cos(np.radians(45))
    assert told["columns"]["mount_az_deg"] == [pytest.approx(-170 + turn, abs=1e-9)]


def test_apply_turns_a_quarter_at_most_and_says_where_refraction_ends(jumping, tmp_path):
    """At the zenith no azimuth moves a telescope across; below half a degree refraction is held."""
    targets = tmp_path / "zenith.csv"
    targets.write_text("az_deg,el_deg\n10,90\n10,89.9999\n10,45\n10,0.2\n10,-1\n10,89\n")
    told = json.loads(run("apply", jumping[0], targets, "--json")[0])
    turn = np.array(told["columns"]["model_d_az_arcsec"]) / 3600
    across = np.array(told["columns"]["model_d_xel_arcsec"]) / 3600

    assert np.abs(turn).max() <= 90
    assert turn[2] == pytest.approx(across[2] / np.cos(np.radians(45)), abs=1e-9)
    # As near the zenith as the steering table's first row, the turn is still the table's.
    assert turn[5] == pytest.approx(across[5] / np.cos(np.radians(89)), rel=1e-12)
    bent = tmp_path / "bent.mod"
    bent.write_text("Mine\nT 1 1.0 0.0 0.0\n IE 5.0 1.0\n TX -20.0 1.0\nEND\n")
    text, _ = run("apply", bent, targets, "-o", tmp_path / "out.csv")
    assert "2 rows lie below 0.5 deg of elevation" in text


def test_excluded_readings_are_in_no_rms(jumping, tmp_path):
    """A spike that was masked does not count in what is left."""
    lines = jumping[2].read_text().splitlines()
    first = next(n for n, line in enumerate(lines) if not line.startswith("#")) + 1
    number = lines[first - 1].split(",").index("d_el_deg")
    cells = lines[first].split(",")
    cells[number] = "5.5"
    spoilt = tmp_path / "spoilt.csv"
    spoilt.write_text("\n".join([*lines[:first], ",".join(cells), *lines[first + 1 :]]) + "\n")
    before, _ = run("apply", jumping[0], spoilt, "--residuals", "--json")
    run("mask", spoilt, "--lines", str(first + 1), "--reason", "spike")
    after, _ = run("apply", jumping[0], spoilt, "--residuals", "--json")

    assert json.loads(before)["rms_arcsec"]["el"] > 100
    assert json.loads(after)["rms_arcsec"]["el"] < 100


def test_residuals_are_those_of_the_diagnosis(jumping, tmp_path):
    """What the saved model leaves of its recordings, from the file."""
    path, measured, night = jumping
    out = tmp_path / "left.csv"
    text, status = run("apply", path, night, "--residuals", "-o", out)
    rows = list(csv.DictReader(line for line in out.open() if not line.startswith("#")))
    left = np.array([float(row["residual_el_arcsec"]) for row in rows])
    y = load(str(path)).offsets(measured.at)[1]

    assert status == 0, text
    np.testing.assert_allclose(left, (measured.y - y) / ARCSEC, atol=1e-6)
    assert f"el {np.sqrt(np.mean(left**2)):.2f}" in text


@pytest.mark.slow
def test_apply_says_what_is_lacking(tmp_path):
    """Without the temperature; with it for all rows; with holes in it."""
    measured = recordings(900, 5, y=lambda at: 1.5 * (at.columns["temperature_c"] - 8))
    model, targets = tmp_path / "warm.toml", tmp_path / "t.csv"
    pyport.diagnose(measured).model.save(model)
    targets.write_text("az_deg,el_deg\n10,45\n20,50\n")

    text, status = run("apply", model, targets)
    assert (status != 0, "needs temperature_c" in text) == (True, True)
    text, status = run(
        "apply", model, targets, "--set", "temperature_c=8", "-o", tmp_path / "o.csv"
    )
    assert status == 0
    targets.write_text("az_deg,el_deg,temperature_c\n10,45,3\n20,50,4\n30,50,\n")
    text, status = run("apply", model, targets, "-o", tmp_path / "o.csv")
    assert "1 rows do not tell temperature_c" in text


def test_a_control_file_keeps_its_title_and_date(tmp_path):
    """The Field System's mdlpo.ctl, fitted again, and by way of the TOML file."""
    old = tmp_path / "mdlpo.ctl"
    flags, zeros = "1 0 1 1 1  1 1 1 0 0", "  0.0000000000" * 5
    head = "* a dish by the sea\n*\n  3 2014 290  1 2 3\n*\n"
    old.write_text(f"{head}  90.0  {flags}\n*\n{zeros}\n*\n{zeros}\n*\n")
    night = tmp_path / "night.csv"
    write(recordings(200, 3), night)
    run("fit", night, "--model", old, "--save", tmp_path / "new.toml")
    run("convert", tmp_path / "new.toml", tmp_path / "new.ctl")
    run("fit", night, "--model", old, "--save", tmp_path / "again.ctl")

    for name in ("new.ctl", "again.ctl"):
        text = (tmp_path / name).read_text()
        assert text.startswith("* a dish by the sea\n")
        assert "00003  2014  290  01  02  03" in text
