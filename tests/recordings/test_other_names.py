"""Columns by other names, names that are nearly right, selections that keep nothing, units."""

import csv
from pathlib import Path

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import EarthLocation
from astropy.table import QTable
from astropy.time import Time
from click.testing import CliRunner
from samples import sample

import pyport
from pyport.cli import pyport as program
from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.formats import mapped
from pyport.recordings.formats.sheet import sheet
from pyport.recordings.from_table import from_table
from pyport.recordings.raw import FileOptions

LOG = """# a log of pointings
# id      src     AZd(f0) ELd(f0) T.amb   pnt.X pnt.Y
2015-02-23.1  3C84  122 42  0.2   -6.5  -59.4
2015-02-23.2  3C84 -131 47 -6.4   15.7  -77.6
2015-02-24.1  3C273 -130 48 -6.5   17.9  -78.0
"""
MAP = {"az_deg": "AZd", "el_deg": "ELd", "d_xel_arcsec": "pnt.X", "d_el_arcsec": "-pnt.Y"}


@pytest.fixture
def log(tmp_path):
    """Return a log with columns of its own."""
    path = tmp_path / "pointing.log"
    path.write_text(LOG)
    return path


def run(*words):
    """Return what a command prints and raises."""
    done = CliRunner().invoke(program, [str(word) for word in words])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        assert isinstance(done.exception, BadInput), done.exception
        return f"{done.output}{done.exception}"
    return done.output


def test_a_map_reads_any_delimited_text(log):
    """Names with formats behind them, a sign turned round, a date out of a label."""
    given = FileOptions(
        mapping=MAP | {"session": "id|date", "source": "src", "temperature_c": "T.amb"}
    )
    found = read(log, given)

    np.testing.assert_allclose(np.degrees(found.at.az), [122, -131, -130])
    np.testing.assert_allclose(np.degrees(found.y) * 3600, [59.4, 77.6, 78.0])
    assert found.at.column("session").tolist() == ["2015-02-23"] * 2 + ["2015-02-24"]
    assert found.at.column("temperature_c").tolist() == [0.2, -6.4, -6.5]
    assert found.line.tolist() == [3, 4, 5]


@pytest.mark.parametrize("sign", [",", ";", "\t", "|", " "])
def test_numbered_columns_by_any_delimiter(tmp_path, sign):
    """Without a line of names columns go by their numbers, from 1."""
    path = tmp_path / "bare.txt"
    path.write_text("".join(sign.join(["x", "10.5", "45", "3.5"]) + "\n" for _ in range(3)))
    found = read(path, FileOptions(mapping={"az_deg": "2", "el_deg": "3", "d_el_arcsec": "4"}))

    np.testing.assert_allclose(np.degrees(found.at.az), 10.5)
    np.testing.assert_allclose(np.degrees(found.y) * 3600, 3.5)


@pytest.mark.parametrize("first", ["sep=;", "sep=,", "sep=|", "sep=\t"])
def test_the_line_that_excel_takes_the_separator_from_is_no_row(tmp_path, first):
    """Names are those of the line below, whatever it says."""
    path = tmp_path / "log.csv"
    path.write_text(f"{first}\nAzimuth{first[-1]}dEl\n10.5{first[-1]}3.5\n")

    found = sheet(path)

    assert found.names == ("Azimuth", "dEl")
    assert found.lines == [3]


@pytest.mark.parametrize("sign", [";", "\t"])
def test_a_decimal_comma_is_no_delimiter(tmp_path, sign):
    """The names tell what stands between cells; the cell that has one is named."""
    path, kept = tmp_path / "log.csv", tmp_path / "map.toml"
    names, cells = ["Azimuth", "Elevation", "dAz", "dEl"], ["10,5", "45,1", "0,01", "0,02"]
    path.write_text("".join(f"{sign.join(one)}\n" for one in (names, cells, cells)))

    assert "--columns reads any other table" in run("convert", path, tmp_path / "out.csv")
    assert "az_deg                 Azimuth" in run("look", path, "--save-columns", kept)
    with pytest.raises(BadInput, match=r"2: az_deg is '10,5', expected a number with a decimal po"):
        read(path, FileOptions(mapping=mapped.load(kept)))


