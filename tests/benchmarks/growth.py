"""Growth: how time and memory grow with the rows, and with the candidates that are tried.

python growth.py make FOLDER ROWS      write a data set
python growth.py read FOLDER           diagnose it by normal points; print what that took, as JSON
python growth.py diagnose ROWS         diagnose so many rows in memory, without pages
python growth.py candidates EVERY MORE the same on 5,600 rows, one candidate out of so many
python growth.py all OUT LARGEST       all of it up to data sets of LARGEST rows, into OUT; with
                                       zero the data sets that OUT tells of are left as they are
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

DAYS, ANTENNAS = 20, 2
META = {"latitude_deg": "53.0955", "longitude_deg": "18.5640", "height_m": "133"}
CHUNK = 1 << 20


def make(root: Path, rows: int) -> None:
    """Write tracks across the sky: refraction left out, noise of 10 arcsec, one outlier in 200."""
    import pyarrow
    from pyarrow import parquet

    rng = np.random.default_rng(1)
    each = rows // (DAYS * ANTENNAS)
    for n in range(DAYS * ANTENNAS):
        day, antenna = divmod(n, ANTENNAS)
        left = each if n else rows - each * (DAYS * ANTENNAS - 1)
        path = root / f"night={day:03d}" / f"A{antenna}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        writer, begin, step = None, 1.7668e9 + 86400 * day, 80000 / left
        while left:
            size = min(CHUNK, left)
            columns = tracks(rng, begin + step * np.arange(size), f"A{antenna}")
            table = pyarrow.table(columns).replace_schema_metadata(META)
            writer = writer or parquet.ParquetWriter(path, table.schema)
            writer.write_table(table)
            begin, left = begin + step * size, left - size
        writer.close()


def tracks(rng: np.random.Generator, time_s: np.ndarray, antenna: str) -> dict[str, object]:
    """Return the columns of some tracks of 600 rows."""
    import pyarrow

    size = len(time_s)
    first = rng.uniform([-90, 8], [450, 84], (-(-size // 600), 2))
    along = np.arange(size) % 600 / 600
    az, el = np.repeat(first, 600, axis=0)[:size].T + along
    x = 20 * np.cos(np.radians(el)) - 10 + rng.normal(0, 10, size)
    y = 30 + 12 / np.tan(np.radians(el)) + rng.normal(0, 10, size)
    bad = rng.random(size) < 1 / 200
    x[bad] += rng.normal(0, 300, bad.sum())
    return {
        "az_deg": az,
        "el_deg": el,
        "d_xel_arcsec": x,
        "d_el_arcsec": y,
        "time_utc": (time_s * 1e6).astype("datetime64[us]"),
        "antenna": pyarrow.array(np.full(size, antenna)).dictionary_encode(),
        "temperature_c": 10 + 5 * np.sin(time_s / 13751) + rng.normal(0, 0.1, size),
    }


def peak_mb() -> float:
    """Return this process's largest memory so far [MB].

    What `getrusage` tells on Linux is no less than that of the process which started this one.
    """
    status = Path("/proc/self/status")
    if status.exists():
        return int(status.read_text().split("VmHWM:")[1].split()[0]) * 1024 / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000


def read(root: Path) -> dict[str, float]:
    """Diagnose a data set: two passes over its rows, the search over its normal points."""
    from pyport.diagnosis.diagnose import diagnose as run
    from pyport.formats.models import load
    from pyport.recordings import read as reduce

    begin, worked = time.perf_counter(), time.process_time()
    recordings = reduce(root)
    between, passes_s = time.perf_counter(), time.process_time() - worked
    found = recordings.reduction
    told = {
        "rows": found.rows,
        "reduced": found.rows - sum(found.set_aside.values()),
        "points": found.points,
        "antennas": ANTENNAS,
        "seconds": between - begin,
        "processor_s": passes_s,
    }
    named = [one.effect for one in run(recordings, load("altaz")).findings]
    told |= {"diagnosis_s": time.perf_counter() - between, "peak_mb": peak_mb()}
    return {**told, "named": named}


def cut(design: Callable[..., Any], every: int) -> Callable[..., Any]:
    """Return a design that keeps one candidate out of so many."""

    def some(*given: object, **options: object) -> object:
        columns, found, *rest = design(*given, **options)
        found = found[::every]
        kept = [columns[:, one.columns] for one in found]
        ends = np.cumsum([one.shape[1] for one in kept])
        again = [
            replace(one, columns=np.arange(end - own.shape[1], end))
            for one, own, end in zip(found, kept, ends, strict=True)
        ]
        return np.concatenate(kept, axis=1), again, *rest

    return some


def diagnose(rows: int, hidden: str | None, every: int = 1, more: int = 0) -> dict[str, float]:
    """Diagnose recordings that are in memory, with all candidates or one out of so many.

    An effect is hidden in them, or nothing: where a cause is hidden that no candidate stands
    for, the search goes on and on. Each of `more` columns that nobody knows is tried as a curve.
    """
    from pyport.diagnosis import candidates
    from pyport.diagnosis.diagnose import diagnose as run
    from pyport.examiner.sealed.record.files import write_recordings
    from pyport.examiner.worlds.kinds import make_case
    from pyport.formats.models import load
    from pyport.recordings import read as read_file

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.csv"
        write_recordings(make_case("one" if hidden else "null", 91, rows=rows, effect=hidden), path)
        recordings = read_file(path)
    unknown = np.random.default_rng(1).random((more, len(recordings)))
    recordings.at.columns.update({f"unknown_{n}": one for n, one in enumerate(unknown)})
    candidates.design = cut(candidates.design, every)
    begin, worked = time.perf_counter(), time.process_time()
    done = run(recordings, load("altaz"))
    tried = sum(len(one.columns) for one in done.problem.candidates)
    return {
        "rows": rows,
        "columns": tried,
        "seconds": time.perf_counter() - begin,
        "processor_s": time.process_time() - worked,
        "peak_mb": peak_mb(),
    }


def apart(*words: object) -> dict[str, float]:
    """Run one measurement in a process of its own."""
    command = [sys.executable, __file__, *map(str, words)]
    one = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=one)
    return json.loads(done.stdout)


def everything(largest: int) -> dict[str, list[dict[str, float]]]:
    """Measure all sizes, data sets of up to `largest` rows."""
    found: dict[str, list[dict[str, float]]] = {"data_sets": []}
    found["rows"] = [apart("diagnose", rows) for rows in (1000, 3000, 10_000, 30_000)]
    sizes = (100, 0), (30, 0), (10, 0), (3, 0), (1, 0), (1, 40)
    found["candidates"] = [apart("candidates", *size) for size in sizes]
    rows = 1000
    while rows <= largest:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder) / "set"
            make(root, rows)
            found["data_sets"].append(apart("read", root))
            shutil.rmtree(root)
        rows *= 10
    return found


def main() -> None:
    """Do what the command line says."""
    what, *rest = sys.argv[1:]
    if what == "make":
        make(Path(rest[0]), int(float(rest[1])))
    elif what == "all":
        path, largest = Path(rest[0]), int(float(rest[1]))
        before = json.loads(path.read_text()) if path.exists() else {}
        found = everything(largest)
        kept = {kind: measured or before.get(kind, []) for kind, measured in found.items()}
        path.write_text(json.dumps(kept, indent=1) + "\n")
    elif what == "read":
        sys.stdout.write(json.dumps(read(Path(rest[0]))))
    elif what == "diagnose":
        sys.stdout.write(json.dumps(diagnose(int(rest[0]), "refraction")))
    else:
        sys.stdout.write(json.dumps(diagnose(5600, None, *map(int, rest))))


if __name__ == "__main__":
    main()
