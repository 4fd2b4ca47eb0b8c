"""katpoint: description strings, its configuration files, and its table of offsets."""

import json
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import DEG
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.formats import katpoint_model, models
from pyport.formats.convert import convert
from pyport.formats.models import load
from pyport.recordings import read

GOLDEN = json.loads((Path(__file__).parent / "katpoint_golden.json").read_text())["models"]


@pytest.mark.parametrize("golden", GOLDEN)
def test_offsets_are_katpoints(golden):
    """As katpoint itself computed them, for descriptions of up to 22 parameters."""
    az, el, d_az, d_el = (
        np.array(golden[name]) * DEG for name in ("az_deg", "el_deg", "d_az_deg", "d_el_deg")
    )

    x, y = load(golden["description"]).offsets(Circumstances(az, el))

    np.testing.assert_allclose(x, d_az * np.cos(el), atol=1e-15)
    np.testing.assert_allclose(y, d_el, atol=1e-15)


@pytest.mark.parametrize("golden", GOLDEN)
@pytest.mark.parametrize("between", ["x.toml", "x.ctl", "x.txt"])
def test_a_description_comes_back_letter_for_letter(tmp_path, golden, between):
    """Also through the Field System's degrees."""
    path = tmp_path / "own.txt"
    path.write_text(golden["description"] + "\n")

    convert(str(path), tmp_path / between)
    convert(str(tmp_path / between), tmp_path / "back.txt")

    back = (tmp_path / "back.txt").read_text().split()
    expected = golden["description"].split()
    if between == "x.ctl":  # ratios are degrees there, and what does nothing is not carried
        expected = ["0" if n in {1, 9} else word for n, word in enumerate(expected)]
        while expected[-1] == "0":
            expected.pop()
        assert [w for n, w in enumerate(back) if n not in {8, 11}] == [
            w for n, w in enumerate(expected) if n not in {8, 11}
        ]
        for n in {8, 11} & set(range(len(expected))):
            assert float(back[n]) == pytest.approx(float(expected[n]), rel=1e-8)
    else:
        assert back == expected


def test_its_configuration_file_is_read(tmp_path):
    """[header] and [params] with comments, names in lower case as it writes them."""
    path = tmp_path / "model.cfg"
    path.write_text(
        "[header]\nantenna = x\n\n[params]\np1  = -0:02:25.5     ; deg (az [tpoint -IA])\n"
        "p9  = 7.614e-05      ;  (el scale)\n"
    )

    found = {entry.name: (str(entry.value), entry.unit) for entry in models.read(path).entries}

    assert found == {"P1": ("-145.5", "arcsec"), "P9": ("0.00007614", "")}


ANTENNA = "m000, -30:42:39.8, 21:26:38.0, 1086.6, 13.5, 1 2 3, -0:04:45.1 0 0:00:08.2, 1.2"
TABLE = f"""# antenna = {ANTENNA}
dataset, target, timestamp_ut, azimuth, elevation, delta_azimuth, delta_azimuth_std, \
delta_elevation, delta_elevation_std, temperature, keep
1234, 3C84, 2026-02-01 12:00:00, 10.5000000, 40.2500000, 0.1000000, 0.0100000, -0.2, 0.02, 21.5, 1
1234, "Vir A", 2026-02-01 12:10:00, 359.5, 60.0, nan, 0.0, 0.1, 0.0, 20.5, 1
1235, 3C84, 2026-02-01 12:20:00, 20.5, 50.0, 0.1, 0.01, 0.1, 0.01, 20.5, 0
"""


@pytest.fixture
def table(tmp_path):
    """Return a file of offsets."""
    path = tmp_path / "offsets.csv"
    path.write_text(TABLE)
    return path