@pytest.mark.parametrize(
    ("part", "cell"), [("mjd", "57076.5"), ("jd", "2457077.0"), ("unix", "1424692800")]
)
def test_other_counts_of_time(tmp_path, part, cell):
    """MJD, JD and seconds are UTC: noon of 2015-02-23."""
    path = tmp_path / "t.csv"
    path.write_text(f"when,az,el,dy\n{cell},1,50,2\n{cell},2,60,2\n")
    found = read(
        path,
        FileOptions(
            mapping={"time_utc": f"when|{part}", "az_deg": "az", "el_deg": "el", "d_el_deg": "dy"}
        ),
    )

    assert found.at.column("time").tolist() == [1424692800.0] * 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("az_deg=AZ, el_deg=ELd, d_el_arcsec=pnt.Y", "no column 'AZ': did you mean 'AZd'"),
        ("azimuth=AZd", "did you mean 'az_deg'"),
        ("AZ_DEG=AZd", "did you mean 'az_deg'"),
        ("az_deg", "one of csv|suffix|expected"),
        ("az_deg=AZd, el_deg", "expected NAME=NAME HERE"),
        ("az_deg=id|hour, el_deg=ELd", "expected one of date, mjd, jd, unix"),
        ("time_utc=src|mjd, az_deg=AZd, el_deg=ELd, d_el_deg=pnt.Y", "time_utc is '3C84'"),
        ("nowhere.toml", "no such file"),
    ],
)
def test_a_wrong_map_is_one_line(log, text, said):
    """That names the column, and the one that was meant."""
    try:
        printed = run("fit", log, "--model", "altaz", "--columns", text)
    except AssertionError:
        printed = ""
    assert any(one in printed for one in said.split("|")) or said in printed


def test_three_dots_take_all_other_columns_as_they_are_called(tmp_path):
    """As the refusal of a count of days proposes it."""
    path = tmp_path / "days.csv"
    path.write_text("az_deg,el_deg,d_xel_arcsec,d_el_arcsec,mjd,focus_mm\n10,40,1,2,59000.5,3.5\n")
    refused = run("look", path)
    way = refused.split("--columns '")[1].split("'")[0]
    found = read(path, FileOptions(mapping=mapped.parse(way)))

    assert way == "time_utc=mjd|mjd, ..."
    assert found.at.column("time")[0] == Time(59000.5, format="mjd").unix
    assert found.at.column("focus_mm").tolist() == [3.5]
    assert "mjd" not in found.at
    np.testing.assert_allclose(np.degrees(found.at.el), [40])


def test_three_dots_take_no_name_that_stands_there_twice(tmp_path):
    """One of the two columns would be lost."""
    path = tmp_path / "twice.csv"
    path.write_text("az,el_deg,d_el_arcsec,focus_mm,focus_mm\n10,40,1,3.5,4.5\n")

    with pytest.raises(BadInput, match="two columns are called 'focus_mm', expected one"):
        read(path, FileOptions(mapping=mapped.parse("az_deg=az, ...")))


def test_look_proposes_a_map_that_every_command_takes(log, tmp_path):
    """From the names, kept in a small file, and read back."""
    kept = tmp_path / "map.toml"
    said = run("look", log, "--save-columns", kept)
    found = mapped.load(kept)

    assert "proposed, to be checked" in said
    assert found["az_deg"] == "AZd"
    assert found["d_xel_arcsec"] == "pnt.X"
    assert found["session"] == "id|date"
    assert found["source"] == "src"
    rows = tmp_path / "rows.csv"
    assert "3 recordings" in run("convert", log, rows, "--columns", kept)
    assert len(list(csv.DictReader(rows.open()))) == 3


