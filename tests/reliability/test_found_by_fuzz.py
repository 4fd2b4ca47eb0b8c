"""Inputs that spoilt files led to, and that once ended in a bare exception: one clear line each."""

import io
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow
import pytest
from astropy import units
from click.testing import CliRunner
from pyarrow import parquet

from pyport.cli import pyport
from pyport.errors import BadInput
from pyport.formats import katpoint_model
from pyport.formats.models import load
from pyport.models.conditions import columns_of
from pyport.recordings import read, where
from pyport.recordings.formats.mapped import propose
from pyport.recordings.formats.sheet import sheet
from pyport.recordings.from_table import from_table
from pyport.recordings.stream import chunk
from pyport.watch import state

ROWS = "az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n10,20,1,2\n30,40,2,1\n"
KATPOINT = (
    "# antenna = x, -30:429999999999999999999999:39.8, 21:26:38.0, 1086.6\n"
    "target, azimuth, elevation, delta_azimuth, delta_elevation, keep\nA, 1, 20, 0.1, 0.2, 1\n"
)
TERMS = 'vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_arcsec = 1e9999999999999999999999\n'


def test_a_latitude_beyond_the_turn(tmp_path):
    """In a katpoint file."""
    (tmp_path / "a.csv").write_text(KATPOINT)
    with pytest.raises(BadInput, match=r"a\.csv:1: latitude_deg .* at most 360 degrees"):
        read(tmp_path / "a.csv")


def test_an_exponent_that_no_number_has(tmp_path):
    """In a model with another program's names."""
    (tmp_path / "a.toml").write_text(TERMS)
    with pytest.raises(BadInput, match="expected TOML"):
        load(str(tmp_path / "a.toml"))


@pytest.mark.parametrize("rows", ["", "10,20,2003-06-01,4,5\n"])
def test_rows_wider_than_their_names_and_no_rows(tmp_path, rows):
    """Nothing is proposed for a cell without a name."""
    (tmp_path / "a.csv").write_text("az_deg,el_deg\n" + rows)

    assert "session" not in propose(sheet(tmp_path / "a.csv"))


def test_a_filter_with_a_number_too_large(tmp_path):
    """It is no number that a recording could have."""
    (tmp_path / "a.csv").write_text(ROWS)
    asked = ["look", str(tmp_path / "a.csv"), "--where", f"el_deg < {10**400}"]
    said = CliRunner().invoke(pyport, asked)

    assert isinstance(said.exception, BadInput)
    assert "expected a number below 1.8e308" in str(said.exception)


@pytest.mark.parametrize("key", ["session", "time"])
@pytest.mark.parametrize("value", [np.arange(3) * units.m, [3 * units.m, 4], [[1, 2], [3]]])
def test_labels_and_times_of_no_shape(key, value):
    """A Quantity among texts, and rows of unlike lengths."""
    with pytest.raises(BadInput, match=f"{key} is"):
        columns_of({key: value})


def test_a_dictionary_of_text_that_is_none(tmp_path):
    """In Parquet, where Arrow looks at bytes only when they are asked for."""
    path = tmp_path / "a.parquet"
    night = pyarrow.array(["night one"] * 3).dictionary_encode()
    columns = {name: [1.0, 2.0, 3.0] for name in ROWS.splitlines()[0].split(",")}
    parquet.write_table(
        pyarrow.table({**columns, "session": night}), path, compression="none", use_dictionary=True
    )
    path.write_bytes(path.read_bytes().replace(b"night one", b"night\xa6one"))
    with pytest.raises(BadInput, match="no Parquet table"):
        read(path)


def test_targets_of_antiquity(tmp_path):
    """The ephemeris ends."""
    (tmp_path / "a.csv").write_text("# latitude_deg: 50\n# longitude_deg: 18\n" + ROWS)
    asked = ["targets", str(tmp_path / "a.csv"), "--start", "0026-03-01T02:10:00"]
    said = CliRunner().invoke(pyport, asked)

    assert isinstance(said.exception, BadInput)
    assert "expected a date between 1900 and 2100" in str(said.exception)


def test_a_state_whose_header_ends_early(tmp_path):
    """It is no state."""
    path, whole = tmp_path / "watch.state", io.BytesIO()
    np.save(whole, np.array("k" * 64))
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("key.npy", whole.getvalue().replace(b"}", b"("))
    with pytest.raises(BadInput, match="no state of a watch"):
        state.load(None, path)


@pytest.mark.parametrize("az", ["0:77777777710:1", "0:7777777771e9:1", "0:99999:1"])
def test_a_grid_that_no_memory_holds(tmp_path, az):
    """Refused before it is made."""
    asked = ["table", "--az", az, "--zd", "20:90:0.01", "-o", str(tmp_path / "table.dat")]
    said = CliRunner().invoke(pyport, asked)

    assert isinstance(said.exception, BadInput)
    assert "expected at most 10,000,000" in str(said.exception)


def test_cells_that_are_arrays():
    """In a column of objects, beside one that is text."""
    cells = np.empty(2, object)
    cells[0], cells[1] = np.arange(3), "night one"
    numbers = {name: [1.0, 2.0] for name in ROWS.splitlines()[0].split(",")}
    with pytest.raises(BadInput, match="column 'session'"):
        from_table({**numbers, "session": cells})


def test_an_exponent_beyond_any_in_ska_mid(tmp_path):
    """A number that decimal arithmetic has no room for."""
    path = tmp_path / "a.json"
    path.write_text('{"coefficients": {"IA": {"value": 1e99999999999999999999}}}')
    with pytest.raises(BadInput, match="not SKA-Mid's JSON"):
        katpoint_model.read_ska_mid(path)


@pytest.mark.parametrize("value", [[1.0, 2.0] * units.deg, 3 * units.m])
def test_a_header_of_several_numbers_or_of_none(value):
    """An angle is one number, in a unit of angle."""
    numbers = {name: [1.0, 2.0] for name in ROWS.splitlines()[0].split(",")}
    with pytest.raises(BadInput, match="header latitude_deg is of type Quantity"):
        from_table(numbers, {"latitude_deg": value})


def test_a_dictionary_that_lacks_what_it_names():
    """In Parquet: rows point beyond the texts."""
    beyond = pyarrow.DictionaryArray.from_arrays(
        pyarrow.array([0, 5]), pyarrow.array(["night one"]), safe=False
    )
    with pytest.raises(BadInput, match="names texts that it does not hold"):
        chunk._labels({"session": beyond}, SimpleNamespace(labels=(), file=Path("a.parquet")), 2)


def test_a_filter_by_nothing():
    """Neither kept nor excluded."""
    with pytest.raises(BadInput, match="a value at least"):
        where.parse("source in ()")


def test_a_description_that_ends_as_no_number_does():
    """Refused at once: numbers of two digits could be read in two ways each, 2^40 together."""
    assert not katpoint_model.is_description("11 " * 40 + "x")
