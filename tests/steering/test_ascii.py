"""The ASCII table: its layout, its bytes, and what a broken one is told."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.errors import BadInput
from pyport.steering import Grid, Table, read_ascii, tabulate, write_ascii
from pyport.steering.ascii import rows
from pyport.steering.published import FOLDER

SMALL = Grid(np.array([-1.0, 0, 1]), np.array([10.0, 11]))


@pytest.fixture(scope="module")
def table():
    """Return the 3model table on its whole grid."""
    return tabulate("rt32-3model")


def test_layout_is_the_printed_one(table):
    """Azimuth and zenith distance stand in the columns where the page has them."""
    printed = [
        line for line in (FOLDER / "3model_rows.txt").read_text().splitlines() if ".0" in line
    ]
    ours = {line[:7]: line for line in rows(table)}
    for line in printed:
        row = ours[line[:7]]

        assert len(row) == len(line)
        assert [i for i, c in enumerate(row) if c == "."] == [
            i for i, c in enumerate(line) if c == "."
        ]


def test_same_table_same_bytes(table, tmp_path):
    """Writing twice gives the same file, and reading it gives the numbers back."""
    write_ascii(table, tmp_path / "a.txt")
    write_ascii(table, tmp_path / "b.txt")
    again = read_ascii(tmp_path / "a.txt")

    assert (tmp_path / "a.txt").read_bytes() == (tmp_path / "b.txt").read_bytes()
    np.testing.assert_allclose(again.d_az_deg, table.d_az_deg, rtol=0, atol=0.50001e-7)
    np.testing.assert_allclose(again.d_zd_deg, table.d_zd_deg, rtol=0, atol=0.50001e-7)


def test_zero_has_no_sign():
    """What rounds to zero is written as plain zero from either side."""
    tiny = np.full((3, 2), -1e-9)
    lines = list(rows(Table(SMALL, tiny, -tiny, "m", "r")))

    assert lines[0] == "  -1 10   0.0000000   0.0000000"


@pytest.mark.usefixtures("both_paths")
@pytest.mark.parametrize("offset", [214.7483648, -1e30, np.inf, np.nan])
def test_an_offset_that_does_not_fit_is_refused(offset):
    """So is one that is no number."""
    with pytest.raises(BadInput, match="does not fit into 12 columns"):
        list(rows(Table(SMALL, np.full((3, 2), offset), np.zeros((3, 2)))))


@pytest.mark.usefixtures("both_paths")
@pytest.mark.parametrize("az_deg", [(9998, 9999, 10000), (-0.5, 0.0, 1e5)])
def test_a_direction_that_does_not_fit_is_refused(az_deg):
    """Whole degrees have four columns, others ten."""
    grid = Grid(np.array(az_deg), SMALL.zd_deg)
    with pytest.raises(BadInput, match=r"0 deg does not fit into (4|10) columns"):
        list(rows(Table(grid, np.zeros((3, 2)), np.zeros((3, 2)))))


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("", 1, "0 rows"),
        ("1 2 3\n", 1, "four numbers"),
        ("0 1 0.1 0.2\n0 2 0.1 x\n", 2, "four numbers"),
        ("0 1 0.1 0.2\n0 2 0.1 nan\n", 2, "four numbers"),
        ("0 1 0.1 inf\n0 2 0.1 0.2\n", 1, "four numbers"),
        ("0 1 0.1 0.2\n0 2 0.1 0.2\n1 1 0.1 0.2\n", 3, "full grid"),
        ("0 2 0.1 0.2\n0 1 0.1 0.2\n", 1, "zenith distance 1"),
    ],
)
def test_broken_table_is_told_by_line(tmp_path, text, line, said):
    """A table that is no full grid of numbers is refused, with file and line."""
    path = tmp_path / "table.txt"
    path.write_text(text)
    with pytest.raises(BadInput, match=said) as raised:
        read_ascii(path)

    assert str(raised.value).startswith(f"{path}:{line}: ")


def test_binary_file_is_no_table(tmp_path):
    """Bytes that are no text are refused in one line."""
    path = tmp_path / "table.bin"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(BadInput, match="is no text"):
        read_ascii(path)


def test_steps_that_differ_are_refused(tmp_path):
    """A look-up counts on equal ones: at a node it would give another node's number."""
    path = tmp_path / "table.txt"
    path.write_text("".join(f"{az} {zd} 0.1 0.2\n" for az in (0, 1, 10) for zd in (0, 5)))

    with pytest.raises(BadInput, match="azimuths do not ascend by equal steps"):
        read_ascii(path)