def test_the_map_of_a_real_log():
    """The GISMO log's total offsets, by the map that the contract gives as its example."""
    path = sample("iram/pointing-2015-03.log")
    text = "az_deg=AZd, el_deg=ELd, d_xel_arcsec=pnt.X, d_el_arcsec=pnt.Y, session=id|date"
    found = read(path, FileOptions(mapping=mapped.parse(text)))
    proposed = mapped.propose(sheet(path))

    assert len(found) > 200
    assert {key: proposed[key] for key in ("az_deg", "el_deg", "d_xel_arcsec", "d_el_arcsec")} == {
        "az_deg": "AZd", "el_deg": "ELd", "d_xel_arcsec": "pnt.X", "d_el_arcsec": "pnt.Y",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("header", "offset"),
    [("# offset_el: observed - true [deg]\n", "d_el_deg"), ("# seeing: 2\n", "d_el_arcsec")],
)
def test_a_unit_in_the_header_and_a_moment_are_understood(tmp_path, header, offset):
    """What the header says of a column is its unit; a date with a time of day is the time."""
    path = tmp_path / "q.tsv"
    row = "2025-01-03T00:17:27.951Z\t14.6\t37.8\t0.07\n"
    path.write_text(f"{header}seen\tazimuth\televation\toffset_el\n{row}{row}")

    assert mapped.propose(sheet(path)) == {
        "time_utc": "seen", "az_deg": "azimuth", "el_deg": "elevation", offset: "offset_el",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("names", "header", "map_"),
    [
        ("Az (deg),El (deg),dXel (mdeg),dEl (mdeg)", "", "Az,El,d_xel_mdeg=dXel,d_el_mdeg=dEl"),
        (
            "Az [deg],El [deg],XelOff [arcmin],ElOff",
            "",
            "Az [deg],El [deg],d_xel_arcmin=XelOff [arcmin],d_el_arcsec=ElOff",
        ),
        (
            "az,el,dx,off_el",
            "# off_el: true - observed [deg]\n",
            "az,el,d_xel_arcsec=dx,d_el_deg=-off_el",
        ),
        (
            "az,el,dx,off_el",
            "# off_el: Observed minus true\n",
            "az,el,d_xel_arcsec=dx,d_el_arcsec=off_el",
        ),
        (
            "az_obs,el_obs,az_true,el_true,daz,dzd",
            "",
            "az_true,el_true,d_az_arcsec=daz,d_zd_arcsec=dzd",
        ),
        ("ha_h,dec_deg,dx,dy", "", "ha_h=ha_h,dec_deg=dec_deg,d_xel_arcsec=dx,d_el_arcsec=dy"),
    ],
)
def test_what_names_and_header_say_of_units_and_signs(tmp_path, names, header, map_):
    """In brackets, behind the name or in the header; the true direction comes before the read."""
    path = tmp_path / "q.csv"
    path.write_text(f"{header}{names}\n" + ",".join(["1.5"] * len(names.split(","))) + "\n")
    wanted = map_.split(",")
    if "=" not in wanted[0]:
        wanted[:2] = f"az_deg={wanted[0]}", f"el_deg={wanted[1]}"

    assert mapped.propose(sheet(path)) == mapped.parse(",".join(wanted))


NUMBERS = "expected numbers in deg, arcmin, arcsec, mdeg, rad"


