"""Outputs where they cannot be written, and beside others."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from pyport.examiner.sealed import seal
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.published import read_answers, read_seal
from pyport.files import ABANDONED_S, tree, write_file, write_whole

TABLE = (sys.executable, "-m", "pyport", "table", "--az", "0:100:1", "-o")


def in_a_small_place(script, place):
    """Run a shell script with a tmpfs of 64 kB mounted at a place, or skip where none may be."""
    unshare = shutil.which("unshare")
    if unshare is None:
        pytest.skip("no unshare, which lets a test mount a small disk")
    place.mkdir()
    mount = f"mount -t tmpfs -o size=64k none {place}"
    if subprocess.run([unshare, "-rm", "sh", "-c", mount], capture_output=True, check=False).stderr:
        pytest.skip("this machine lets nobody mount a small disk")
    return subprocess.run(
        [unshare, "-rm", "sh", "-c", f"{mount} && {script}"],
        capture_output=True,
        text=True,
        check=False,
        cwd=place.parent,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )


def test_a_full_disk_is_one_line_and_leaves_the_old_file(tmp_path):
    """A table of a megabyte finds 64 kB; what stood there stands there still, and alone."""
    place = tmp_path / "small"
    command = " ".join([*TABLE, str(place / "table.txt")])
    done = in_a_small_place(
        f"echo old > {place}/table.txt; {command}; echo $?; ls -A {place}; cat {place}/table.txt",
        place,
    )

    assert done.stdout.split() == ["2", "table.txt", "old"]
    assert done.stderr == (
        f"pyport: error: {place}/table.txt: cannot be written: No space left on device\n"
    )


def test_a_folder_that_is_read_only_is_one_line(tmp_path):
    """The file is named that the user asked for, not a temporary one."""
    place = tmp_path / "small"
    command = " ".join([*TABLE, str(place / "table.txt")])
    done = in_a_small_place(f"mount -o remount,ro {place}; {command}; echo $?", place)

    assert done.stdout.split() == ["2"]
    assert done.stderr == (
        f"pyport: error: {place}/table.txt: cannot be written: Read-only file system\n"
    )


def test_a_file_that_may_not_grow_is_one_line(tmp_path):
    """A quota is as clear as a full disk."""
    path = tmp_path / "table.txt"
    limited = "import resource, runpy; resource.setrlimit(resource.RLIMIT_FSIZE, (9999, 9999));"
    run = f"{limited} runpy.run_module('pyport', run_name='__main__')"
    done = subprocess.run(
        [sys.executable, "-B", "-c", run, *TABLE[3:], str(path)],
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 2
    assert done.stderr == f"pyport: error: {path}: cannot be written: File too large\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
def test_a_full_disk_behind_standard_output_is_status_2(tmp_path):
    """The interpreter wrote it once more at the end, and made it 120."""
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*TABLE, str(tmp_path / "table"), "--json"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )

    assert done.returncode == 2
    assert done.stderr == "pyport: error: No space left on device\n"


def test_two_runs_at_once_do_not_mix(tmp_path):
    """Whoever is last wins, whole: a reader never sees a line of each."""
    path = tmp_path / "file"
    contents = ["a" * 200_000, "b" * 200_000]

    def write_often(content):
        for _ in range(20):
            with write_whole(path) as file:
                for start in range(0, len(content), 20_000):
                    file.write(content[start : start + 20_000])

    writers = [threading.Thread(target=write_often, args=[one]) for one in contents]
    for one in writers:
        one.start()
    seen = set()
    while any(one.is_alive() for one in writers):
        if path.exists():
            seen.add(path.read_text())

    assert seen <= set(contents)
    assert path.read_text() in contents
    assert [one.name for one in tmp_path.iterdir()] == ["file"]


def test_what_a_killed_run_left_is_removed_an_hour_later(tmp_path):
    """Temporary files of this name that are old go; young ones may be another run's."""
    old, young, other = (tmp_path / name for name in (".f.abcdefgh", ".f.ijklmnop", ".g.abcdefgh"))
    for one in (old, young, other):
        one.write_text("half")
    for one in (old, other):
        os.utime(one, (time.time() - 2 * ABANDONED_S,) * 2)
    with write_whole(tmp_path / "f") as file:
        file.write("whole")

    assert sorted(one.name for one in tmp_path.iterdir()) == [young.name, other.name, "f"]


def test_what_a_link_names_is_replaced(tmp_path):
    """A model in use that is a link stayed old: the link became a file of its own."""
    (tmp_path / "models").mkdir()
    there, link = tmp_path / "models" / "night.mod", tmp_path / "current.mod"
    there.write_text("old")
    there.chmod(0o640)
    link.symlink_to(there)
    write_file(link, "new")

    assert link.is_symlink()
    assert there.read_text() == "new"
    assert stat.S_IMODE(there.stat().st_mode) == 0o640


def test_a_pipe_stays_one(tmp_path):
    """Whoever waits at its end gets what is written; it became a file."""
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_text()), daemon=True)
    reader.start()
    write_file(pipe, "some rows")
    reader.join(10)

    assert got == ["some rows"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_seal_that_points_elsewhere_is_refused(tmp_path):
    """Names in a published file never lead out of the set's folder."""
    seal.seal(tmp_path / "set", "set", [Spec("null", "null", rows=20, noise="white")])
    path = tmp_path / "set" / "sealed.json"
    path.write_text(path.read_text().replace("case-0001", "../../case-0001"))
    answers = tmp_path / "answers.json"
    answers.write_text('{"reports_sha256": {"/etc/passwd": "00"}}')

    for read, file in ((read_seal, path), (read_answers, answers)):
        with pytest.raises(ValueError, match="expected letters and digits"):
            read(file)


def test_a_folder_that_is_a_link_counts_as_what_is_in_it(tmp_path):
    """A checkout, with folders elsewhere, and what is installed from it have one hash."""
    stored, linked, copied = (tmp_path / name for name in ("stored", "linked", "copied"))
    stored.mkdir()
    (stored / "answers.json").write_text("[1]")
    for one in (linked, copied):
        one.mkdir()
        (one / "code.py").write_text("pass")
    (linked / "oracle").symlink_to(stored, target_is_directory=True)
    shutil.copytree(stored, copied / "oracle")

    assert tree(linked) == tree(copied)
    (copied / "oracle" / "answers.json").write_text("[2]")
    assert tree(linked) != tree(copied)
