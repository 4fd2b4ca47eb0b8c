"""Files as they come: encodings, decimal commas, conflicts, sizes beyond reason."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import os
import subprocess
import sys
import zipfile

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from pyport.errors import BadInput
from pyport.formats import models
from pyport.formats.models import load
from pyport.recordings import masks, read

HEADER = "az_deg,el_deg,d_el_arcsec,source,time_utc\n"
NIGHT = HEADER + "10,20,3,Café,2003-06-01T18:37:12Z\n-190,40,-1,,\n"


def zipped(content):
    """Return an archive of one file."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("night.csv", content)
    return packed.getvalue()


def refusal(path, reader=read):
    """Return what a reader says of a file, which is one line."""
    with pytest.raises(BadInput) as caught:
        reader(path)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


@pytest.mark.parametrize("lines", ["\n", "\r\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_marks_and_line_ends_change_nothing(tmp_path, encoding, lines):
    """A byte-order mark and CRLF are read as if they were not there."""
    path = tmp_path / "night.csv"
    path.write_bytes(NIGHT.replace("\n", lines).encode(encoding))
    night = read(path)

    assert night.at.column("source").tolist() == ["Café", ""]
    assert night.line.tolist() == [2, 3]


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_other_encodings_are_refused_and_named(tmp_path, encoding):
    """What is no UTF-8 is not guessed at."""
    path = tmp_path / "night.csv"
    path.write_bytes(NIGHT.encode(encoding))

    assert "another encoding (Latin-1, UTF-16, ...), expected UTF-8" in refusal(path)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("az_deg;el_deg;d_el_deg\n41,2;33,0;0,1\n", 1, "separated by commas"),
        ('az_deg,el_deg,d_el_deg\n"41,2","33,0","0,1"\n', 2, "'41,2', expected a number"),
        (HEADER + "1,2,3,,2003-06-01T25:00\n", 2, "ISO 8601"),
        (HEADER + "1,90.5,3,,\n", 2, "highest_el_deg"),
        ("# highest_el_deg: 95\n" + HEADER + "1,95.1,3,,\n", 3, "above 95 deg"),
        (HEADER + "1,2,-inf,,\n", 2, "infinite"),
        ("az_deg,az_arcmin,el_deg,d_el_deg\n1,60,2,3\n", 1, "say the same"),
        ("\ufeff\n", 1, "empty"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, text, line, words):
    """Decimal commas, impossible times, plunge that nobody announced, units twice."""
    path = tmp_path / "night.csv"
    path.write_text(text, encoding="utf-8")

    assert refusal(path).startswith(f"{path}:{line}: ")
    assert words in refusal(path)


@pytest.mark.parametrize(("highest", "el"), [(95, 94), (125, 120), (180, 179)])
def test_beyond_the_zenith_where_the_header_says_so(tmp_path, highest, el):
    """A telescope that plunges announces it."""
    path = tmp_path / "night.csv"
    path.write_text(f"# highest_el_deg: {highest}\n" + HEADER + f"1,{el},3,,\n")

    np.testing.assert_allclose(np.degrees(read(path).at.el), [el])


def test_nan_is_a_blank(tmp_path):
    """Cells that say nan are not measured; a row without anything measured is excluded."""
    path = tmp_path / "night.csv"
    path.write_text("az_deg,el_deg,d_az_deg,d_el_deg\n1,2,nan,3\n1,2,NaN,nan\n")
    night = read(path)

    assert np.isnan(night.x).all()
    assert [one.line for one in night.set_aside] == [3]


def test_times_without_zone_are_utc_and_others_are_turned(tmp_path):
    """`time_utc` is UTC, unless a cell says another zone."""
    path = tmp_path / "night.csv"
    path.write_text(
        HEADER + "1,2,3,,2003-06-01T10:00\n1,2,3,,2003-06-01T10:00Z\n1,2,3,,2003-06-01T12:00+02:00"
    )

    assert np.unique(read(path).at.column("time")).size == 1


def test_azimuths_of_every_turn_of_the_cable(tmp_path):
    """-190 and 170 are one direction, and each is kept as the cable has it."""
    path = tmp_path / "night.csv"
    path.write_text(HEADER + "-190,2,3,,\n170,2,3,,\n530,2,3,,\n")
    az = read(path).at.az

    np.testing.assert_allclose(np.degrees(az), [-190, 170, 530])
    np.testing.assert_allclose(np.cos(az), np.cos(az[0]))


def test_a_row_told_twice_is_used_once(tmp_path):
    """One moment, place and value is one measurement; another value is another."""
    row = "10,20,3,x,2003-06-01T18:37:12Z\n"
    path = tmp_path / "night.csv"
    path.write_text(HEADER + row + row.replace("3,x", "4,x") + row + "1,2,3,,\n1,2,3,,\n")
    night = read(path)

    assert night.line.tolist() == [2, 3, 5, 6]
    assert [(one.line, one.reason) for one in night.set_aside] == [
        (4, "the same as line 2 in every column")
    ]


def test_a_million_columns(tmp_path):
    """They are refused by the header's line."""
    path = tmp_path / "night.csv"
    names = ",".join(f"c{n}" for n in range(10**6))
    path.write_text(f"{names}\n1\n")

    assert "1000000 columns, expected at most 10000" in refusal(path)


def test_a_line_of_two_gigabytes_is_not_read_to_its_end(tmp_path):
    """The file has holes for zeros; a reader that took them all would need more than it gets."""
    path = tmp_path / "night.csv"
    with path.open("wb") as file:
        file.write(HEADER.encode() + b"1,2,3,")
        file.truncate(2 * 2**30)
    limited = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30))\n"
        f"from pyport.recordings import read; read({str(path)!r})"
    )
    done = subprocess.run(
        [sys.executable, "-c", limited],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )

    assert done.stderr.splitlines()[-1].startswith("pyport.errors.BadInput: ")
    assert "line of more than 16 MB" in done.stderr