@pytest.mark.parametrize(
    ("unit", "proposed", "mapped_"),
    [
        ("gon", f"is in gon, {NUMBERS}", f"has it in gon, {NUMBERS}"),
        ("Gon", f"is in gon, {NUMBERS}", f"has it in gon, {NUMBERS}"),
        ("µrad", f"is in µrad, {NUMBERS}", f"has it in µrad, {NUMBERS}"),
        ("counts", f"is in counts, {NUMBERS}", f"has it in counts, {NUMBERS}"),
        ("s", f"is in s, {NUMBERS}", f"has it in s, {NUMBERS}"),
        ("deg on sky", f"is in deg on sky, {NUMBERS}", f"has it in deg on sky, {NUMBERS}"),
        (
            "Grad",
            "is in grad, expected d_el_deg=dEl [Grad] where that means degrees, not gon",
            "has it in grad, expected d_el_deg=dEl [Grad] where that means degrees, not gon",
        ),
    ],
)
def test_a_unit_that_no_angle_is_read_in_is_refused(tmp_path, unit, proposed, mapped_):
    """It was taken for arcseconds, by `look` and by a map."""
    path = tmp_path / "drives.csv"
    path.write_text(f"Az,El,dEl [{unit}]\n31,42,0.5\n133,54,0.25\n")
    doubts = []

    assert mapped.propose(sheet(path), doubts) == {"az_deg": "Az", "el_deg": "El"}
    assert [one.partition(" is in")[2] for one in doubts] == [proposed.removeprefix("is in")]
    map_ = {"az_deg": "Az", "el_deg": "El", "d_el_arcsec": f"dEl [{unit}]"}
    with pytest.raises(BadInput) as refused:
        read(path, FileOptions(mapping=map_))
    assert str(refused.value).startswith(f"{path}:1: --columns d_el_arcsec=dEl [{unit}]: ")
    assert str(refused.value).endswith(mapped_)


def test_degrees_may_be_called_grad(tmp_path):
    """Whoever maps the column to degrees says which they are."""
    path = tmp_path / "drives.csv"
    path.write_text("Az [Grad],El,dEl [Grad]\n31,42,0.5\n133,54,0.25\n")
    map_ = {"az_deg": "Az [Grad]", "el_deg": "El", "d_el_deg": "dEl [Grad]"}

    assert np.degrees(read(path, FileOptions(mapping=map_)).y) == pytest.approx([0.5, 0.25])


@pytest.mark.parametrize("word", ["encoder", "raw", "obs", "d m s", "h:m:s", "E of N", "C"])
def test_brackets_that_hold_no_unit_say_nothing_of_it(tmp_path, word):
    """Directions are then taken for degrees, offsets for arcseconds."""
    path = tmp_path / "drives.csv"
    path.write_text(f"Az [{word}],El,dEl ({word})\n31,42,0.5\n133,54,0.25\n")
    doubts = []

    assert [*mapped.propose(sheet(path), doubts)] == ["az_deg", "el_deg", "d_el_arcsec"]
    assert not doubts


def test_a_map_that_lacks_a_direction_is_no_command(tmp_path):
    """What is missing is said; a name with a blank is quoted as a shell wants it."""
    (tmp_path / "my night.csv").write_text("az,zd,dxel\n1,2,3\n1,2,3\n")
    said = run("look", tmp_path / "my night.csv")

    assert "not found: a direction (az_deg and el_deg)" in said
    assert "my night.csv' --columns 'az_deg=az, d_xel_arcsec=dxel'" in said


@pytest.mark.parametrize("name", ["", "(a0)"])
def test_a_date_in_a_column_without_a_name_is_neither_time_nor_session(tmp_path, name):
    """A map says where a column is by its name, which this one has not."""
    path = tmp_path / "q.csv"
    row = "10,20,2003-06-01T01:02:03,4\n"
    path.write_text(f"azimuth,elevation,{name},offset_el\n{row}{row}")

    assert {"time_utc", "session"}.isdisjoint(mapped.propose(sheet(path)))


