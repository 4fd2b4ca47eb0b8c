"""Models of mounts whose first axis leans, in files that do not say of which kind."""

import numpy as np
import pytest
from click.testing import CliRunner

import pyport
from pyport.cli import pyport as command
from pyport.errors import BadInput
from pyport.formats.convert import convert
from pyport.recordings.raw import FileOptions
from pyport.steering import tabulate

X_DEG = 0.03
POLAR = {"IH": -121.5, "ID": 209.8, "CH": -33.3, "NP": 15.0, "MA": 22.0, "ME": -116.6}


def control(path, phi_deg, **values):
    """Write a mdlpo.ctl with parameters [deg]."""
    rows = [float(values.get(f"P{n}", 0.0)) for n in range(1, 31)]
    flags = " ".join(str(int(one != 0)) for one in rows)
    lines = [" ".join(map(repr, rows[n : n + 5])) for n in range(0, 30, 5)]
    path.write_text("\n".join(["1 2024 60 0 0 0", f"{phi_deg} {flags}", *lines, ""]))
    return path


def polar(path, **more):
    """Write a TPOINT model of an equatorial mount [arcsec]."""
    terms = [f"  {name} {value}" for name, value in (POLAR | more).items()]
    path.write_text("\n".join(["polar", "T 0 0 0 0", *terms, "END", ""]))
    return path


def run(*words):
    """Return what a command answers."""
    return CliRunner().invoke(command, list(map(str, words)))


@pytest.fixture
def leaning(tmp_path):
    """Return a model of an X-Y mount whose X is off, and that sags with P4."""
    return control(tmp_path / "xy.ctl", 0.0, P1=X_DEG, P4=0.01, P7=0.05)


@pytest.mark.parametrize("mount", ["xy-ns", "xy-ew"])
def test_readings_come_back_to_the_place_they_are_of(tmp_path, leaning, mount):
    """The way back was that of an alt-azimuth mount, and added the offsets once more."""
    there = tmp_path / "there.csv"
    places = [(20, 30), (0, 0), (-40, 10), (35, -50)]
    rows = "".join(f"{x},{y}\n" for x, y in places)
    there.write_text(f"# mount: {mount}\nx_deg,y_deg\n{rows}")
    forth, back = tmp_path / "forth.csv", tmp_path / "back.csv"
    assert run("apply", leaning, there, "-o", forth).exit_code == 0
    driven = np.genfromtxt(forth, delimiter=",", names=True, skip_header=1)
    driven_x, driven_y = driven["mount_x_deg"], driven["mount_y_deg"]
    rows = "".join(f"{float(x)!r},{float(y)!r}\n" for x, y in zip(driven_x, driven_y, strict=True))
    there.write_text(f"# mount: {mount}\nx_deg,y_deg\n{rows}")
    assert run("apply", leaning, there, "--inverse", "-o", back).exit_code == 0
    found = np.genfromtxt(back, delimiter=",", names=True, skip_header=1)

    moved = np.hypot(driven_x - driven["x_deg"], driven_y - driven["y_deg"])
    assert moved.min() > X_DEG
    assert found["true_x_deg"] == pytest.approx([x for x, _ in places], abs=1e-9)
    assert found["true_y_deg"] == pytest.approx([y for _, y in places], abs=1e-9)


def test_a_leaning_axis_needs_a_mount_to_be_asked(leaning, tmp_path):
    """Azimuth and elevation were taken for X and Y."""
    for asked in ("offsets", "correct", "inverse"):
        with pytest.raises(BadInput, match="first axis of the model xy leans"):
            getattr(pyport.load_model(leaning), asked)(90.0, 45.0)
    found = pyport.load_model(leaning, mount="xy-ns")
    x, y = pyport.load_model(control(tmp_path / "zero.ctl", 90.0, P1=X_DEG)).offsets(90.0, 45.0)
    assert np.hypot(*(one.to_value("arcsec") for one in found.offsets(90.0, 45.0))) > 150
    assert (x.to_value("arcsec"), y.to_value("arcsec")) == pytest.approx((76.37, 0.0), abs=0.01)
    with pytest.raises(BadInput, match="mount is 'dobson', expected one or more of altaz"):
        pyport.load_model(leaning, mount="dobson")
    with pytest.raises(BadInput, match="expected a model of azimuth and elevation"):
        tabulate(str(leaning))


def test_two_files_of_one_leaning_model_are_compared_on_its_mount(tmp_path, leaning):
    """One said that it moves by 300 arcsec."""
    same = control(tmp_path / "same.ctl", 0.0, P1=X_DEG, P4=0.01, P7=0.05)
    assert run("compare", leaning, same).exit_code != 0
    said = run("compare", leaning, same, "--mount", "xy-ns").output
    assert "moves by 0.00 arcsec rms" in said


