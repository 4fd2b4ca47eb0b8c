"""Files there and back: every real sample, and files made up at random, digit for digit."""

from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from samples import sample

from pyport.errors import BadInput
from pyport.formats import models
from pyport.formats.convert import convert, table_of
from pyport.recordings.formats import registry as tables
from pyport.recordings.raw import FileOptions

DATS = [
    "AT_point_data_20210609_tw003",
    "AT_point_data_20210609_tw003_corr",
    "AT_point_data_20220406_tw004_corr",
    "AT_point_file_20200315T022713",
]
MODS = ["at_20200314_fauto", "at_20220406_fauto", "at_20220406_ia_ie_an_aw_tx10_ca"]
BETWEEN = [".csv", ".ecsv", ".parquet"]


def back(source, between, suffix, to=""):
    """Convert a file to a format between and back, and return what came back."""
    target = between.with_name(f"back{suffix}")
    convert(str(source), between, to=to)
    convert(str(between), target)
    return target


@pytest.mark.parametrize("suffix", BETWEEN)
@pytest.mark.parametrize("name", DATS)
def test_tpoint_observations_come_back(tmp_path, name, suffix):
    """Byte for byte, but for zeros before `nan` and a line break at the end of the file."""
    source = sample(f"auxtel/{name}.dat")

    text = back(source, tmp_path / f"between{suffix}", ".dat").read_text()

    assert text.rstrip() == source.read_text().rstrip().replace("00000000nan 0000000nan", "nan nan")


@pytest.mark.parametrize("suffix", [*BETWEEN, ".katpoint"])
@pytest.mark.parametrize("name", ["lmt", "auxtel2022"])
def test_field_system_data_come_back(tmp_path, name, suffix):
    """Every number with its value, and those that text holds with every digit."""
    source = sample(f"field_system/{name}.xtr")
    to = "katpoint-csv" if suffix == ".katpoint" else ""
    between = tmp_path / (f"between{suffix}" if not to else "between.csv")

    found = back(source, between, ".xtr", to).read_text().split()

    expected = source.read_text().split()
    assert list(map(_number, found)) == list(map(_number, expected)) or to
    assert list(map(_number, found))[4:] == list(map(_number, expected))[4:]


def _number(word):
    try:
        return Decimal(word)
    except ArithmeticError:
        return word


@pytest.mark.parametrize("name", ["lmt", "auxtel2022"])
def test_observations_of_a_fit_come_out_as_they_were_printed(tmp_path, name):
    """The five decimals of `$observed`."""
    source = sample(f"field_system/{name}.err")
    convert(str(source), tmp_path / "x.csv")

    _, _, observed = source.read_text().partition("$observed \n")
    expected = [line.split()[1:5] for line in observed.partition("$")[0].splitlines()]
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert [line.split(",") for line in lines if not line.startswith(("#", "az"))] == expected


@pytest.mark.parametrize("name", MODS)
def test_tpoint_models_come_back_byte_for_byte(tmp_path, name):
    """Through TOML: captions, statistics, marks, digits."""
    source = sample(f"auxtel/{name}.mod")

    assert back(source, tmp_path / "x.toml", ".mod").read_bytes() == source.read_bytes()


@pytest.mark.parametrize("name", ["mdlpo.ctl", "lmt.err", "auxtel2022.err"])
@pytest.mark.parametrize("suffix", [".toml", ".xml", ".ctl"])
def test_field_system_models_come_back(tmp_path, name, suffix):
    """All thirty parameters, and those in use."""
    source = str(sample(f"field_system/{name}"))
    convert(source, tmp_path / f"x{suffix}")

    expected, found = models.read(source), models.read(tmp_path / f"x{suffix}")

    assert [(e.name, e.value, e.used) for e in found.entries] == [
        (e.name, e.value, e.used) for e in expected.entries
    ]


@pytest.mark.parametrize("suffix", [".mod", ".txt"])
@pytest.mark.parametrize("name", ["lmt.err", "auxtel2022.err"])
def test_a_fitted_model_survives_other_vocabularies(tmp_path, name, suffix):
    """Ten decimals of a degree through TPOINT's arcseconds or katpoint's D:M:S."""
    source = sample(f"field_system/{name}")
    convert(str(source), tmp_path / f"x{suffix}")
    convert(str(tmp_path / f"x{suffix}"), tmp_path / "y.ctl")

    expected = {e.name: e.value for e in models.read(source).entries if e.value}
    found = {e.name: e.value for e in models.read(tmp_path / "y.ctl").entries if e.value}

    assert found == expected


def test_a_table_without_names_keeps_its_digits(tmp_path):
    """Columns named on the command line; arcseconds stay arcseconds."""
    source = sample("lmt/PointingData.csv")
    names = ("date_utc", "ut_h", "obsnum", "source", "az_deg", "el_deg", "d_xel_arcsec")
    names += ("sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec")
    given = FileOptions({"latitude_deg": "19"}, names)

    convert(str(source), tmp_path / "x.csv", given=given)

    _, head, *rows = (tmp_path / "x.csv").read_text().splitlines()
    assert head.split(",") == list(names)
    assert rows == source.read_text().split()


