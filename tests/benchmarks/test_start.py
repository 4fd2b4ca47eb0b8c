"""How long until the program is there, beside numpy's own import."""

from __future__ import annotations

import subprocess
import sys

import pytest

ROWS = {"test_start": "start", "test_import": "import"}


def run(*words):
    """Run Python to its end."""
    return lambda: subprocess.run([sys.executable, *words], check=True, capture_output=True)


def test_start(measured):
    """`pyport --help`."""
    measured("pyport", run("-m", "pyport", "--help"), rounds=20)


def test_import(measured):
    """`import pyport`."""
    measured("pyport", run("-c", "import pyport"), rounds=20)


@pytest.mark.parametrize("group", ["start", "import"])
def test_numpy(measured, group):
    """`import numpy`."""
    measured("numpy", run("-c", "import numpy"), rounds=20, group=group)
