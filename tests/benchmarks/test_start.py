"""How long until the program is there, beside numpy's own import."""

from __future__ import annotations

import subprocess
import sys

from benchmarks import limits

ROWS = {"test_start": "start", "test_import": "import"}


def run(*words):
    """Run Python to its end."""
    return lambda: subprocess.run([sys.executable, *words], check=True, capture_output=True)


NUMPY = {"import numpy": run("-c", "import numpy")}
LIMIT = limits.of_process("pass", "Python's start")


def test_start(beside):
    """`pyport --help`."""
    beside(run("-m", "pyport", "--help"), NUMPY, rounds=20, limit=LIMIT)


def test_import(beside):
    """`import pyport`."""
    beside(run("-c", "import pyport"), NUMPY, rounds=20, limit=LIMIT)
