"""Data sets: every row goes into a normal point or is counted, whatever the pieces and workers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyarrow import parquet

from pyport.angles import ARCSEC, DEG
from pyport.effects import CATALOGUE
from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.raw import FileOptions
from pyport.recordings.stream import cells, pieces, points, reduce
from pyport.recordings.stream.cells import LEVELS, grown, key_of
from pyport.recordings.stream.chunk import Chunk

META = {"latitude_deg": "53.1", "longitude_deg": "18.6", "height_m": "100"}


def campaign(seed=0, rows=4000, days=4):
    """Return columns of a campaign of tracks, with noise of 10 arcsec and a few outliers."""
    rng = np.random.default_rng(seed)
    tracks = -(-rows // 100)
    az = (rng.uniform(0, 360, tracks)[:, None] + np.linspace(0, 2, 100)).ravel()[:rows]
    el = (rng.uniform(10, 80, tracks)[:, None] + np.linspace(0, 2, 100)).ravel()[:rows]
    x, y = rng.normal(0, 10, (2, rows))
    y += 12 / np.tan(el * DEG)
    time = 1.76e9 + np.linspace(0, days * 86400, rows)
    return {
        "az_deg": az,
        "el_deg": el,
        "d_xel_arcsec": x,
        "d_el_arcsec": y,
        "time_utc": (time * 1e6).astype("datetime64[us]"),
        "antenna": np.where(rng.random(rows) < 0.5, "W01", "W02"),
        "temperature_c": rng.normal(5, 1, rows),
    }


def write(root, columns, files=4, meta=META, groups=None):
    """Write columns as a data set of some files, in folders by their number."""
    rows = len(columns["az_deg"])
    for n, part in enumerate(np.array_split(np.arange(rows), files)):
        path = root / f"night={n:02d}" / "part.parquet"
        path.parent.mkdir(parents=True)
        table = pyarrow.table({name: values[part] for name, values in columns.items()})
        parquet.write_table(table.replace_schema_metadata(meta), path, row_group_size=groups)
    return root


@given(
    st.floats(-700, 700),
    st.floats(-9, 99),
    st.floats(0, 4e9),
    st.sampled_from([-1, 0, 1]),
    st.integers(0, len(LEVELS) - 1),
)
def test_larger_cells_hold_smaller_ones_whole(az, el, time, direction, level):
    """A cell of any level lies in the one that its rows have at that level."""
    one = [np.array([value]) for value in (az * DEG, el * DEG, 0.0, 0.0, time, float(direction))]
    row = Chunk(*one, {}, np.zeros(1, np.int64), [()], ())

    assert grown(key_of(row, 0), 0, level) == key_of(row, level)


def test_every_row_counts(tmp_path):
    """Rows are those in points and the excluded ones, each of these with file, row and reason."""
    columns = campaign()
    columns["d_el_arcsec"][7] = columns["d_xel_arcsec"][7] = np.nan
    columns["az_deg"][2500] = np.nan

    found = read(write(tmp_path, columns))

    assert found.reduction.rows == 4000
    assert found.reduction.set_aside == {
        "no offset on either axis": 1,
        "no azimuth or no elevation": 1,
    }
    assert [(one.line, one.reason.partition("night=")[2]) for one in found.set_aside] == [
        (8, "00/part.parquet: no offset on either axis"),
        (501, "02/part.parquet: no azimuth or no elevation"),
    ]
    assert len(found) == found.reduction.points


def test_points_are_the_means_of_their_rows(tmp_path, monkeypatch):
    """In one cell for each antenna they are the plain means, where there are no outliers."""
    columns = campaign()
    columns["d_el_arcsec"] = np.clip(columns["d_el_arcsec"], 0, 30)
    monkeypatch.setattr(cells, "LEVELS", (*LEVELS, (9, 62)))
    monkeypatch.setattr(reduce, "LEVELS", (*LEVELS, (9, 62)))
    monkeypatch.setattr(reduce, "MOST_NUMBERS", 4)
    monkeypatch.setattr(points, "REACH", 1e6)

    found = read(write(tmp_path, columns))

    for antenna in ("W01", "W02"):
        rows = columns["antenna"] == antenna
        mine = found.at.column("antenna") == antenna
        weight = rows.sum()
        assert found.y[mine] @ [1.0] == pytest.approx(
            columns["d_el_arcsec"][rows].mean() * ARCSEC, rel=1e-9
        )
        assert found.at.numbers("temperature_c")[mine] == pytest.approx(
            columns["temperature_c"][rows].mean(), rel=1e-9
        )
        expected = columns["d_xel_arcsec"][rows].std(ddof=1) * ARCSEC / np.sqrt(weight)
        assert found.sigma_x[mine] == pytest.approx(expected, rel=1e-6)


def test_outliers_have_no_vote(tmp_path):
    """A reading half a degree off moves no point, and is counted."""
    columns = campaign()
    before = read(write(tmp_path / "before", columns))
    columns["d_xel_arcsec"][1234] += 1800.0
    after = read(write(tmp_path / "after", columns))

    assert after.reduction.outliers == before.reduction.outliers + 1
    assert np.abs(after.x - before.x).max() < 5 * ARCSEC


def test_effects_are_averaged_over_what_was_observed(tmp_path, monkeypatch):
    """Refraction of a point is the mean of its places', not that of its mean place."""
    monkeypatch.setattr(reduce, "MOST_NUMBERS", 100)
    columns = campaign(rows=8000)
    found = read(write(tmp_path, columns))
    refraction = CATALOGUE["refraction"]

    assert found.reduction.points < 100 < found.reduction.places
    _, mean = refraction.columns(found.at)
    _, finest = refraction.columns(found.at.fine.at)
    share = found.at.fine.share[:, None]
    for point in (0, len(found) // 2, len(found) - 1):
        mine = found.at.fine.pointing == point
        np.testing.assert_allclose(mean[point], (finest * share)[mine].sum(axis=0), rtol=1e-12)


@pytest.mark.parametrize("size", [97, 1000, 1 << 18])
def test_pieces_and_chunks_change_nothing_but_rounding(tmp_path, monkeypatch, size):
    """However the rows are cut, the points are the same but for outliers' borderline votes."""
    root = write(tmp_path, campaign(), groups=250)
    monkeypatch.setattr(points, "PARTS", 1)  # rows are dealt to the parts chunk by chunk
    whole = read(root)
    monkeypatch.setattr(pieces, "CHUNK_ROWS", size)
    monkeypatch.setattr(pieces, "PIECE_ROWS", 3 * size)
    cut = read(root)

    np.testing.assert_allclose(cut.y, whole.y, rtol=0, atol=1e-9 * ARCSEC)
    np.testing.assert_array_equal(cut.at.columns["antenna"], whole.at.columns["antenna"])


def test_memory_is_bounded_by_growing_cells(tmp_path, monkeypatch):
    """More cells than there is room for become fewer and larger ones, and no row is lost."""
    monkeypatch.setattr(reduce, "MOST_CELLS", 300)
    found = read(write(tmp_path, campaign()))

    assert found.reduction.places <= 300
    assert found.reduction.rows == 4000


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda c: {k: v for k, v in c.items() if k != "az_deg"}, "no columns az_deg and el_deg"),
        (lambda c: c | {"d_el_deg": c["d_el_arcsec"]}, "say the same"),
        (lambda c: c | {"el_deg": c["el_deg"] + 90}, "elevation above"),
        (lambda c: c | {"temperature_c": c["temperature_c"] / 0}, "temperature_c is infinite"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_row(tmp_path, spoil, message):
    """One sentence with the file, whatever the column."""
    with np.errstate(divide="ignore"):
        columns = spoil(campaign())
    columns.setdefault("az_deg", np.zeros(0))
    root = tmp_path / "set"
    path = root / "one.parquet"
    root.mkdir()
    table = {name: values for name, values in columns.items() if len(values)}
    parquet.write_table(pyarrow.table(table), path)

    with pytest.raises(BadInput, match=message) as told:
        read(root)

    assert str(path) in str(told.value)


def test_files_must_agree(tmp_path):
    """A header key that differs, a column that one file lacks, a folder without files."""
    root = write(tmp_path / "keys", campaign(), files=1)
    write(root / "other", campaign(), files=1, meta=META | {"latitude_deg": "10"})
    with pytest.raises(BadInput, match=r"latitude_deg is '10', in files before it '53\.1'"):
        read(root)

    root = write(tmp_path / "columns", campaign(), files=1)
    fewer = {name: v for name, v in campaign().items() if name != "temperature_c"}
    write(root / "other", fewer, files=1)
    with pytest.raises(BadInput, match="some files of the data set have no column temperature_c"):
        read(root)

    (tmp_path / "nothing").mkdir()
    with pytest.raises(BadInput, match="a folder without Parquet files"):
        read(tmp_path / "nothing")


def test_what_the_rows_say_against_themselves(tmp_path):
    """As of a single file, once of all files; means of the rows would not say it."""
    assert read(write(tmp_path / "sound", campaign())).notes == ()

    columns = campaign()
    for name in ("d_xel_arcsec", "d_el_arcsec"):
        columns[name][::20] = -99.99
    columns["temperature_c"][::10] = -999.0
    found = read(write(tmp_path / "not", columns, meta=META | {"azimut zero": "south"}))

    assert found.notes == (
        "header key 'azimut_zero' is not known and not used: 'azimuth_zero' may be meant",
        (
            "d_xel_arcsec -99.99 and d_el_arcsec -99.99 stand together in 200 of 4000 rows, "
            "which may mean that nothing was measured there"
        ),
        "taken for blank, of 4000 rows looked at: temperature_c outside (-90.0, 60.0) in 400 rows",
    )
    assert np.nanmin(found.at.numbers("temperature_c")) > 0


def test_names_and_keys_that_would_be_left_out(tmp_path):
    """Refused as those of a single file."""
    columns = campaign()
    columns["mjd"] = np.arange(len(columns["az_deg"]), dtype=float)
    del columns["time_utc"]
    with pytest.raises(BadInput, match=r"night=00.*column 'mjd' is not known, did you mean time"):
        read(write(tmp_path / "time", columns))
    root = write(tmp_path / "sound", campaign())
    for key in ("azimuth_from", "azimut_zero"):
        with pytest.raises(BadInput, match=f"--set '{key}' is no key, did you mean 'azimuth_zero'"):
            read(root, FileOptions({key: "south"}))


def test_folders_name_labels(tmp_path):
    """`antenna=W07` is the antenna of all rows below it; numbers of nights are no label."""
    columns = {name: v for name, v in campaign().items() if name != "antenna"}
    write(tmp_path / "antenna=W07", columns)
    write(tmp_path / "antenna=W08", columns)

    found = read(tmp_path)

    assert set(found.at.column("antenna")) == {"W07", "W08"}
    assert "night" not in found.at
    assert Path(found.file) == tmp_path


def points_of(recordings):
    """Return everything that was computed, normal points in an order of their own."""
    at = recordings.at
    order = np.lexsort((np.rint(at.numbers("time")), at.column("antenna")))
    numbers = (at.az, at.el, at.numbers("time"), recordings.x, recordings.y, recordings.sigma_y)
    return np.stack([one[order] for one in numbers]), recordings.reduction


@pytest.mark.parametrize("how", ["chunks", "pieces", "files", "order"])
def test_how_rows_come_changes_nothing_but_rounding(tmp_path, monkeypatch, how):
    """The size of chunks and pieces, the number of files, the order of rows."""
    columns = campaign(rows=3000)
    columns["d_el_arcsec"][::37] += 300
    alone, told = points_of(read(write(tmp_path / "alone", columns)))
    files, groups = 4, None
    if how == "chunks":
        monkeypatch.setattr(pieces, "CHUNK_ROWS", 97)
    elif how == "pieces":
        monkeypatch.setattr(pieces, "PIECE_ROWS", 200)
        groups = 100
    elif how == "files":
        files = 11
    else:
        order = np.random.default_rng(3).permutation(3000)
        columns = {name: values[order] for name, values in columns.items()}
    again, also = points_of(read(write(tmp_path / "again", columns, files=files, groups=groups)))

    assert also == told
    assert told.outliers > 50
    np.testing.assert_allclose(again, alone, rtol=1e-9, atol=1e-12)
