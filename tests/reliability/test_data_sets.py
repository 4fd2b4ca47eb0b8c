"""Data sets of Parquet files that are spoilt, or promise more than anybody can hold."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.raw import LONGEST_CELL
from pyport.recordings.stream.chunk import MOST_CODES

ROWS = 50
COLUMNS = {
    "az_deg": np.arange(ROWS, dtype=float),
    "el_deg": np.linspace(20, 70, ROWS),
    "d_xel_arcsec": np.ones(ROWS),
    "d_el_arcsec": np.ones(ROWS),
}


def written(folder, columns, **about):
    """Write columns as the one file of a data set; return the file."""
    path = folder / "set" / "night.parquet"
    path.parent.mkdir(exist_ok=True)
    table = columns if isinstance(columns, pyarrow.Table) else pyarrow.table(columns)
    parquet.write_table(table, path, **about)
    return path


def refusal(path):
    """Return what is said of a data set, which is one line that names the file."""
    with pytest.raises(BadInput) as caught:
        read(path.parent)
    assert str(caught.value).startswith(f"{path}:1: ")
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


def endless(text, rows=ROWS):
    """Return a column of one text many times, which a file holds once."""
    return pyarrow.DictionaryArray.from_arrays(
        pyarrow.array(np.zeros(rows, np.int8)), pyarrow.array([text])
    )


@pytest.mark.parametrize("place", [0.02, 0.3, 0.9])
def test_a_file_with_a_hole_is_refused(tmp_path, place):
    """Pages, footer or magic number overwritten: no table."""
    path = written(tmp_path, COLUMNS)
    whole = path.read_bytes()
    start = int(place * len(whole))
    path.write_bytes(whole[:start] + b"\xff" * 64 + whole[start + 64 :])

    assert "no Parquet table" in refusal(path)


def test_header_keys_that_are_no_text_are_refused(tmp_path):
    """Keys are UTF-8, as everywhere."""
    table = pyarrow.table(COLUMNS).replace_schema_metadata({b"telescope": b"\xff\xfe"})

    assert "no Parquet table" in refusal(written(tmp_path, table))


def test_two_columns_of_one_name_are_refused(tmp_path):
    """Neither of them is believed."""
    names = [*COLUMNS, "d_el_arcsec"]
    table = pyarrow.table([*COLUMNS.values(), np.zeros(ROWS)], names=names)

    assert "two columns are called 'd_el_arcsec'" in refusal(written(tmp_path, table))


def test_a_column_of_lists_is_refused_where_numbers_are_expected(tmp_path):
    """Elevations are numbers."""
    lists = pyarrow.array([[1.0, 2.0]] * ROWS)

    assert "'el_deg' is list" in refusal(written(tmp_path, {**COLUMNS, "el_deg": lists}))


def test_one_long_text_many_times_is_refused(tmp_path):
    """It is looked at once, however often it stands there."""
    source = endless("x" * (LONGEST_CELL + 1))

    said = refusal(written(tmp_path, {**COLUMNS, "source": source}, store_schema=False))
    assert "source has more than 1000 characters" in said


def test_rows_without_end_are_refused(tmp_path):
    """Twenty million equal rows in a few hundred kilobytes are no measurements."""
    path = tmp_path / "set" / "night.parquet"
    path.parent.mkdir()
    schema = pyarrow.schema([(name, pyarrow.int8()) for name in COLUMNS])
    zeros = pyarrow.table([pyarrow.array(np.zeros(10**6, np.int8))] * 4, schema=schema)
    with parquet.ParquetWriter(path, schema, compression="gzip") as file:
        for _ in range(20):
            file.write_table(zeros)

    assert path.stat().st_size < 10**6
    assert "20000000 rows in" in refusal(path)


def test_text_that_nobody_asked_for_is_not_read(tmp_path):
    """A remark of 100 MB a row stays where it is."""
    path = written(tmp_path, {**COLUMNS, "remark": endless("x" * 10**8)}, store_schema=False)
    limited = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31))\n"
        f"from pyport.recordings import read; print(len(read({str(path.parent)!r})))"
    )
    done = subprocess.run(
        [sys.executable, "-c", limited],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )

    assert done.stderr == ""
    assert int(done.stdout) > 0


def test_labels_of_more_sets_than_memory_has_places_for(tmp_path):
    """What counts is how many sets of labels there are, not how many there could be."""
    labels = {
        name: [f"{name}{n}" for n in range(ROWS)] for name in ("antenna", "session", "source")
    }
    labels |= dict.fromkeys(("receiver", "channel", "polarisation"), labels["antenna"])
    assert ROWS ** len(labels) > MOST_CODES

    points = read(written(tmp_path, {**COLUMNS, **labels}).parent)

    assert sorted(points.at.column("session")) == sorted(labels["session"])
    for session, source in zip(
        points.at.column("session"), points.at.column("source"), strict=True
    ):
        assert session.removeprefix("session") == source.removeprefix("source")


def test_blank_times_of_text_are_counted(tmp_path):
    """A row without a time is excluded, as in a file of text."""
    times = ["2003-06-01T12:00:00Z"] * (ROWS - 1) + [""]
    points = read(written(tmp_path, {**COLUMNS, "time_utc": times}).parent)

    assert [one.line for one in points.set_aside] == [ROWS]