@pytest.mark.parametrize(
    ("header", "columns", "said"),
    [
        ("# latitude: 53\n", "az_deg,el_deg,d_el_arcsec", "did you mean 'latitude_deg'"),
        ("# lat: 53\n", "az_deg,el_deg,d_el_arcsec", "did you mean 'latitude_deg'"),
        ("", "az_deg,el_deg,d_xel_arcsec,d_el_urad", "'urad' is no unit, expected one of deg, arc"),
        ("# Latitude_deg: 53\n", "az_deg,el_deg,d_el_arcsec", "did you mean 'latitude_deg'"),
        ("", "az_deg,el_deg,d_el_arcsec,time_mjd", "time_utc=time_mjd|mjd"),
        ("", "azimuth_deg,el_deg,d_el_arcsec", "did you mean az_deg"),
        ("", "AZ_DEG,EL_DEG,D_EL_ARCSEC", "'AZ_DEG' is not known, did you mean az_deg"),
        ("", "az_deg,el_deg,d_el_arcsec,D_XEL_arcsec", "did you mean d_xel_arcsec"),
        ("", "az_deg,el_deg,d_el_arcsec,TIME_UTC", "did you mean time_utc"),
        ("", "az_deg,el_deg,d_sun_deg,d_elev_arcmin", "'d_elev_arcmin' is .* mean d_el_arcmin"),
        ("", "az_deg,el_deg,d_sun_deg,delta_az_deg", "'delta_az_deg' is .* mean d_az_deg"),
        ("", "az_deg,el_deg,d_sun_deg,dxel_mdeg", "'dxel_mdeg' is .* mean d_xel_mdeg"),
        ("", "az_deg,el_deg,d_sun_deg,d_za_arcsec", "'d_za_arcsec' is .* mean d_zd_arcsec"),
    ],
)
def test_a_name_that_is_nearly_right_is_refused(tmp_path, header, columns, said):
    """With the right one: passed over, it would change the answer without a word."""
    path = tmp_path / "q.csv"
    row = ",".join("1" for _ in columns.split(","))
    path.write_text(f"{header}{columns}\n{row}\n{row}\n")

    with pytest.raises(BadInput, match=said.replace("|", r"\|")):
        read(path)


def test_a_condition_of_another_name_is_kept(tmp_path):
    """A column that nobody knows is kept, also where its name is nearly a known condition's."""
    path = tmp_path / "q.csv"
    path.write_text("az_deg,el_deg,d_el_arcsec,temperature\n1,40,3,10\n2,41,4,11\n")

    np.testing.assert_array_equal(read(path).at.column("temperature"), [10, 11])


def test_a_key_given_by_hand_is_held_to_the_same(log):
    """`--set latitude=30` is refused, `latitude_deg` is taken."""
    text = ", ".join(f"{key}={value}" for key, value in MAP.items())

    assert "did you mean 'latitude_deg'" in run(
        "look", log, "--columns", text, "--set", "latitude=30"
    )
    assert read(log, FileOptions({"latitude_deg": "30"}, mapping=MAP)).at.site is not None


@pytest.mark.parametrize("command", ["fit", "look", "diagnose", "predict", "plot", "convert"])
def test_a_selection_that_keeps_nothing_is_one_line(tmp_path, command):
    """The same in every command that reads recordings."""
    path = tmp_path / "night.csv"
    path.write_text("az_deg,el_deg,d_el_arcsec\n" + "1,50,2\n" * 30)
    more = {"diagnose": ["--out", tmp_path], "plot": ["--out", tmp_path]}.get(command, [])
    more += ["--model", "altaz"] if command == "fit" else []
    more += [tmp_path / "x.csv"] if command == "convert" else []
    said = run(command, path, *more, "--where", "el_deg < 20")

    assert "--where 'el_deg < 20' holds for none of the 30 recordings" in said


