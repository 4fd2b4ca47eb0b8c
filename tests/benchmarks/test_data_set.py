"""Data sets of Parquet: rows a second of one process, and its peak memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from benchmarks import limits

ROWS = {"test_data_set": "data-set"}
MEASURE = Path(__file__).with_name("growth.py")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a data set of as many rows as asked for, ten million if nobody says."""
    rows = int(float(os.environ.get("PYPORT_BENCH_ROWS", "1e7")))
    root = tmp_path_factory.mktemp("sets") / "set"
    subprocess.run([sys.executable, MEASURE, "make", root, str(rows)], check=True)
    return root


def test_data_set(benchmark, beside, made):
    """Two passes over all rows, one process."""
    told = []

    def run():
        command = [sys.executable, MEASURE, "read", made]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        told.append(json.loads(done.stdout))

    beside(run, {}, rounds=2, limit=limits.of_data_set(made))
    best = min(told, key=lambda one: one["seconds"])
    benchmark.extra_info.update(best)

    assert best["reduced"] == best["rows"]
