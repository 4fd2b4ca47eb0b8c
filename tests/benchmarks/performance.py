"""What was measured, against what was promised: a table on the terminal and `docs/performance.md`.

python performance.py RUN.json              print the table, beside the last recorded run
python performance.py RUN.json --record     also rewrite the page and the recorded run
"""

from __future__ import annotations

import cProfile
import io
import json
import os
import platform
import pstats
import re
import runpy
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
PAGE = ROOT / "docs" / "performance.md"
RECORDED = ROOT / "docs" / "performance.json"
GROWTH = ROOT / "docs" / "growth.json"
#: Functions of a profile that are shown.
SHOWN = 6


@dataclass(frozen=True)
class Row:
    """One promise and what became of it."""

    spec: dict[str, Any]
    ours: dict[str, Any]
    peer: dict[str, Any] | None

    @property
    def value(self) -> float:
        """Return what is promised, as it was measured."""
        ours, peer = seconds(self.ours), self.peer and seconds(self.peer)
        match self.spec["sense"]:
            case "faster":
                return peer / ours
            case "slower":
                return ours / peer
            case "rate":
                return self.ours["rows"] / self.ours["seconds"] / 1e6
        return ours

    @property
    def met(self) -> bool:
        """Tell whether the promise was kept."""
        if self.spec["sense"] in {"faster", "rate"}:
            kept = self.value >= self.spec["target"]
        else:
            kept = self.value <= self.spec["target"]
        return kept and self.ours.get("peak_mb", 0) <= self.spec.get("peak_mb", float("inf"))

    @property
    def unit(self) -> str:
        """Return what follows the number."""
        return {
            "faster": " times faster",
            "slower": " times its time",
            "seconds": " s",
            "rate": " million rows/s",
        }[self.spec["sense"]]


def seconds(one: dict[str, Any]) -> float:
    """Return the least time of a benchmark, its own if it took it itself [s]."""
    return float(one.get("seconds", one["min"]))


def rows_of(run: dict[str, Any]) -> list[Row]:
    """Return the promises that a run tells of."""
    found: dict[str, list[dict[str, Any]]] = {}
    for one in run["benchmarks"]:
        told = {"min": one["stats"]["min"], **one["extra_info"]}
        found.setdefault(one["group"], []).append(told)
    rows = []
    for spec in tomllib.loads((HERE / "rows.toml").read_text())["row"]:
        group = found.get(spec["group"], [])
        ours = [one for one in group if one.get("who") == "pyport"]
        peers = [one for one in group if one.get("who") != "pyport"]
        if ours and (peers or not spec["against"]):
            rows.append(Row(spec, ours[0], min(peers, key=seconds, default=None)))
    return rows


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
    simd = config["SIMD Extensions"].get("found", [])
    blas = config["Build Dependencies"]["blas"]
    return {
        "processor": f"{cpu or platform.processor()}, {os.cpu_count()} cores",
        "memory": f"{memory:.0f} GB",
        "system": f"{platform.system()} {platform.machine()}",
        "Python": platform.python_version(),
        "numpy": f"{np.__version__}, {blas['name']} {blas['version']}, {', '.join(simd[-2:])}",
        "scipy": scipy.__version__,
        "Fortran": f"{compiler}, -O3 -march=native",
        "threads": "one",
    }


def profile(workload: str) -> list[str]:
    """Return where the time of a workload goes: shares of its functions, their own time."""
    file, name = workload.split(":")
    sys.path.insert(0, str(ROOT / "tests"))
    work = runpy.run_path(str(HERE / file))[name]
    work()
    measured = cProfile.Profile()
    measured.enable()
    work()
    measured.disable()
    told = pstats.Stats(measured, stream=io.StringIO())
    every = sorted(told.stats.items(), key=lambda one: -one[1][2])  # type: ignore[attr-defined]
    total = sum(one[1][2] for one in every)
    lines = []
    for (path, _, function), (_, calls, own, _, _) in every[:SHOWN]:
        where = "" if path.startswith("~") else f" ({'/'.join(Path(path).parts[-2:])})"
        lines.append(f"{own / total:4.0%} in {calls} calls of `{function.strip('<>')}`{where}")
    return lines


def terminal(rows: list[Row], before: dict[str, float]) -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title="what was promised and what was measured")
    for heading in ("work", "against", "promised", "measured", "met", "last recorded"):
        table.add_column(heading, overflow="fold")
    for row in rows:
        last = before.get(row.spec["group"])
        change = "" if last is None else f"{last:.3g} ({row.value / last - 1:+.0%})"
        table.add_row(
            row.spec["work"], row.spec["against"], f"{row.spec['target']:g}{row.unit}",
            f"{row.value:.3g}{row.unit}", "yes" if row.met else "NO", change,
        )  # fmt: skip
    Console(width=150).print(table)