def test_units_beside_columns_are_converted_or_refused():
    """An offset called arcsec and given in degrees is 3600 times as large."""
    n = 5
    table = QTable(
        {
            "az": np.full(n, 1.0) * u.rad,
            "el_deg": np.full(n, 50 * 60.0) * u.arcmin,
            "d_xel_arcsec": np.full(n, 0.01) * u.deg,
            "d_el": np.full(n, 2.0) * u.arcsec,
            "temperature": np.full(n, 280.0) * u.K,
            "wind_speed_m_s": np.full(n, 36.0) * u.km / u.h,
            "time": Time("2026-03-01T00:00:00") + np.arange(n) * u.h,
        }
    )
    place = EarthLocation.from_geodetic(18.5 * u.deg, 53.1 * u.deg, 100 * u.m)
    found = from_table(table, {"location": place})

    np.testing.assert_allclose(found.at.az, 1.0)
    np.testing.assert_allclose(np.degrees(found.at.el), 50)
    np.testing.assert_allclose(np.degrees(found.x) * 3600, 36)
    np.testing.assert_allclose(np.degrees(found.y) * 3600, 2)
    np.testing.assert_allclose(found.at.column("temperature_c"), 6.85)
    np.testing.assert_allclose(found.at.column("wind_speed_m_s"), 10)
    np.testing.assert_allclose(np.diff(found.at.column("time")), 3600)
    assert np.degrees(found.at.site.latitude) == pytest.approx(53.1)
    with pytest.raises(BadInput, match="column 'd_xel_arcsec' is in m, expected arcsec"):
        from_table(QTable({**table, "d_xel_arcsec": np.full(n, 1.0) * u.m}))


def test_a_fit_in_python_is_that_of_the_command_line(tmp_path):
    """Add, drop, fix with a Quantity, by the session; coefficients, residuals and rms by name."""
    rng = np.random.default_rng(3)
    n = 200
    az, el = rng.uniform(0, 360, n), np.degrees(np.arcsin(rng.uniform(0.2, 0.95, n)))
    table = QTable(
        {
            "az": az * u.deg,
            "el": el * u.deg,
            "d_xel": rng.normal(0, 2, n) * u.arcsec,
            "d_el": (rng.normal(0, 2, n) + 50 / np.tan(np.radians(el))) * u.arcsec,
            "session": np.where(np.arange(n) < 100, "a", "b"),
        }
    )
    done = pyport.fit(table, add=["TX"], drop=["skew"], fix={"collimation": 3 * u.arcsec})

    assert done.coefficients["TX"].quantity.to_value("arcsec") == pytest.approx(50, abs=3)
    assert done.coefficients["collimation"].value == pytest.approx(3)
    assert done.coefficients["collimation"].sigma is None
    assert "skew" not in done.coefficients
    assert done.residuals["el"].shape == (n,)
    assert set(done.rms) == {"xel", "el", "sky"}
    xel, el, sky = (done.rms[name].to_value("arcsec") for name in ("xel", "el", "sky"))
    assert sky**2 == pytest.approx(xel**2 + el**2, rel=0.05)
    each = pyport.fit(table, per=["antenna", "session"])
    assert {"tilt_north[a]", "tilt_north[b]"} <= set(each.coefficients)
    done.save(tmp_path / "x.toml")
    assert pyport.load_model(tmp_path / "x.toml").values == done.model.values
    with pytest.raises(BadInput, match="weights are 'some'"):
        pyport.fit(table, weights="some")
    with pytest.raises(BadInput, match="fix: collimation is in m"):
        pyport.fit(table, fix={"collimation": 3 * u.m})
    with pytest.raises(BadInput, match="--per el"):
        pyport.fit(table, per="el")
    assert isinstance(Path(done.save(tmp_path / "y.toml")), Path)


def test_a_map_that_nobody_needs_is_not_written_and_said_so(tmp_path):
    """A file under pyport's own names."""
    path, kept = tmp_path / "offsets.csv", tmp_path / "map.toml"
    rows = "".join(f"{20 * n},{30 + n},{n % 3},{n % 2}\n" for n in range(18))
    path.write_text("az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n" + rows)

    assert "map.toml: not written: the columns are read" in run(
        "look", path, "--save-columns", kept
    )
    assert not kept.exists()
