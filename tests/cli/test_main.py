"""The command line: light to start, one clear line for bad input, the contract's exit codes."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner
from diagnosis.made import recordings

from pyport import __version__
from pyport.cli import main
from pyport.cli import pyport as command_line
from pyport.pointing import kernel
from pyport.recordings import write

HEAVY = ("numpy", "scipy", "astropy", "matplotlib", "dask", "pyarrow", "rich")


def pyport(*words, **options):
    """Run the command as a user would."""
    command = [sys.executable, "-m", "pyport", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@pytest.fixture
def called(monkeypatch, capsys):
    """Return what calls the command in this process: its exit status and standard error."""

    def call(*words):
        monkeypatch.setattr(sys, "argv", ["pyport", *map(str, words)])
        with pytest.raises(SystemExit) as left:
            main()
        return left.value.code, capsys.readouterr().err

    return call


@pytest.mark.parametrize("path", ["numpy", "kernel, AVX2"])
def test_the_version_says_what_computes(monkeypatch, path):
    """Numpy, or the compiled kernel with its instruction set."""
    monkeypatch.setattr(kernel, "path", lambda: path)
    told = CliRunner().invoke(command_line, ["--version"], catch_exceptions=False)

    assert told.output == f"pyport, version {__version__}, computing with {path}\n"


@pytest.mark.parametrize("words", ["import pyport", "import pyport.cli"])
def test_importing_is_light(words):
    """Neither the package nor its command line imports a heavy library."""
    code = f"{words}; import sys; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "[]"


def test_help_lists_every_command_and_imports_nothing_heavy():
    """`pyport --help` shows the commands; `-X importtime` shows that none was loaded."""
    command = [sys.executable, "-X", "importtime", "-m", "pyport", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)

    for name in ("demo", "diagnose", "fit", "parity", "table"):
        assert name in done.stdout
    assert not any(f" {name}\n" in done.stderr for name in HEAVY)


GOOD = "az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n10,20,1,2\n"


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"azimut,el_deg,d_el_arcsec\n1,2,3\n", 1),
        (GOOD.encode() + b"30,x,1,2\n", 3),
        (GOOD.encode() + b"1e9,40,1,2\n", 3),
        (b"", 1),
        (bytes(range(256)) * 4, 1),
    ],
    ids=["bad header", "non-number", "azimuth of 1e9", "empty", "binary"],
)
def test_a_bad_file_is_one_line_that_names_file_and_line(called, tmp_path, content, line):
    """Exit status 2, one line on standard error, no traceback, nothing written."""
    path = tmp_path / "bad.csv"
    path.write_bytes(content)

    status, said = called("diagnose", path, "--out", tmp_path / "out")

    assert status == 2
    assert said.count("\n") == 1
    assert said.startswith(f"pyport: error: {path}:{line}: ")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("diagnose", "nowhere.csv", "--out", "out"),
        ("diagnose", "gmrt-2003-06-01", "--model", "nonsense", "--out", "out"),
        ("diagnose", "gmrt-2003-06-01", "--refit", "nonsense", "--out", "out"),
        ("fit", "gmrt-2003-06-01", "--model", "nonsense"),
        ("diagnose", "gmrt-2003-06-01", "--quiet"),
        ("diagnose", "gmrt-2003-06-01", "--out", "out", "--jobs", "0"),
        ("diagnose", "gmrt-2003-06-01", "--out", "out", "--seed", "-1"),
        ("dev", "nulls", "--jobs", "-3"),
        ("nonsense",),
        ("table",),
        ("table", "--check", "--model", "altaz"),
        ("table", "--model", "nothing", "-o", "x"),
        ("table", "--refraction", "nothing", "-o", "x"),
        ("table", "--picture", "x.png", "--check"),
        ("table", "--az", "0:1", "-o", "x"),
        ("lookup", "nowhere.bin", "--az", "1", "--zd", "2"),
        ("lookup", __file__, "--az", "1", "--zd", "2"),
        ("lookup", __file__, "--az", "1"),
    ],
)
def test_bad_arguments_are_one_line(called, tmp_path, monkeypatch, words):
    """Whatever is wrong with the call is said in one line, with status 2; nothing is written."""
    monkeypatch.chdir(tmp_path)
    status, said = called(*words)

    assert status == 2
    assert said.count("\n") == 1
    assert said.startswith("pyport: error: ")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.skipif(sys.platform == "win32", reason="limits of size are POSIX's")
def test_what_the_disk_does_not_take_is_said(tmp_path, unbuffered):
    """Standard output in a file that may not grow: status 2, never a part of it with 0."""
    import resource

    with (tmp_path / "effects.json").open("w") as file:
        done = subprocess.run(
            [sys.executable, "-m", "pyport", "dev", "effects", "--json"],
            stdout=file,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            # A module that is compiled under the limit would be written half, for all who follow.
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered, "PYTHONDONTWRITEBYTECODE": "1"},
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192)),
        )

    assert (done.returncode, done.stderr) == (2, "pyport: error: File too large\n")


def test_a_process_of_its_own_ends_with_the_status(tmp_path):
    """As a shell sees it."""
    done = pyport("diagnose", "nowhere.csv", "--out", "out", cwd=tmp_path)

    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("pyport: error: nowhere.csv:1: no such file")


@pytest.fixture(scope="module")
def nights(tmp_path_factory):
    """Return two files of recordings with refraction left in, and the folder of both diagnoses."""
    folder = tmp_path_factory.mktemp("nights")
    names = [folder / "first.csv", folder / "second.csv"]
    for seed, path in enumerate(names, 1):
        write(recordings(70, seed, y=lambda at: 60 / np.tan(at.el)), path)
    done = pyport("diagnose", *names, "--jobs", 2, "--json", "--out", folder / "both")
    return names, folder / "both", done


@pytest.mark.slow
def test_a_diagnosis_leaves_report_rows_and_pictures(nights):
    """Each file of recordings gets its folder; the report is valid JSON and on standard output."""
    names, out, done = nights
    told = [json.loads(line) for line in done.stdout.splitlines()]

    assert done.returncode == 0
    for name, report in zip(names, told, strict=True):
        folder = out / name.stem
        assert report == json.loads((folder / "report.json").read_text())
        assert (folder / "rows.csv").stat().st_size > 0
        assert list(folder.glob("finding-1-*.png"))


@pytest.mark.slow
def test_a_diagnosis_may_only_be_printed(nights, tmp_path, monkeypatch):
    """As it is beside a folder of reports, and what a folder would keep."""
    names, *_ = nights
    monkeypatch.chdir(tmp_path)
    printed = CliRunner().invoke(command_line, ["diagnose", str(names[0])]).output

    assert "1. refraction" in printed
    assert "--out FOLDER keeps" in printed
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_several_files_are_each_as_if_alone(nights, tmp_path):
    """Two files in one process, two at a time, give what each gives by itself."""
    names, out, _ = nights
    pyport("diagnose", names[1], "--out", tmp_path)

    both, one = (where / names[1].stem / "report.json" for where in (out, tmp_path))

    assert both.read_bytes() == one.read_bytes()
