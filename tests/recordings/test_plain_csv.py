"""A plain CSV by Arrow: the cells, numbers, times and errors that Python's own reader gives."""

from __future__ import annotations

import numpy as np
import pyarrow
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.formats import csv
from pyport.recordings.raw import Raw, TextColumn

NUMBERS = (
    "1", "-1.5", "+2.5", ".5", "5.", "1e3", "1E-320", "1_000", " 7", "7 ", "", " ", "nan", "NaN",
    "-nan", "nan(1)", "inf", "-Infinity", "1e999", "0x10", "1,5", "١", "1.5f", "three",
    "0.1", "123456789.123456789123456789", "4.9406564584124654e-324", "2.2250738585072011e-308",
)  # fmt: skip
TIMES = (
    "2003-06-01T18:37:12Z", "2003-06-01T18:37:12", "2003-06-01 18:37:12.5", "2003-06-01",
    "2003-06-01T18:37:12.123456Z", "2003-06-01T18:37:12.123456789Z", "20030601T183712Z",
    "2003-06-01T18:37:12+02:00", "2003-06-01T18:37Z", "2003-06-01T18", "", " 2003-06-01 ",
    "0000-01-01", "0001-01-01", "9999-12-31T23:59:59.999999", "2003-02-30", "2003-06-01T24:00:00",
    "2003-06-01T18:37:60", "noon", "2016-12-31T23:59:60Z", "2003-W22-7", "1969-12-31T23:59:59.9Z",
)  # fmt: skip
LINE = st.lists(
    st.sampled_from(["1", "-2.5", "", "3C84", "# x", "#", " ", "Toruń", '"a"', '"', "'", "\\"]),
    min_size=1,
    max_size=4,
).map(",".join)


def answer(ask):
    """Return what is answered, an error as its text."""
    try:
        return ask()
    except BadInput as error:
        return str(error)


def same(one, other):
    """Tell whether two answers are equal, bit by bit where they are numbers."""
    if isinstance(one, str) or isinstance(other, str):
        return isinstance(one, str) and isinstance(other, str) and one == other
    return one.dtype == other.dtype and one.tobytes() == other.tobytes()


def both(cells, tmp_path):
    """Return the cells as Arrow holds them, and as an array of strings."""
    lines = np.arange(2, 2 + len(cells))
    columns = TextColumn(pyarrow.array(cells, pyarrow.string())), np.array(cells, object)
    return [Raw(tmp_path / "a.csv", {}, 1, {"column": one}, lines) for one in columns]


@pytest.mark.parametrize("ask", [Raw.numbers, Raw.seconds, Raw.words, Raw.numbers_or_words])
@given(cells=st.lists(st.sampled_from(NUMBERS + TIMES), min_size=1, max_size=3))
def test_same_answers(ask, cells, tmp_path_factory):
    """Columns are the same numbers, times and words, or the same error at the same line."""
    by_arrow, by_python = both(cells, tmp_path_factory.getbasetemp())

    assert same(answer(lambda: ask(by_arrow, "column")), answer(lambda: ask(by_python, "column")))


@pytest.mark.parametrize("ask", [Raw.numbers, Raw.seconds])
@pytest.mark.parametrize("cell", NUMBERS + TIMES)
def test_same_answer(ask, cell, tmp_path):
    """Each doubtful cell is what it is to Python's functions."""
    by_arrow, by_python = both([cell, ""], tmp_path)

    assert same(answer(lambda: ask(by_arrow, "column")), answer(lambda: ask(by_python, "column")))


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1).map(tuple))
def test_numbers_to_the_last_bit(values):
    """A number's shortest text gives it back."""
    found = TextColumn(pyarrow.array([repr(one) for one in values])).numbers()

    np.testing.assert_array_equal(found, values)


@pytest.mark.slow
@settings(deadline=None)
@given(
    lines=st.lists(LINE, max_size=6),
    end=st.sampled_from(["\n", "\r\n", "\r", "\n\n"]),
    last=st.booleans(),
    head=st.sampled_from(["a,b\n", "# latitude_deg: 1\r\na,b\r\n", "\n# x\na,b,c\n"]),
)
def test_same_rows(lines, end, last, head, tmp_path_factory):
    """Rows, their lines and what is wrong with them do not depend on who reads them."""
    path = tmp_path_factory.getbasetemp() / "rows.csv"
    path.write_bytes((head + end.join(lines) + end * last).encode())

    with pytest.MonkeyPatch.context() as patch:
        by_python = answer(lambda: csv.read(path))
        patch.setattr(csv, "LEAST_BYTES", 1)
        by_arrow = answer(lambda: csv.read(path))

    if isinstance(by_python, str) or isinstance(by_arrow, str):
        assert by_arrow == by_python
    else:
        assert by_arrow.meta == by_python.meta
        assert by_arrow.header_line == by_python.header_line
        assert by_arrow.line.tolist() == by_python.line.tolist()
        assert {k: v.tolist() for k, v in by_arrow.columns.items()} == {
            k: v.tolist() for k, v in by_python.columns.items()
        }


def test_it_is_arrow_that_reads_a_large_plain_file(tmp_path, monkeypatch):
    """Comments and blank lines between rows do not hinder it, a quote does."""
    monkeypatch.setattr(csv, "LEAST_BYTES", 20)
    path = tmp_path / "night.csv"
    path.write_text("a,b\n1,2\n\n# a remark, with a comma\n3,4\n" + "5,6\n" * 5)
    rows = csv.read(path)

    assert isinstance(rows.columns["a"], TextColumn)
    assert rows.line.tolist() == [2, 5, 6, 7, 8, 9, 10]
    assert rows.columns["b"][1] == "4"
    assert rows.columns["b"][[0, 1]].tolist() == ["2", "4"]

    path.write_text('a,b\n1,2\n3,"4"\n' + "5,6\n" * 5)

    assert isinstance(csv.read(path).columns["a"], np.ndarray)


@pytest.mark.parametrize("least", [20, 2**22])
def test_the_index_of_pandas_is_passed_over(tmp_path, monkeypatch, least):
    """A first column without a name that counts from 0, by either reader; another needs a name."""
    monkeypatch.setattr(csv, "LEAST_BYTES", least)
    path = tmp_path / "frame.csv"
    path.write_text(",az_deg,el_deg,d_el_arcsec\n0,11,41,2\n1,95,52,-3\n2,203,63,4\n")
    found = read(path)

    assert np.degrees(found.at.az) == pytest.approx([11, 95, 203])
    assert found.notes == (
        "the first column, which has no name and counts the rows from 0, is passed over",
    )
    path.write_text(path.read_text().replace("\n1,95", "\n7,95"))
    with pytest.raises(BadInput, match=r"csv:3: column 1 of the header has no name, .* has '7'"):
        read(path)
    path.write_text("az_deg,,d_el_arcsec\n0,0,2\n1,1,-3\n")
    with pytest.raises(BadInput, match=r"csv:1: column 2 of the header has no name, expected one"):
        read(path)


def test_a_long_cell_is_named_with_its_line(tmp_path):
    """A runaway cell is refused at its line, whoever holds the text."""
    cells = ["3C84", "3C48", "C" * 2000, "3C84"]

    messages = [answer(lambda raw=raw: raw.words("column")) for raw in both(cells, tmp_path)]

    assert messages[0] == messages[1]
    assert ":4: " in messages[0]
