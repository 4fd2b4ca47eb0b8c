"""What no input may make the program do: run code, reach out, open or write elsewhere."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import pytest

import pyport
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import write_recordings

PACKAGE = Path(pyport.__file__).parent
TREES = {
    path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text(encoding="utf-8"))
    for path in sorted(PACKAGE.rglob("*.py"))
}
#: Modules that turn bytes into objects or code, or that open connections.
FORBIDDEN = {
    *("pickle", "dill", "cloudpickle", "joblib", "marshal", "shelve", "code", "codeop", "cffi"),
    *("socket", "ssl", "http", "urllib", "urllib3", "requests", "httpx", "aiohttp", "ftplib"),
    *("smtplib", "telnetlib", "xmlrpc", "socketserver", "webbrowser"),
}
#: Who alone may import what starts another Python, git, a compiler, Dask or the user's command on
#: an alarm, serves the watch's page, or calls compiled code.
WHO_MAY = {
    "subprocess": {
        *("examiner/sealed/solve.py", "examiner/sealed/verify.py"),
        *("examiner/sealed/record/history.py", "examiner/real/sets.py", "watch/state.py"),
        *("parity/compiled/build.py", "parity/evidence/coverage.py"),
    },
    "asyncio": {"watch/serve.py"},
    "runpy": {"examiner/sealed/cell.py"},
    "distributed": {"runs/workers.py"},
    "ctypes": {"legacy/intrinsics.py", "parity/compiled/stored.py"},
}
#: Who alone may import a module by a name: its own modules, and the ports of a parity.toml.
BY_NAME = {
    *("__init__.py", "cli/manners.py", "pointing/__init__.py", "mounts/__init__.py"),
    "parity/described/functions.py",
}
#: Who alone may import compiled code from a file: the module that f2py made of the Fortran.
COMPILED = {"parity/compiled/oracle.py"}
#: Functions that evaluate text, wherever they come from.
EVALUATING = frozenset({"eval", "exec", "compile", "__import__", "execfile", "literal_eval"})
#: Methods that do, or that run programs; `re.compile` is none of them.
METHODS = frozenset({"system", "popen", "execv", "execve", "spawnl", "spawnv", "startfile"})


def imported(tree):
    """Yield the first word of every module that is imported."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield (node.module or "").partition(".")[0]


def called(tree):
    """Yield every call with the name of what is called and whether it is a method's."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name):
                yield node, node.func.id, False
            elif isinstance(node.func, ast.Attribute):
                yield node, node.func.attr, True


def holds_objects(call):
    """Tell whether a call reads one of numpy's or YAML's files that may hold objects."""
    of = getattr(getattr(call.func, "value", None), "id", "")
    pickles = [one.value for one in call.keywords if one.arg == "allow_pickle"]
    plain = len(pickles) == 1 and getattr(pickles[0], "value", None) is False
    reads = getattr(call.func, "attr", "") == "load" and of in {"np", "numpy", "yaml"}
    return (reads or bool(pickles)) and not plain


def test_no_module_that_runs_what_it_reads_or_reaches_out():
    """No pickle, no socket, nothing that speaks to the network; exceptions by name."""
    found = {
        (file, module)
        for file, tree in TREES.items()
        for module in imported(tree)
        if module in FORBIDDEN or file not in WHO_MAY.get(module, {file})
    }

    assert len(TREES) > 100
    assert not found


def test_no_text_is_evaluated():
    """No eval, no exec, no shell, no numpy file that may hold objects."""
    found = []
    for file, tree in TREES.items():
        for node, name, of_something in called(tree):
            keywords = {one.arg for one in node.keywords}
            evaluates = name in EVALUATING and not of_something
            runs = of_something and name in METHODS
            by_name = name == "import_module" and file not in BY_NAME
            loads = name == "ExtensionFileLoader" and file not in COMPILED
            if evaluates or runs or by_name or loads or "shell" in keywords or holds_objects(node):
                found.append(f"{file}:{node.lineno}: {name}")

    assert not found


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return simulated recordings whose columns bear hostile names."""
    path = tmp_path_factory.mktemp("given") / "night.csv"
    write_recordings(Spec("one", "one", "refraction", 1.0, 60).make(5), path)
    text = path.read_text()
    assert "tsys_k" in text
    path.write_text(text.replace("tsys_k", "../../../escaped").replace("focus_mm", "/etc/escaped"))
    return path


