"""A log that grows is read once, whole, whatever is done to it."""

import os
from dataclasses import asdict

import numpy as np
import pytest
from drawn_nights import text, world

from pyport.recordings import read, write
from pyport.recordings.raw import NOTHING, FileOptions
from pyport.watch import follow
from pyport.watch.follow import Cursor


@pytest.fixture(scope="module")
def lines():
    """Return the header's lines and 40 rows."""
    drawn = world()
    above, rows = text(drawn.watched, drawn.header)
    return above, rows[:40]


class Log:
    """A log and how far it was read."""

    def __init__(self, path, given=NOTHING):
        self.path, self.given, self.cursor = path, given, Cursor()
        self.times, self.skipped, self.lines = [], [], []

    def read(self):
        """Read on; return how many recordings came."""
        before = len(self.times)
        for batch in follow.new(self.path, self.given, self.cursor):
            self.cursor = Cursor(**asdict(batch.cursor))
            self.skipped += batch.skipped
            if batch.recordings is not None:
                self.times += batch.recordings.at.column("time").tolist()
                self.lines += batch.recordings.line.tolist()
        return len(self.times) - before


def append(path, some):
    """Write lines at the end of a file."""
    with path.open("a") as file:
        file.writelines(some)


def test_rows_come_as_the_log_grows_and_half_lines_wait(tmp_path, lines):
    """Half a header, half a row, several rows: each row is read once, when it is whole."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    whole = "".join(above + rows)
    rng = np.random.default_rng(3)
    cuts = sorted(rng.choice(len(whole), 60, replace=False))
    for first, last in zip([0, *cuts], [*cuts, len(whole)], strict=True):
        append(log.path, [whole[first:last]])
        log.read()

    reference = tmp_path / "whole.csv"
    reference.write_text(whole)
    assert log.times == read(reference).at.column("time").tolist()
    assert log.lines == [len(above) + n for n in range(1, 41)]


def test_a_log_that_is_rotated_goes_on_in_the_new_one(tmp_path, lines):
    """What was written before it was renamed is read under its new name."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    append(log.path, above + rows[:10])
    assert log.read() == 10
    append(log.path, rows[10:15])
    log.path.rename(tmp_path / "log.csv.1")
    append(log.path, above + rows[15:20])
    assert log.read() == 10
    assert len(set(log.times)) == 20


@pytest.mark.parametrize("backup", [False, True])
def test_a_longer_copy_in_the_place_of_a_log_is_not_read_again(tmp_path, lines, backup):
    """As rsync leaves it, the file before kept under another name or not."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    append(log.path, above + rows[:10])
    log.read()
    for last in (15, 16, 40):
        if backup:
            log.path.rename(tmp_path / "log.csv~")
        copy = tmp_path / ".log.csv.part"
        copy.write_text("".join(above + rows[:last]))
        copy.rename(log.path)
        log.read()
    assert log.lines == [len(above) + n for n in range(1, 41)]


@pytest.mark.parametrize("at_once", [True, False])
def test_a_line_of_names_among_the_rows_names_those_below_it(tmp_path, lines, at_once):
    """Whoever writes the log was started anew, perhaps with its columns in another order."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    turned = [",".join(reversed(one.strip().split(","))) + "\n" for one in [above[-1], *rows[20:]]]
    parts = above + rows[:10], [above[-1], *rows[10:20]], turned
    for part in [[*parts[0], *parts[1], *parts[2]]] if at_once else parts:
        append(log.path, part)
        log.read()
    reference = tmp_path / "whole.csv"
    reference.write_text("".join(above + rows))

    assert log.times == read(reference).at.column("time").tolist()
    assert log.skipped == []
    assert log.lines[10] == len(above) + 12
    assert log.lines[-1] == len(above) + 42


def test_a_log_that_is_truncated_begins_anew(tmp_path, lines):
    """Shorter or as long as before, another beginning is another log."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    append(log.path, above + rows[:10])
    log.read()
    log.path.write_text("".join(above + rows[10:13]))
    assert log.read() == 3
    log.path.write_text("".join(above + rows[20:34]))
    assert log.read() == 14
    assert len(set(log.times)) == 27


def test_rows_that_cannot_be_used_are_reported_with_their_lines(tmp_path, lines):
    """A row of rubbish costs itself alone."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    append(
        log.path, [*above, *rows[:3], "rubbish\n", *rows[3:6], rows[6].replace(",", ";"), rows[7]]
    )
    assert log.read() == 7
    assert [one.line for one in log.skipped] == [len(above) + 4, len(above) + 8]


def test_a_folder_is_read_file_by_file(tmp_path, lines):
    """The next night is the next file, with a header of its own."""
    above, rows = lines
    log = Log(tmp_path)
    append(tmp_path / "night-1.csv", above + rows[:10])
    assert log.read() == 10
    append(tmp_path / "night-1.csv", rows[10:12])
    append(tmp_path / "night-2.csv", above + rows[12:20])
    assert log.read() == 10
    assert log.read() == 0


def test_other_formats_are_read_again_when_they_change(tmp_path, lines):
    """Parquet grows by being written anew."""
    above, rows = lines
    table = tmp_path / "log.csv"
    log = Log(tmp_path / "log.parquet")
    for count in (10, 17):
        table.write_text("".join(above + rows[:count]))
        write(read(table), log.path)
        log.read()
        assert len(log.times) == count


def test_columns_by_other_names(tmp_path, lines):
    """A map of columns holds for a log as for a file."""
    above, rows = lines
    renamed = [one.replace("az_deg,el_deg", "A,E") for one in above]
    same = ("time_utc", "d_xel_arcsec", "d_el_arcsec")
    told = {"az_deg": "A", "el_deg": "E"} | {one: one for one in same}
    log = Log(tmp_path / "log.txt", FileOptions(mapping=told))
    append(log.path, renamed + rows[:5])

    assert log.read() == 5


def test_a_blank_line_above_the_names_is_passed_over(tmp_path, lines):
    """Line by line as together."""
    above, rows = lines
    log = Log(tmp_path / "log.csv")
    for one in (*above[:-1], "\n", above[-1], *rows[:5]):
        append(log.path, [one])
        log.read()

    assert len(log.times) == 5
    assert log.skipped == []


def test_the_last_line_of_a_file_that_ended_is_read(tmp_path, lines):
    """Without a newline: of a night of a folder, and of a log that was rotated."""
    above, rows = lines
    log = Log(tmp_path / "folder")
    log.path.mkdir()
    append(log.path / "night-1.csv", [*above, *rows[:9], rows[9].rstrip("\n")])
    assert log.read() == 9
    append(log.path / "night-2.csv", above + rows[10:12])
    assert log.read() == 3
    one = Log(tmp_path / "log.csv")
    append(one.path, [*above, *rows[:9], rows[9].rstrip("\n")])
    assert one.read() == 9
    one.path.rename(tmp_path / "log.csv.1")
    append(one.path, above + rows[10:12])
    assert one.read() == 3


def test_a_file_that_was_touched_is_read_once(tmp_path, lines, monkeypatch):
    """One that is read as a whole."""
    above, rows = lines
    (tmp_path / "log.csv").write_text("".join(above + rows[:10]))
    log = Log(tmp_path / "log.parquet")
    write(read(tmp_path / "log.csv"), log.path)
    log.read()
    times = []
    whole = follow.read_raw
    monkeypatch.setattr(follow, "read_raw", lambda *some: times.append(1) or whole(*some))
    os.utime(log.path, (1e9, 1e9))
    assert [log.read() for _ in range(3)] == [0, 0, 0]
    assert len(times) == 1