def test_a_parquet_file_of_endless_equal_cells(tmp_path):
    """Its metadata tell how many cells it stands for, and that is enough to refuse it."""
    path = tmp_path / "night.parquet"
    zeros = pyarrow.DictionaryArray.from_arrays(
        pyarrow.array(np.zeros(10**6, np.int8)), pyarrow.array(["x"])
    )
    names = [f"c{n}" for n in range(201)]
    parquet.write_table(pyarrow.table([zeros] * len(names), names=names), path)

    assert path.stat().st_size < 10**6
    assert "1000000 rows of 201 columns" in refusal(path)


def test_a_parquet_file_of_one_long_text_a_thousand_times(tmp_path):
    """A text is looked at once, however often it stands there."""
    path = tmp_path / "night.parquet"
    long = pyarrow.DictionaryArray.from_arrays(
        pyarrow.array(np.zeros(1000, np.int8)), pyarrow.array(["x" * 10**5])
    )
    parquet.write_table(pyarrow.table({"source": long}), path, store_schema=False)

    assert "source has more than 1000 characters" in refusal(path)


def test_text_that_would_fill_the_memory_when_padded(tmp_path):
    """A cell as long as any may be is refused where it would cost that in too many rows."""
    path = tmp_path / "night.csv"
    rows = "1,2,3,,\n" * 300_000
    path.write_text(HEADER + rows + f"1,2,3,{'x' * 999},\n")

    assert refusal(path).startswith(f"{path}:300002: ")


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress, lzma.compress, zipped])
@pytest.mark.parametrize("suffix", [".csv", ".ecsv", ".parquet", ".dat", ".xtr", ".csv.gz", ".zip"])
def test_nothing_is_unpacked(tmp_path, pack, suffix):
    """An archive is no format of recordings, whatever it calls itself; so it cannot swell."""
    path = tmp_path / f"night{suffix}"
    path.write_bytes(pack(NIGHT.encode() * 1000))

    said = refusal(path)
    assert said.startswith(f"{path}:")
    if pack is gzip.compress and suffix in {".csv", ".dat", ".xtr", ".csv.gz"}:
        assert "packed by gzip, expected it unpacked" in said


