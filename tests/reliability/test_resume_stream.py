"""A data set of many files, killed in either pass over it and called again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from pyport.recordings.stream import pass_files
from pyport.runs.checkpoint import Checkpoint

FILES = 40
#: Reads a data set, a fiftieth of a second for each piece, and writes down which it read.
RUN = """
import sys, time
from pathlib import Path
import numpy as np
from pyport.runs import checkpoint
from pyport.recordings import read
checkpoint.LEAST_S = 0.1
root, out, log = map(Path, sys.argv[1:4])

def slowly(call, items):
    for item in items:
        time.sleep(0.02)
        yield call(item)
        with log.open("a") as file:
            file.write(item.file.name + "\\n")

found = read(root, spread=slowly, beside=out)
at = found.at
places = [at.fine.at.az, at.fine.share]
np.savez(out / "answer.npz", *places, at.az, at.el, at.numbers("time"), found.x, found.y,
         found.sigma_y, repr(found.reduction), repr(found.set_aside))
"""


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """Return a data set of forty nights."""
    place = tmp_path_factory.mktemp("data") / "campaign"
    place.mkdir()
    rng = np.random.default_rng(3)
    for n in range(FILES):
        rows = 20
        el = rng.uniform(10, 80, rows)
        columns = {
            "az_deg": rng.uniform(0, 360, rows),
            "el_deg": el,
            "d_xel_arcsec": rng.normal(0, 10, rows),
            "d_el_arcsec": rng.standard_t(2, rows) * 10 + 20 / np.tan(np.radians(el)),
            "night": np.where(rng.random(rows) < 0.1, np.nan, n),
            "time_utc": ((1.76e9 + 86400 * n + 60 * np.arange(rows)) * 1e6).astype(
                "datetime64[us]"
            ),
        }
        parquet.write_table(pyarrow.table(columns), place / f"night-{n:02d}.parquet")
    return place


def start(root, out, log):
    """Start to read a data set."""
    return subprocess.Popen(
        [sys.executable, "-c", RUN, str(root), str(out), str(log)],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )


def lines(log):
    """Return the pieces that were gone through so far, of both passes."""
    return log.read_text().splitlines() if log.exists() else []


def test_killed_in_either_pass_it_goes_on_and_says_the_same(root, tmp_path):
    """Killed in the first pass and in the second: what was gone through need not be again."""
    log, quiet_log = tmp_path / "log", tmp_path / "quiet-log"
    loud, quiet = tmp_path / "loud", tmp_path / "quiet"
    for pieces in (FILES // 2, FILES + FILES // 2):
        process = start(root, loud, log)
        while process.poll() is None and len(set_of_both(log)) < pieces:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert all(file.exists() for file in pass_files(loud))
    before = len(lines(log))
    assert start(root, loud, log).wait() == 0
    assert start(root, quiet, quiet_log).wait() == 0

    assert len(lines(quiet_log)) == 2 * FILES
    assert len(lines(log)) - before < FILES
    with np.load(loud / "answer.npz") as one, np.load(quiet / "answer.npz") as other:
        assert one.files == other.files
        for name in one.files:
            assert one[name].tobytes() == other[name].tobytes()


def set_of_both(log):
    """Return the pieces gone through, each once in each pass; a repeated one counts once."""
    seen, passes = set(), 0
    for name in lines(log):
        if name == "night-00.parquet" and (0, "night-39.parquet") in seen:
            passes = 1
        seen.add((passes, name))
    return seen


def test_what_was_kept_belongs_to_its_input(tmp_path):
    """Another key, a torn file or none: as if nothing had been kept."""
    path = tmp_path / "kept.npz"
    numbers = np.array([0.1, np.nan, 1e-300])
    Checkpoint(path, "one", 1).save(lambda: ({"done": 3}, {"numbers": numbers}))

    told, arrays = Checkpoint(path, "one", 1).load()
    assert told == {"done": 3}
    assert arrays["numbers"].tobytes() == numbers.tobytes()
    assert Checkpoint(path, "one", 2).load() is None
    assert Checkpoint(tmp_path / "none.npz", "one", 1).load() is None
    whole = path.read_bytes()
    for torn in (whole[: len(whole) // 2], b"", whole[:200] + b"x" + whole[201:]):
        path.write_bytes(torn)
        assert Checkpoint(path, "one", 1).load() is None


def test_a_place_that_cannot_be_written_stops_no_run(tmp_path):
    """What is kept is a help; without it the run goes on."""
    (tmp_path / "file").write_text("")
    kept = Checkpoint(tmp_path / "file" / "kept.npz", "one")
    kept.save(lambda: ({}, {}))

    assert kept.load() is None
