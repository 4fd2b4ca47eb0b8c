"""A diagnosis's folder: every file of one run, or it can be seen."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from click.testing import CliRunner

from pyport.cli.dev.recorded import verify as command
from pyport.errors import BadInput
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import write_recordings
from pyport.pointing import kernel
from pyport.recordings.stream import pass_files
from pyport.report.folder import check, finish

OLD = "finding-7-refraction.png"


@pytest.fixture(scope="module")
def nights(tmp_path_factory):
    """Return two recordings of one name, one to be told of before the other."""
    found = []
    for number, effect in enumerate(("refraction", "sag_sine")):
        path = tmp_path_factory.mktemp("night") / "night.csv"
        write_recordings(Spec("one", "one", effect, 2.0, 100).make(number), path)
        found.append(path)
    return found


def diagnose(path, out):
    """Start a diagnosis."""
    return subprocess.Popen(
        [sys.executable, "-m", "pyport", "diagnose", str(path), "--out", str(out), "--quiet"],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )


def test_killed_between_two_files_it_is_seen_and_another_run_mends_it(nights, tmp_path):
    """The old report does not vouch for the new files; run again, one run's files stand alone."""
    folder = tmp_path / "night"
    assert diagnose(nights[0], tmp_path).wait() == 0
    assert check(folder) == len(list(folder.iterdir())) - 1
    report = (folder / "report.json").read_bytes()
    before = (folder / "report.html").read_bytes()
    process = diagnose(nights[1], tmp_path)
    while process.poll() is None and (folder / "report.html").read_bytes() == before:
        time.sleep(0.0005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    (folder / OLD).write_bytes(b"what a run of long ago left")
    for kept in pass_files(folder):
        kept.write_bytes(b"half")

    assert (folder / "report.json").read_bytes() == report
    with pytest.raises(BadInput, match="is not the one that report"):
        check(folder)
    assert diagnose(nights[1], tmp_path).wait() == 0
    # a hidden file is one that was being written when the other was killed
    assert check(folder) == len([one for one in folder.iterdir() if one.name[0] != "."]) - 1
    assert not (folder / OLD).exists()


def test_whatever_was_changed_since_is_named(tmp_path):
    """A changed file, a missing one, one too many, no report, one that names none."""
    page, rows = tmp_path / "report.html", tmp_path / "rows.csv"
    for one in (page, rows):
        one.write_text(one.name)
    report = finish(tmp_path, {"mismatch": False}, [page, rows])
    told = CliRunner().invoke(command, [str(tmp_path), "--json"], catch_exceptions=False)

    assert json.loads(told.output) == {str(tmp_path): 2}
    assert set(report["files"]) == {"report.html", "rows.csv"}
    assert report["computed_with"] == kernel.path()
    (tmp_path / OLD).write_text("")
    with pytest.raises(BadInput, match=f"{OLD}:1: this file is of another run"):
        check(tmp_path)
    (tmp_path / OLD).unlink()
    rows.write_text("another")
    with pytest.raises(BadInput, match=r"rows.csv:1: this file is not the one"):
        check(tmp_path)
    rows.unlink()
    with pytest.raises(BadInput, match="missing"):
        check(tmp_path)
    for text in ("{}", "[", '{"files": {"../secret": "00"}}', '{"files": []}'):
        (tmp_path / "report.json").write_text(text)
        with pytest.raises(BadInput, match="no report that names"):
            check(tmp_path)