def test_its_table_is_known_by_its_columns(table):
    """Degrees, azimuth as a coordinate, the antenna's place, what is not kept excluded."""
    found = read(table)

    assert found.at.site.latitude / DEG == pytest.approx(-30.711055556)
    assert found.at.site.longitude / DEG == pytest.approx(21.443888889)
    assert found.x[0] / DEG == pytest.approx(0.1 * np.cos(40.25 * DEG))
    assert np.isnan(found.x[1])
    assert np.isnan(found.sigma_y[1])
    assert found.at.column("source").tolist() == ["3C84", "Vir A"]
    assert found.at.column("session").tolist() == ["1234", "1234"]
    assert [one.reason for one in found.set_aside] == ["not kept in the file"]


def test_its_table_comes_back(table, tmp_path):
    """Through the contract's columns, every cell and the antenna's description."""
    convert(str(table), tmp_path / "x.ecsv")
    convert(str(tmp_path / "x.ecsv"), tmp_path / "y.csv", to="katpoint-csv")

    head, names, *rows = (tmp_path / "y.csv").read_text().splitlines()

    assert head == f"# antenna = {ANTENNA}"
    found = dict(zip(names.split(", "), rows[0].split(", "), strict=True))
    assert (found["target"], found["azimuth"], found["keep"]) == ("3C84", "10.5", "1")
    assert found["delta_azimuth"] == "0.1"
    assert rows[2].endswith("0")
    np.testing.assert_array_equal(read(tmp_path / "y.csv").x, read(table).x)


def test_scans_of_a_session_are_one_session(table, tmp_path):
    """MeerKAT's datasets name the session and the scan: two labels, and one again when written."""
    table.write_text(table.read_text().replace("1234, ", "1234_sdp_l0 scan 57, "))
    found = read(table)
    convert(str(table), tmp_path / "x.csv", to="katpoint-csv")

    assert found.at.column("session").tolist() == ["1234_sdp_l0"] * 2
    assert found.at.column("scan").tolist() == ["scan 57"] * 2
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert [line.split(", ")[0] for line in lines[2:]] == ["1234_sdp_l0 scan 57"] * 2 + ["1235"]


def test_the_antennas_own_model_is_the_files(table):
    """`--model offsets.csv` takes the model out of the antenna's description."""
    entries = katpoint_model.read(table).entries

    assert [(entry.name, str(entry.value)) for entry in entries] == [
        ("P1", "-285.1"),
        ("P3", "8.2"),
    ]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("azimuth, elevation, delta_azimuth\n1,2,3\n", 1, "no column delta_elevation"),
        ("azimuth,elevation,delta_azimuth,delta_elevation\n", 1, "no rows"),
        ("azimuth,elevation,delta_azimuth,delta_elevation\n1,2,3\n", 2, "3 cells, expected 4"),
        (
            "azimuth,elevation,delta_azimuth,delta_elevation\n1,2,3,x\n",
            2,
            "expected a number or blank",
        ),
    ],
)
def test_a_bad_table_names_its_line(tmp_path, text, line, words):
    """One line that says what was expected."""
    path = tmp_path / "bad.csv"
    path.write_text(text)

    with pytest.raises(BadInput, match=words) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello\n", "expected a katpoint description"),
        ("0 " * 23 + "\n", "23 parameters, expected at most 22"),
        ("[header]\nx = 1\n", "no katpoint model"),
        ("[header]\nx = 1\n[params]\nq1 = 1\n", "expected P1 to P22"),
    ],
)
def test_a_bad_description_is_refused(tmp_path, text, words):
    """Nothing is taken for a model that is none."""
    path = tmp_path / "bad.txt"
    path.write_text(text)

    with pytest.raises(BadInput, match=words):
        models.read(path)


def test_a_place_that_nobody_told_is_not_made_up(tmp_path):
    """Without a longitude the antenna has its name alone; the latitude comes back, of its line."""
    table = tmp_path / "mine.csv"
    table.write_text("# latitude_deg: 50\naz_deg,el_deg,d_az_deg,d_el_deg\n10,40,0.1,0.1\n")
    convert(table, tmp_path / "out.csv", to="katpoint-csv")

    assert (tmp_path / "out.csv").read_text().startswith("# antenna = antenna\n")
    site = read(tmp_path / "out.csv").at.site
    assert site.latitude / DEG == pytest.approx(50)
    assert site.longitude is None