def test_a_polar_model_is_no_model_of_azimuth(tmp_path):
    """It was written with the terms of an alt-azimuth mount, phi of 90 deg and all."""
    source, target = polar(tmp_path / "polar.mod"), tmp_path / "polar.ctl"
    south = FileOptions({"latitude_deg": "-33.5"})
    with pytest.raises(BadInput, match="no latitude"):
        convert(str(source), target)
    for other in ("polar.json", "polar.xml", "polar.txt"):
        with pytest.raises(BadInput, match="has no terms for an equatorial mount"):
            convert(str(source), tmp_path / other, given=south)
    assert convert(str(source), target, given=south).number == len(POLAR)
    phi = next(line.split()[0] for line in target.read_text().splitlines() if "-33.5" in line)
    assert float(phi) == -33.5
    words = ("--mount", "equatorial", "--set", "latitude_deg=-33.5")
    assert "moves by 0.00 arcsec rms" in run("compare", source, target, *words).output
    back = tmp_path / "back.mod"
    with pytest.raises(BadInput, match=r"phi is -33\.5000 deg, and no mount is stated"):
        convert(str(target), back)
    convert(str(target), back, given=FileOptions({"mount": "equatorial", **south.keys}))
    assert "moves by 0.00 arcsec rms" in run("compare", source, back, *words).output
    assert convert(str(source), tmp_path / "copy.mod").number == len(POLAR)


def test_the_gravity_of_a_tube_is_two_terms_there(tmp_path):
    """P8 alone would be that of declination, not of the tube; P2 is its other half."""
    source, target = polar(tmp_path / "polar.mod", TF=30.0), tmp_path / "polar.ctl"
    assert convert(str(source), target, given=FileOptions({"latitude_deg": "-33.5"})).number > 6
    words = ("--mount", "equatorial", "--set", "latitude_deg=-33.5")
    assert "moves by 0.00 arcsec rms" in run("compare", source, target, *words).output


def test_what_the_air_does_is_no_cotangent_of_declination(tmp_path):
    """TX has no counterpart on such a mount."""
    source = polar(tmp_path / "polar.mod", TX=30.0)
    with pytest.raises(BadInput, match="TX"):
        convert(str(source), tmp_path / "p.ctl", given=FileOptions({"latitude_deg": "-33.5"}))


def test_what_the_old_model_left_is_judged_with_it(tmp_path):
    """The right model, fitted to what another one had left, was said to be worse."""
    old, new = tmp_path / "old.mod", tmp_path / "new.mod"
    old.write_text("old\nT 0 0 0 0\n IA -90\n IE 200\n CA 20\nEND\n")
    new.write_text("new\nT 0 0 0 0\n IA -120\n IE 210\n CA 25\nEND\n")
    az, el = np.meshgrid(np.arange(0.0, 360.0, 20.0), np.arange(20.0, 80.0, 10.0))
    columns = az.ravel(), el.ravel()
    offsets = [pyport.load_model(one).offsets(*columns) for one in (old, new)]
    left = [(b - a).to_value("arcsec") for a, b in zip(*offsets, strict=True)]
    rows = "".join(f"{a},{e},{x},{y}\n" for a, e, x, y in zip(*columns, *left, strict=True))
    night = tmp_path / "night.csv"
    night.write_text("az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n" + rows)

    none, words = "rows that get worse: 0 of 108", ("compare", old, new, "--recordings", night)
    assert none not in run(*words).output
    said = run(*words, "--in-use").output
    assert "-> 0.00 arcsec" in said
    assert none in said
    assert "--in-use is said of recordings" in run("compare", old, new, "--in-use").output


def test_readings_that_no_direction_gives_are_counted(tmp_path):
    """Within an arcminute of the zenith the way back ended beyond it, without a word."""
    model, there = tmp_path / "zenith.mod", tmp_path / "there.csv"
    model.write_text("zenith\nT 0 0 0 0\n IE 210\n CA 40\n AN 15\n AW -12\nEND\n")
    az = np.arange(0, 360, 10)
    for el, missed in ((89.97, 0), (89.996, 18)):
        there.write_text("az_deg,el_deg\n" + "".join(f"{one},{el}\n" for one in az))
        forth, back = tmp_path / "forth.csv", tmp_path / "back.csv"
        assert run("apply", model, there, "-o", forth).exit_code == 0
        driven = np.genfromtxt(forth, delimiter=",", names=True)
        pairs = zip(driven["mount_az_deg"], driven["mount_el_deg"], strict=True)
        there.write_text(
            "az_deg,el_deg\n" + "".join(f"{float(a)!r},{float(e)!r}\n" for a, e in pairs)
        )
        said = run("apply", model, there, "--inverse", "-o", back).output
        found = np.genfromtxt(back, delimiter=",", names=True)["true_el_deg"]

        assert found.max() <= 90
        right = np.abs(found - el) < 1e-9
        assert right.all() or missed
        assert ("readings that no direction gives" in said) == bool(missed)


def test_a_drive_beyond_the_pole_is_mentioned(tmp_path):
    """Such a reading was written without a word, and refused when it came back."""
    model, there = tmp_path / "high.mod", tmp_path / "there.csv"
    model.write_text("high\nT 0 0 0 0\n IE -200\nEND\n")
    there.write_text("az_deg,el_deg\n10,89.99\n10,80\n")
    said = run("apply", model, there, "-o", tmp_path / "o.csv").output
    assert "1 rows drive the second axis beyond its pole: mount_el_deg is more than 90" in said
