"""The tutorial's files are written, its commands run, and they print what it shows."""

import os
import re
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import pyport

ROOT = Path(pyport.__file__).parents[1]
PAGE = Path(__file__).parents[2] / "docs" / "parity-tutorial.md"
BLOCK = re.compile(r"^```(\w+)(?: file=(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: What pytest needs to know of the plugin where pyport is not installed.
INSTALLED = any(one.name == "pyport-parity" for one in entry_points(group="pytest11"))
PLUGIN = [] if INSTALLED else ["-p", "pyport.parity.plugin"]
#: What a shell finds as `pyport` and `pytest`: this checkout's.
TOOLS = {
    "pyport": f'exec "{sys.executable}" -m pyport "$@"',
    "pytest": f'exec "{sys.executable}" -m pytest -p no:cacheprovider {" ".join(PLUGIN)} "$@"',
}


def steps():
    """Yield the tutorial's files (name, text) and commands (None, command, expected lines)."""
    for language, name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if name:
            yield name, text, None
        elif language == "console":
            for part in text.split("$ ")[1:]:
                command, *expected = part.splitlines()
                yield None, command, expected


def shell(folder, command, status):
    """Run a command as the page's reader would."""
    done = subprocess.run(
        ["/bin/sh", "-c", f"(exit {status}); {command}"],
        cwd=folder, capture_output=True, text=True, check=False,
        env={
            **os.environ,
            "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(ROOT),
            "OPENBLAS_NUM_THREADS": "1",
        },
    )  # fmt: skip
    return done.returncode, done.stdout


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle", "same_library")
def test_every_command_prints_what_the_page_shows(tmp_path):
    """From source to green report, the three mistakes found on the way."""
    (tmp_path / "bin").mkdir()
    for name, line in TOOLS.items():
        tool = tmp_path / "bin" / name
        tool.write_text(f"#!/bin/sh\n{line}\n")
        tool.chmod(0o755)
    status, commands, shown = 0, 0, []
    for name, text, expected in steps():
        if name:
            (tmp_path / name).write_text(text, encoding="utf-8")
            continue
        status, output = shell(tmp_path, text, status)
        commands += 1
        shown.append((text, status))
        wanted = [one for one in expected if one != "..."]
        lines = iter(output.splitlines())
        missing = [one for one in wanted if not any(one == line for line in lines)]
        assert not missing, f"$ {text}\n{output}"

    assert commands == len(re.findall(r"^\$ ", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    verdicts = [status for text, status in shown if text.endswith("--config parity.toml")]
    assert verdicts == [1, 1, 1, 0, 0, 0, 0]