#: Runs commands one after the other and prints what they reached for beyond this machine, and
#: which files they wrote; the first argument is the folder of the answers.
WATCHED = """
import os, sys
from pathlib import Path
reached, written = set(), set()
NETWORK = ("socket.connect", "socket.getaddrinfo", "socket.bind", "socket.sendto",
           "socket.gethostbyname", "urllib.Request", "http.client.connect", "ftplib.connect")
PROGRAMS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn")
def watch(event, arguments):
    if event in NETWORK or event in PROGRAMS:
        reached.add(event)
        raise PermissionError(event)
    if event == "open" and isinstance(arguments[0], (str, bytes)) and isinstance(arguments[2], int):
        if arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            written.add(os.path.realpath(os.fsdecode(arguments[0])))
    elif event in ("os.rename", "os.mkdir", "os.remove"):
        written.add(os.path.realpath(os.fsdecode(arguments[0])))
sys.addaudithook(watch)
import click
from pyport import cli
for line in sys.stdin.read().splitlines():
    cli.pyport.main(line.split("\\t"), prog_name="pyport", standalone_mode=False)
print(*sorted(reached), file=sys.stderr)
print(*sorted(written), sep="\\n", file=sys.stderr)
"""


def test_commands_reach_no_network_and_write_in_their_folder_alone(night, tmp_path):
    """Names of columns lead nowhere; no connection is opened, no program started."""
    out = tmp_path / "out"
    commands = [
        ("dev", "effects"),
        ("look", night, "--out", out / "look"),
        ("fit", night, "--model", "altaz", "--out", out / "fit"),
        ("diagnose", night, "--out", out / "diagnosis"),
        ("plot", night, "--of", "fit", "--format", "svg", "--panel", "against-_escaped",
         "--panel", "against-_etc_escaped", "--out", out / "plots"),
        ("convert", night, out / "night.ecsv"),
        ("convert", night, out / "night.parquet"),
        ("dev", "reduction", "sizes"),
        ("table", "--az", "0:10:1", "-o", out / "table.txt"),
        ("dev", "trials", "make", "--kind", "null", "--rows", "30", "-o", out / "cases"),
    ]  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-B", "-c", WATCHED],
        input="\n".join("\t".join(map(str, words)) for words in commands),
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "TMPDIR": str(tmp_path)},
    )
    assert done.returncode == 0, done.stderr
    reached, *written = done.stderr.split("\n")
    # matplotlib makes folders for its settings and its list of fonts
    allowed = str(tmp_path), "/dev/null", mpl.get_cachedir(), mpl.get_configdir()
    elsewhere = [one for one in written if one and not one.startswith(allowed)]

    assert not reached
    assert not elsewhere
    assert (out / "plots" / "against-_escaped.svg").is_file()


def test_a_name_that_no_report_can_spell_is_one_line(night, tmp_path):
    """Bytes that are no UTF-8 in a file's name are refused before anything is read."""
    path = os.fsencode(tmp_path) + b"/caf\xe9.csv"
    try:
        Path(os.fsdecode(path)).write_bytes(night.read_bytes())
    except OSError:
        pytest.skip("this file system takes no such name")
    done = subprocess.run(
        [sys.executable, "-m", "pyport", "look", path], capture_output=True, check=False
    )

    assert done.returncode == 2
    assert done.stderr.startswith(b"pyport: error: ")
    assert done.stderr.count(b"\n") == 1
    assert b"no UTF-8" in done.stderr