@pytest.mark.parametrize("pack", [gzip.compress, zipped])
@pytest.mark.parametrize("suffix", [".toml", ".json", ".xml", ".mod", ".ctl", ".txt", ".err"])
def test_no_model_is_unpacked(tmp_path, pack, suffix):
    """Nor is one a model."""
    path = tmp_path / f"model{suffix}"
    path.write_bytes(pack(b'vocabulary = "tpoint"\n' * 1000))

    said = refusal(path, lambda file: load(str(file)))
    assert said.startswith(f"{path}:")
    assert ("packed by gzip" in said) == (pack is gzip.compress)


@pytest.mark.parametrize("suffix", [".toml", ".json", ".xml", ".mod", ".ctl", ".txt", ".err"])
def test_an_empty_model_is_refused_as_empty(tmp_path, suffix):
    """It says nothing of recordings, which no model is."""
    path = tmp_path / f"model{suffix}"
    path.write_text("\n")

    said = refusal(path, lambda file: load(str(file)))
    assert said == f"{path}:1: the file is empty, expected text"


def test_entities_that_refer_to_each_other(tmp_path):
    """XML that would swell to a thousand million words is refused for its entities."""
    path = tmp_path / "model.xml"
    levels = "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 10))
    path.write_text(f'<!DOCTYPE P [<!ENTITY a0 "x">{levels}]><P>&a9;</P>')

    assert refusal(path, lambda file: load(str(file))).startswith(f"{path}:")


def test_yaml_that_refers_to_itself(tmp_path):
    """Nine levels of ten references each would be a thousand million words."""
    path = tmp_path / "night.ecsv"
    levels = ["# - {a0: &a0 [x, x, x, x, x, x, x, x, x, x]}"]
    levels += [f"# - {{a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]}}" for n in range(1, 9)]
    path.write_text(
        "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: az_deg, datatype: float64}\n"
        "# - {name: el_deg, datatype: float64}\n# - {name: d_el_deg, datatype: float64}\n"
        "# meta: !!omap\n" + "\n".join(levels) + "\naz_deg el_deg d_el_deg\n1 2 3\n"
    )

    assert sum(map(len, read(path).meta.values())) < 10**6


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("deep.toml", "term = " + "[" * 5000 + "]" * 5000),
        ("long.toml", "term = [{effect = 'tilt', value_deg = " + "9" * 5000 + "}]"),
        ("row.toml", "term = [1]"),
        ("per.toml", "term = [{effect = 'azimuth_zero', per = 3}]"),
        ("word.toml", "term = [{effect = 'azimuth_zero', per = 'antenna'}]"),
        ("text.toml", "term = [{effect = 'azimuth_zero', value_deg = 'x'}]"),
        ("nan.toml", "term = [{effect = 'azimuth_zero', value_deg = nan}]"),
        ("terms.toml", "vocabulary = 'tpoint'\nterm = " + "[" * 5000 + "]" * 5000),
        ("deep.json", "[" * 100_000),
        ("mark.mod", "\ufeff"),
    ],
)
def test_models_that_are_none(tmp_path, name, text):
    """Nested or long beyond reason, or of another kind than expected."""
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")

    assert refusal(path, lambda file: load(str(file))).startswith(f"{path}:")
    assert models.split(path)[0] == path


def test_a_mask_that_is_no_text(tmp_path):
    """A torn mask is refused by its own name, not the recordings'."""
    path = tmp_path / "night.csv"
    path.write_text(NIGHT)
    masks.path_of(path).write_bytes(b"+ 2 #\xff\xfe")

    assert refusal(path).startswith(f"{masks.path_of(path)}:1: ")