def page(rows: list[Row]) -> str:
    """Return the page."""
    lines = [
        "# Performance",
        "",
        "Generated by `make bench-record` from one run on the machine below; every number is the",
        "least of several rounds, ours and the peer's one after the other in the same run.",
        "",
        *(f"- {name}: {what}" for name, what in machine().items()),
        "",
        "| work | against | promised | measured | met |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        more = f", {row.ours['peak_mb']:.0f} MB" if "peak_mb" in row.ours else ""
        lines.append(
            f"| {row.spec['work']} | {row.spec['against']} | {row.spec['target']:g}{row.unit} "
            f"| {row.value:.3g}{row.unit}{more} | {'yes' if row.met else '**no**'} |"
        )
    lines += ["", "## In seconds", "", "| work | pyport | peer |", "|---|---|---|"]
    for row in rows:
        peer = "" if row.peer is None else f"{seconds(row.peer):.4g} ({row.peer['who']})"
        lines.append(f"| {row.spec['work']} | {seconds(row.ours):.4g} | {peer} |")
    for row in rows:
        if "stages" in row.ours:
            lines += ["", f"## Stages of: {row.spec['work']}", ""]
            taken = sorted(row.ours["stages"].items(), key=lambda one: -one[1])
            lines += [f"- {name}: {time:.2f} s" for name, time in taken]
    missed = [row for row in rows if not row.met]
    if missed:
        lines += ["", "## What is not met, and what it would need"]
    for row in missed:
        lines += ["", f"**{row.spec['work']}.** {row.spec.get('limit', '')}", ""]
        if "workload" in row.spec:
            lines += [f"- {line}" for line in profile(row.spec["workload"])]
    return "\n".join([*lines, "", *growth(rows)]) + "\n"


def growth(rows: list[Row]) -> list[str]:
    """Return how time and memory grow, and what a large array would take."""
    lines: list[str] = []
    if GROWTH.exists():
        told = json.loads(GROWTH.read_text())
        draw(told)
        picture = "![Time and memory against rows and candidates](pictures/growth.png)"
        lines += ["## Growth", "", picture, ""]
        headings = {
            "rows": "diagnosis in memory",
            "candidates": "diagnosis, columns tried",
            "data_sets": "data sets",
        }
        for kind, what in headings.items():
            lines += [f"{what}:", "", "| rows | columns | seconds | peak MB |", "|---|---|---|---|"]
            for one in told[kind]:
                columns = one.get("columns", "")
                lines.append(
                    f"| {one['rows']:.3g} | {columns} | {one['seconds']:.3g} "
                    f"| {one['peak_mb']:.0f} |"
                )
            lines.append("")
    speed = next((row for row in rows if row.spec["group"] == "data-set"), None)
    if speed is None or not GROWTH.exists():
        return lines
    one = json.loads(GROWTH.read_text())["rows"][-1]
    antennas, cores, year_rows = 2000, 64, 2000 * 365 * 8640
    read_h = year_rows / (speed.value * 1e6) / cores / 3600
    diagnose_h = antennas * one["seconds"] / cores / 3600
    return [
        *lines,
        "## An array of 2,000 antennas, a year of recordings",
        "",
        f"A reading every ten seconds makes {year_rows:.2g} rows. In folders `antenna=NAME`, on a",
        "Dask cluster:",
        "",
        "```",
        "pyport diagnose recordings --each antenna --cluster tcp://scheduler:8786 --out diagnoses",
        "```",
        "",
        f"At the rates above, {cores} cores take {read_h:.2g} hours for the two passes and",
        f"{diagnose_h:.2g} hours for {antennas:,} diagnoses of normal points, each taken as that",
        f"of {one['rows']:,} rows in memory. A worker that dies loses what it was doing and nothing",
        "else: its antenna is given to another. Workers need the same files under the same names.",
        "A single data set of many antennas together (without `--each`) is gone through by all",
        "workers, and its normal points are diagnosed by one process.",
    ]


def draw(told: dict[str, list[dict[str, float]]]) -> None:
    """Draw the growth."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    for kind, label in (("rows", "diagnosis in memory"), ("data_sets", "data set, two passes")):
        sizes = [one["rows"] for one in told[kind]]
        left.loglog(sizes, [one["seconds"] for one in told[kind]], "o-", label=f"{label}: s")
        left.loglog(sizes, [one["peak_mb"] for one in told[kind]], "s:", label=f"{label}: MB")
    left.set_xlabel("rows")
    left.legend(fontsize=7)
    columns = [one["columns"] for one in told["candidates"]]
    right.plot(columns, [one["seconds"] for one in told["candidates"]], "o-")
    right.set_xlabel("columns tried, 5,600 rows")
    right.set_ylabel("s")
    figure.savefig(ROOT / "docs" / "pictures" / "growth.png", dpi=110)
    plt.close(figure)


def main() -> None:
    """Print the table; with --record rewrite the page."""
    rows = rows_of(json.loads(Path(sys.argv[1]).read_text()))
    before = json.loads(RECORDED.read_text()) if RECORDED.exists() else {}
    terminal(rows, before)
    for row in rows:
        if not row.met and "workload" in row.spec and "--record" not in sys.argv:
            sys.stdout.write(f"\n{row.spec['work']}: {row.spec['limit']}\n")
            sys.stdout.writelines(f"  {line}\n" for line in profile(row.spec["workload"]))
    if "--record" in sys.argv:
        PAGE.write_text(page(rows), encoding="utf-8")
        kept = {row.spec["group"]: round(row.value, 4) for row in rows}
        RECORDED.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