def test_arcseconds_on_the_sky_survive_the_field_system(tmp_path):
    """Tenths of arcseconds come back from coordinates in degrees."""
    rows = [("10.5", "80.3", "123.4", "-0.7"), ("359.9", "12.0", "-5.0", "1234.5")]
    lines = [",".join([*row, "0.1", "0.2"]) for row in rows]
    head = "az_deg,el_deg,d_xel_arcsec,d_el_arcsec,sigma_xel_arcsec,sigma_el_arcsec"
    (tmp_path / "a.csv").write_text("\n".join([head, *lines]) + "\n")
    convert(str(tmp_path / "a.csv"), tmp_path / "a.xtr")

    from pyport.angles import ARCSEC
    from pyport.recordings import read

    found = read(tmp_path / "a.xtr")

    assert (found.x / ARCSEC).tolist() == pytest.approx([123.4, -5.0], abs=1e-6)
    assert (found.y / ARCSEC).tolist() == pytest.approx([-0.7, 1234.5], abs=1e-6)
    assert (found.sigma_x / ARCSEC).tolist() == pytest.approx([0.1, 0.1], abs=1e-6)


stars = st.lists(
    st.tuples(
        st.decimals(0, Decimal("359.9999999"), places=7),
        st.decimals(1, Decimal("89.9999999"), places=7),
        st.decimals(-2, 2, places=7),
        st.decimals(-1, 0, places=7),
        st.booleans(),
        st.sampled_from(["", "3C 84", "[12] a; b"]),
    ),
    min_size=1,
    max_size=8,
)


@settings(max_examples=25)
@given(stars, st.sampled_from(BETWEEN))
def test_any_tpoint_file_comes_back(tmp_path_factory, rows, suffix):
    """Over north, masked, with notes and remarks: the second time it is the same file."""
    folder = tmp_path_factory.mktemp("dat")
    lines = ["Mine", ": ALTAZ", ": ROTNL", "-30 14 40.3 2026 2 1", "! a remark"]
    for az, el, d_az, d_el, masked, note in rows:
        turned = az + d_az + (360 if az + d_az < 0 else -360 if az + d_az >= 360 else 0)
        words = f"{az:011.7f} {el:010.7f} {turned:011.7f} {el + d_el:010.7f} 012.5000000"
        lines.append(f"{';' * masked}{words}{' ; ' + note if note else ''}")
    text = "\n".join([*lines, "; the last", "END", ""])
    (folder / "a.dat").write_text(text)

    found = back(folder / "a.dat", folder / f"b{suffix}", ".dat").read_text()

    assert found == text


def test_what_a_format_cannot_hold_is_told(tmp_path):
    """Columns are named; a format that needs more refuses."""
    (tmp_path / "a.csv").write_text("az_deg,el_deg,d_xel_deg,d_el_deg,source\n1,20,0.1,0.2,3C84\n")
    with pytest.raises(BadInput, match="TPOINT needs a latitude"):
        convert(str(tmp_path / "a.csv"), tmp_path / "a.dat")
    with pytest.raises(BadInput, match="no errors sigma_xel_deg"):
        convert(str(tmp_path / "a.csv"), tmp_path / "a.xtr")

    given = FileOptions({"latitude_deg": "53.1"})
    done = convert(str(tmp_path / "a.csv"), tmp_path / "a.dat", given=given)

    assert done.left_out == ("source",)
    assert "53 06 00.0000" in (tmp_path / "a.dat").read_text()
    assert not (tmp_path / "a.xtr").exists()


def test_the_table_that_writers_take_has_the_cells_of_the_file(tmp_path):
    """Text stays text: nothing is parsed that is only carried."""
    (tmp_path / "a.csv").write_text("az_deg,el_deg,d_el_deg\n1.500,020,0.10\n")

    table = table_of(tables.read(tmp_path / "a.csv"))

    assert [column.tolist() for column in table.columns.values()] == [["1.500"], ["020"], ["0.10"]]


@pytest.mark.parametrize(
    ("source", "target", "words"),
    [
        ("missing.csv", "x.dat", "no such file"),
        ("a.csv", "x.abc", "names no format"),
        ("a.csv", "x.err", "name its model with --model"),
        ("m.mod", "x.abc", "no format of models"),
    ],
)
def test_conversions_that_make_no_sense_are_refused(tmp_path, source, target, words):
    """With the file that is wrong, and what was expected."""
    (tmp_path / "a.csv").write_text("az_deg,el_deg,d_el_deg\n1,20,0.1\n")
    (tmp_path / "m.mod").write_text("mine\nT 1 1 0 0\n  IA  +1.0\nEND\n")

    with pytest.raises(BadInput, match=words):
        convert(str(tmp_path / source), Path(tmp_path / target))
