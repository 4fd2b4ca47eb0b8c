"""Workers: the same answer to the last digit from one process, from many, and when some die."""

from __future__ import annotations

import json
import math
import os
import signal
import socket
import threading
import time
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from pyport import pipeline as diagnoses
from pyport.errors import BadInput
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.seal import seal
from pyport.examiner.sealed.solve import run
from pyport.recordings import read, resolve
from pyport.runs.workers import workers

pytestmark = pytest.mark.slow

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def cluster():
    """Return a real cluster of three worker processes."""
    with distributed.LocalCluster(
        n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def data_set(tmp_path_factory):
    """Return a data set of twelve files."""
    root = tmp_path_factory.mktemp("set")
    rng = np.random.default_rng(5)
    for n in range(12):
        rows = 3000
        columns = {
            "az_deg": rng.uniform(0, 360, rows),
            "el_deg": rng.uniform(10, 80, rows),
            "d_xel_arcsec": rng.normal(0, 10, rows),
            "d_el_arcsec": rng.standard_t(2, rows) * 10,
            "time_utc": ((1.76e9 + 86400 * n + np.arange(rows)) * 1e6).astype("datetime64[us]"),
        }
        parquet.write_table(pyarrow.table(columns), root / f"night-{n:02d}.parquet")
    return root


def numbers(recordings):
    """Return everything that was computed."""
    at = recordings.at
    return [at.az, at.el, at.numbers("time"), recordings.x, recordings.y, recordings.sigma_y,
            at.fine.at.az, at.fine.share]  # fmt: skip


def test_results_come_in_order(cluster):
    """Whoever works, and however many."""
    for arguments in ({}, {"jobs": 2}, {"cluster": cluster.scheduler_address}):
        with workers(**arguments) as spread:
            assert list(spread(math.factorial, range(40))) == list(map(math.factorial, range(40)))


def test_bad_input_comes_through(cluster):
    """What a worker refuses is said as if it were refused here."""
    for arguments in ({"jobs": 2}, {"cluster": cluster.scheduler_address}):
        with workers(**arguments) as spread, pytest.raises(BadInput) as there:
            list(spread(resolve, ["gmrt-cyg-a", "nowhere.csv"]))
        with pytest.raises(BadInput) as here:
            resolve("nowhere.csv")
        assert str(there.value) == str(here.value)


def test_no_cluster_is_said(monkeypatch):
    """One line names the address."""
    monkeypatch.setattr("pyport.runs.workers.PATIENCE_S", 0.5)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    with pytest.raises(BadInput, match="expected a Dask scheduler there"), workers(cluster=address):
        pass


@pytest.mark.slow
def test_a_worker_killed_half_way_changes_no_digit(cluster, data_set):
    """A data set is the same from one process and from three of whom one is killed."""
    alone = numbers(read(data_set))
    client = distributed.Client(cluster, set_as_default=False)
    victim = next(iter(client.run(os.getpid).values()))

    with workers(cluster=cluster.scheduler_address) as spread:

        def dying(call, items):
            for n, result in enumerate(spread(call, items)):
                if n == 5 and Path(f"/proc/{victim}").exists():
                    os.kill(victim, signal.SIGKILL)
                yield result

        together = numbers(read(data_set, spread=dying))

    assert victim not in client.run(os.getpid).values()
    client.close()
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one, other)


def test_processes_change_no_digit(data_set):
    """Nor do two processes of this machine."""
    with workers(jobs=2) as spread:
        several = numbers(read(data_set, spread=spread))

    for one, other in zip(numbers(read(data_set)), several, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_diagnoses_of_each_antenna_survive_a_dead_worker(cluster, tmp_path):
    """Antenna by antenna, a worker killed half-way: reports are those of one process."""
    rng = np.random.default_rng(7)
    for n in range(4):
        rows, folder = 300, tmp_path / "set" / f"antenna=A{n}"
        folder.mkdir(parents=True)
        columns = {
            "az_deg": rng.uniform(0, 360, rows),
            "el_deg": rng.uniform(10, 80, rows),
            "d_xel_arcsec": rng.normal(0, 10, rows),
            "d_el_arcsec": rng.normal(0, 10, rows),
        }
        parquet.write_table(pyarrow.table(columns), folder / "night.parquet")
    names = diagnoses.apart([str(tmp_path / "set")], "antenna")
    asked = {
        kind: diagnoses.requests(names, model="altaz", refit="all", seed=0, out=tmp_path / kind)
        for kind in ("alone", "together")
    }
    alone = [done.report for done in diagnoses.run_all(asked["alone"])]

    together = []
    for done in diagnoses.run_all(asked["together"], cluster=cluster.scheduler_address):
        if not together:
            kill_one(cluster)
        together.append(done.report)

    assert together == alone
    assert len({json.loads(one)["input"]["file"] for one in together}) == 4


def kill_one(cluster):
    """Kill a worker as the system would that has no memory left."""
    with distributed.Client(cluster, set_as_default=False) as client:
        victim = next(iter(client.run(os.getpid).values()))
    os.kill(victim, signal.SIGKILL)


@pytest.mark.slow
def test_a_campaign_of_trials_is_solved_on_a_cluster(cluster, tmp_path):
    """Every case gets its answer, a worker killed on the way or not, and the same as elsewhere.

    A solver that says nothing is recorded as having failed.
    """
    answers = []
    for name, where in (("here", None), ("there", cluster.scheduler_address)):
        root = tmp_path / name
        seal(root, "a-set", [Spec("null", "null", rows=60)] * 6)
        killer = threading.Thread(target=kill_when_one_is_solved, args=(cluster, root))
        if where is not None:
            killer.start()

        solved = run(root, solver=("pyport.version_of_nothing",), cluster=where)

        if where is not None:
            killer.join()
        reports = [json.loads(one.read_text()) for one in root.rglob("report.json")]
        assert solved == len(reports) == 6
        answers.append(sorted(one["examined"]["failed"] for one in reports))

    assert answers[0] == answers[1]


def kill_when_one_is_solved(cluster, root):
    """Wait for the first answer, then kill a worker."""
    while not list(root.rglob("report.json")):
        time.sleep(0.02)
    kill_one(cluster)
