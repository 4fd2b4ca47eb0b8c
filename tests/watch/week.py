"""Measure memory and times of a week of readings every ten seconds.

python tests/watch/week.py [READINGS]
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import pyport
from pyport.watch import state

EVERY_S, WEEK = 10.0, 60_480
START = np.datetime64("2024-03-01T00:00:00", "ms")


def readings(rng, count, first):
    """Return white recordings of five arcseconds, one every ten seconds."""
    moment = START + (1000 * EVERY_S * (first + np.arange(count))).astype("timedelta64[ms]")
    offsets = 5 * rng.standard_normal((2, count))
    return {
        "time_utc": moment,
        "session": moment.astype("datetime64[D]").astype(str),
        "az_deg": rng.uniform(0, 360, count),
        "el_deg": rng.uniform(15, 85, count),
        "d_xel_arcsec": offsets[0],
        "d_el_arcsec": offsets[1],
        "temperature_c": np.round(rng.uniform(0, 1, count), 1),
    }


def main(count):
    """Print memory and times every thousand readings, and the slowest update of all."""
    rng = np.random.default_rng(1)
    watch = pyport.Watch(readings(rng, 300, -3000), header={"latitude_deg": 53.0})
    table = readings(rng, count, 0)
    taken, kept = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "state.npz"
        for n in range(count):
            row = {name: cells[n] for name, cells in table.items()}
            begun = time.perf_counter()
            watch.update(row)
            taken.append(time.perf_counter() - begun)
            if n % 100 == 0:
                begun = time.perf_counter()
                state.save(watch, path)
                kept.append(time.perf_counter() - begun)
            if n % 1000 == 999:
                memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
                last = 1e3 * np.array(taken[-1000:])
                print(
                    f"{n + 1:6d} readings: {memory:.0f} MB at most, update median "
                    f"{np.median(last):.1f} ms, 99 % {np.quantile(last, 0.99):.1f} ms, state "
                    f"{path.stat().st_size / 2**20:.2f} MB kept in {1e3 * np.median(kept):.1f} ms, "
                    f"{watch.raised} alarms",
                    flush=True,
                )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else WEEK)
