"""The page on performance is what its tools make of the recorded run, and tells all promises."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def performance(monkeypatch):
    """Return the module that writes the page."""
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "benchmarks"))
    import performance

    return performance


def test_page_is_that_of_the_recorded_run(performance):
    """Nobody writes a number into it by hand."""
    recorded = json.loads(performance.RECORDED.read_text())
    grown = json.loads(performance.growth_page.GROWN.read_text())

    assert performance.page(recorded, grown) == performance.PAGE.read_text(encoding="utf-8")


def test_every_promise_has_its_row(performance):
    """Kept or not; what is not kept says what it would need."""
    recorded = json.loads(performance.RECORDED.read_text())
    rows = performance.rows_of(recorded, None)
    text = performance.page(recorded, None)

    for row in rows:
        assert f"| {row.spec['work']} | {row.spec['against']} | {row.promised} |" in text
        if row.told and not row.met:
            assert row.spec["limit"] in text


def test_least_time_of_the_quickest_peer_counts(performance):
    """Ratios are ours against the quickest of the peers, rates by processor time."""
    row = performance.Row
    against = {"group": "g", "work": "w", "against": "a", "target": 2.0}
    told = {"seconds": 2.0, "peers": {"slow": 9.0, "quick": 3.0}}
    rate = {"seconds": 1.0, "processor_s": 2.0, "rows": 4e6, "peers": {}, "peak_mb": 7}
    alone = {**against, "against": "", "sense": "rate", "peak_mb": 6}

    assert row({**against, "sense": "faster"}, told).value == 1.5
    assert not row({**against, "sense": "faster"}, told).met
    assert row({**against, "sense": "slower"}, told).value == 2 / 3
    assert row({**against, "sense": "slower"}, told).met
    assert row(alone, rate).value == 2.0
    assert not row(alone, rate).met
    assert row(alone, {}).measured == "not measured"


@pytest.mark.oracle
def test_benchmarks_measure_beside_their_peers(tmp_path):
    """They run when they are asked for alone; one is asked here, that none breaks unseen."""
    result = tmp_path / "bench.json"
    options = ["--benchmark-enable", "--benchmark-only", f"--benchmark-json={result}"]
    files = [str(ROOT / "tests" / "benchmarks" / "test_table.py"), "-k", "look_ups", "-q"]
    # A worker of xdist measures nothing, and its children take its variables for their own.
    alone = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *files, *options, "-p", "no:cacheprovider"],
        cwd=ROOT,
        env=alone,
        check=False,
        capture_output=True,
        text=True,
    )

    assert done.returncode == 0, done.stdout + done.stderr
    (one,) = json.loads(result.read_text())["benchmarks"]
    assert one["extra_info"]["peers"]
