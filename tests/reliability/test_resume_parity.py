"""A comparison of the ports, killed and called again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rt32
from rt32_inputs import random

from pyport.parity import promise
from pyport.parity.compare import Pair
from pyport.parity.described.functions import ask_port
from pyport.parity.run import over
from pyport.runs.checkpoint import Checkpoint

CHUNKS = [(start, start + 25) for start in range(0, 6000, 25)]
#: Compares by itself in two processes, so that it can be killed; prints who works.
RUN = """
import os, sys
from pathlib import Path
sys.path[:0] = sys.argv[2:]
from pyport.runs import checkpoint
from test_resume_parity import CHUNKS, between
from pyport.parity.run import over
checkpoint.LEAST_S = 0.05
print(repr(over(CHUNKS, between, 2, checkpoint.Checkpoint(Path(sys.argv[1]), "parity"))))
"""


def between(chunk):
    """Hold the vectorised port to the legacy port, which stands for the oracle here."""
    start, stop = chunk
    at = random(stop - start, [7, start])
    results = {}
    for routine in rt32.ROUTINES:
        true, port = (
            ask_port(rt32.DESCRIPTION, one, routine, at) for one in rt32.DESCRIPTION.ports
        )
        span = {key: (values, values) for key, values in true.items()}
        pair = Pair(routine, at, true, port)
        results["vectorised", routine.name] = promise.hold(
            rt32.DESCRIPTION, rt32.VECTORISED, pair, span
        )
    time.sleep(0.03)
    return results


def start(kept):
    """Start a comparison."""
    here = Path(__file__).parent
    folders = [str(one) for one in (here, here.parent, rt32.FORTRAN)]
    return subprocess.Popen(
        [sys.executable, "-c", RUN, str(kept), *folders],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )


def done(kept):
    """Return how many chunks a killed run has kept."""
    state = Checkpoint(kept, "parity").load()
    return 0 if state is None else state[0]["done"]


def children(pid):
    """Return the processes that a process has started."""
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="no /proc tells who works")
def test_killed_and_called_again_it_says_the_same(tmp_path):
    """Nothing compared twice but what had not been kept; nobody works for a run that is dead."""
    kept = tmp_path / "kept.npz"
    workers = set()
    for _ in range(2):
        before = done(kept)
        process = start(kept)
        while process.poll() is None and done(kept) < before + 8:
            time.sleep(0.02)
        workers |= set(children(process.pid))
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        process.stdout.close()
    assert 16 <= done(kept) < len(CHUNKS)
    told, _ = start(kept).communicate()
    alone = over(CHUNKS, between, 1, Checkpoint(None))

    assert told == f"{alone!r}\n"
    assert len(workers) >= 4
    until = time.monotonic() + 20
    while any(Path(f"/proc/{pid}").exists() for pid in workers) and time.monotonic() < until:
        time.sleep(0.05)
    assert not [pid for pid in workers if Path(f"/proc/{pid}").exists()]
