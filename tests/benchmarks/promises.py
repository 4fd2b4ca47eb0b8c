"""What is promised of speed, and what one run of the benchmarks measured of it.

A recorded run is `docs/performance.json`: for each promise the seconds of both sides, for each
that was not kept a profile; and the machine.
"""

from __future__ import annotations

import cProfile
import io
import os
import platform
import pstats
import re
import runpy
import shutil
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pyport.pointing import kernel

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
#: Rows that a promise of large data sets speaks of.
LARGEST = 10**8
#: Functions of a profile that are shown.
SHOWN = 8
#: How long a profile is taken at least. [s]
LEAST_S = 0.5
UNITS = {
    "faster": " times faster",
    "slower": " times its time",
    "seconds": " s",
    "rate": " million rows/s of a core",
}


@dataclass(frozen=True)
class Row:
    """One promise and what became of it.

    `told` is empty where it was not measured: seconds, peers' seconds by name, and what else
    the benchmark noted.
    """

    spec: dict[str, Any]
    told: dict[str, Any]

    @property
    def group(self) -> str:
        """Return its name."""
        return str(self.spec["group"])

    @property
    def peer(self) -> tuple[str, float] | None:
        """Return the quickest peer and its time [s]."""
        peers = self.told.get("peers", {})
        return min(peers.items(), key=lambda one: one[1], default=None)

    @property
    def value(self) -> float | None:
        """Return what is promised, as it was measured; None where it was not."""
        if not self.told or (self.spec["against"] and self.peer is None):
            return None
        ours, peer = float(self.told["seconds"]), self.peer
        match self.spec["sense"]:
            case "faster":
                return peer[1] / ours
            case "slower":
                return ours / peer[1]
            case "rate":
                return self.told["rows"] / self.told["processor_s"] / 1e6
        return ours

    @property
    def share(self) -> float | None:
        """Return the limit's share of the time taken; None where no limit was measured."""
        return self.told["limit_s"] / self.told["seconds"] if "limit_s" in self.told else None

    @property
    def without(self) -> str:
        """Return what was measured without the kernel, in words."""
        if "numpy_s" not in self.told:
            return ""
        return replace(self, told=self.told | {"seconds": self.told["numpy_s"]}).measured

    @property
    def met(self) -> bool:
        """Tell whether the promise was kept."""
        if self.value is None:
            return False
        if self.spec["sense"] in {"faster", "rate"}:
            kept = self.value >= self.spec["target"]
        else:
            kept = self.value <= self.spec["target"]
        return kept and self.told.get("peak_mb", 0) <= self.spec.get("peak_mb", float("inf"))

    @property
    def promised(self) -> str:
        """Return the promise in words."""
        memory = f", {self.spec['peak_mb']} MB" if "peak_mb" in self.spec else ""
        return f"{self.spec['target']:g}{UNITS[self.spec['sense']]}{memory}"

    @property
    def measured(self) -> str:
        """Return what was measured in words."""
        if self.value is None:
            return "not measured"
        memory = f", {self.told['peak_mb']:.0f} MB" if "peak_mb" in self.told else ""
        return f"{self.value:.3g}{UNITS[self.spec['sense']]}{memory}"


def specs() -> list[dict[str, Any]]:
    """Return the promises."""
    return tomllib.loads((HERE / "rows.toml").read_text())["row"]


def rows_of(recorded: dict[str, Any], grown: dict[str, Any] | None) -> list[Row]:
    """Return all promises and what a recorded run, and the record of growth, tell of them."""
    return [
        Row(spec, largest(grown) if "grown" in spec else recorded["rows"].get(spec["group"], {}))
        for spec in specs()
    ]


def largest(grown: dict[str, Any] | None) -> dict[str, Any]:
    """Return what the diagnosis of 1e8 rows took, if that was measured."""
    for one in (grown or {}).get("data_sets", []):
        if one["rows"] >= LARGEST:
            seconds, processor_s = (
                one[name] + one["diagnosis_s"] for name in ("seconds", "processor_s")
            )
            return {"peers": {}, **one, "seconds": seconds, "processor_s": processor_s}
    return {}


def condensed(run: dict[str, Any]) -> dict[str, Any]:
    """Return what is recorded of a run of pytest-benchmark."""
    rows: dict[str, Any] = {}
    others: dict[str, dict[str, float]] = {}
    promised = {spec["group"] for spec in specs()}
    for one in run["benchmarks"]:
        seconds = float(one["stats"]["min"]) / one["extra_info"].get("at_a_time", 1)
        if one["group"] in promised:
            rows[one["group"]] = {"seconds": seconds, **one["extra_info"]}
        else:
            others.setdefault(one["group"], {})[one["name"]] = seconds
    return {"machine": machine(), "rows": rows, "others": others}


def with_profiles(recorded: dict[str, Any]) -> dict[str, Any]:
    """Profile the work of every promise that was measured and not kept."""
    for row in rows_of(recorded, None):
        if row.told and not row.met and "workload" in row.spec:
            row.told["profile"] = profile(row.spec["workload"])
    return recorded


def machine() -> dict[str, str]:
    """Return what it was measured on."""
    import numpy as np
    import scipy

    cpu = ""
    if Path("/proc/cpuinfo").exists():
        names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
        cpu = names[0] if names else ""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    compiler = "none"
    if gfortran := shutil.which("gfortran"):
        told = subprocess.run([gfortran, "--version"], capture_output=True, text=True, check=True)
        compiler = told.stdout.splitlines()[0]
    config = np.show_config(mode="dicts")
    simd = config["SIMD Extensions"]
    sets = [*simd.get("baseline", []), *simd.get("found", [])]
    blas = config["Build Dependencies"]["blas"]
    return {
        "processor": f"{cpu or platform.processor()}, {os.cpu_count()} cores",
        "instruction sets": ", ".join(sets),
        "computed with": kernel.path(),
        "load when the run had ended": f"{os.getloadavg()[1]:.1f} processes",
        "memory": f"{memory:.0f} GB",
        "system": f"{platform.system()} {platform.machine()}",
        "Python": platform.python_version(),
        "numpy": f"{np.__version__}, {blas['name']} {blas['version']}",
        "scipy": scipy.__version__,
        "Fortran": f"{compiler}, -O3 -march=native",
        "threads": "one",
    }


def profile(workload: str) -> list[str]:
    """Return where the time of a workload goes: shares of its functions, their own time."""
    file, name = workload.split(":")
    sys.path.insert(0, str(ROOT / "tests"))
    work = runpy.run_path(str(HERE / file))[name]
    # the processor's time, so that whoever else works on this machine is not in it
    measured = cProfile.Profile(time.thread_time)
    work()
    begin = time.perf_counter()
    rounds = 0
    while not rounds or time.perf_counter() - begin < LEAST_S:
        measured.runcall(work)
        rounds += 1
    told = pstats.Stats(measured, stream=io.StringIO())
    every = sorted(told.stats.items(), key=lambda one: -one[1][2])  # type: ignore[attr-defined]
    total = sum(one[1][2] for one in every)
    lines = []
    for (path, _, function), (_, calls, own, _, _) in every[:SHOWN]:
        where = "" if path.startswith("~") else f" ({'/'.join(Path(path).parts[-2:])})"
        lines.append(
            f"{own / total:4.0%} in {calls // rounds} calls of `{function.strip('<>')}`{where}"
        )
    return lines
