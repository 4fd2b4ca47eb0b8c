"""How time and memory grow, as a picture and in words, and what a large array would take."""

from __future__ import annotations

from typing import Any

from promises import ROOT, Row

GROWN = ROOT / "docs" / "growth.json"
PICTURE = ROOT / "docs" / "pictures" / "growth.png"

KINDS = {
    "rows": "A diagnosis in memory, the whole catalogue",
    "candidates": "A diagnosis, one candidate of 100, 30, 10, 3, all, and 40 unknown columns more",
    "data_sets": "Data sets of Parquet reduced to normal points, two passes, one process",
}
#: The array that is scaled to: antennas, cores, and readings of an antenna in a day.
ANTENNAS, CORES, A_DAY = 2000, 64, 8640


def lines(grown: dict[str, Any] | None, rows: list[Row]) -> list[str]:
    """Return the page's part on growth."""
    if grown is None:
        return []
    found = [
        "## Growth",
        "",
        "`make growth` measures it, each size in a process of its own, in the time of one core.",
        "",
        "![Time and memory against rows and candidates](pictures/growth.png)",
        "",
    ]
    for kind, what in KINDS.items():
        second = {"data_sets": "normal points"}.get(kind, "columns")
        found += [f"{what}:", "", f"| rows | {second} | seconds | peak MB |", "|---|---|---|---|"]
        found += [
            f"| {one['rows']:.3g} | {one.get('columns', one.get('points')):.0f} "
            f"| {one['processor_s']:.3g} | {one['peak_mb']:.0f} |"
            for one in grown[kind]
        ]
        found.append("")
    speed = next((row for row in rows if row.group == "data-set"), None)
    if speed is None or speed.value is None:
        return found
    return [*found, *large_array(grown, speed.value)]


def large_array(grown: dict[str, Any], million_rows_s: float) -> list[str]:
    """Return what an array of many antennas with a year of recordings would take."""
    points = grown["data_sets"][-1]["points"] / grown["data_sets"][-1]["antennas"]
    like = min(grown["rows"], key=lambda one: abs(one["rows"] - points))
    year_rows = ANTENNAS * 365 * A_DAY
    read_min = year_rows / (million_rows_s * 1e6) / CORES / 60
    diagnose_min = ANTENNAS * like["processor_s"] / CORES / 60
    return [
        f"## An array of {ANTENNAS:,} antennas, a year of recordings",
        "",
        f"A reading every ten seconds makes {year_rows:.2g} rows. They lie in folders",
        "`antenna=NAME`, which every worker sees under the same name; the extra",
        "`pyport-pointing[dask]` brings Dask:",
        "",
        "```",
        "dask scheduler                                       # on one machine",
        "dask worker tcp://scheduler:8786 --nthreads 1 --nworkers 32   # on each of two others",
        "pyport diagnose recordings --each antenna --cluster tcp://scheduler:8786 --out diagnoses",
        "```",
        "",
        f"At {million_rows_s:.2g} million rows a second and core, as in the table above,",
        f"{CORES} cores that get their rows as fast take {read_min:.2g} minutes for the two",
        f"passes over all of them, and {diagnose_min:.2g} minutes, pages and pictures apart, for",
        f"{ANTENNAS:,} diagnoses of {like['processor_s']:.2g} s: what",
        f"{like['rows']:,} rows in memory took, an antenna of the largest data set above having",
        f"{points:,.0f} normal points. Each worker needs {like['peak_mb']:.0f} MB. Nothing comes",
        "together in one place but the results, a report and a page an antenna. A worker that",
        "dies loses what it was doing and nothing else: its antenna is given to another, and no",
        "digit of any result changes.",
        "",
        "A single data set of many antennas together (without `--each`) is gone through by all",
        "workers, and its normal points are diagnosed by one process. `dev trials run --cluster`",
        "spreads a campaign of trials in the same way. Without a cluster `--jobs N` does all of it",
        "with processes of one machine.",
    ]  # fmt: skip


def draw(grown: dict[str, Any]) -> None:
    """Draw the growth."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    named = {"rows": "a diagnosis in memory", "data_sets": "a data set, two passes"}
    for kind, label in named.items():
        sizes = [one["rows"] for one in grown[kind]]
        axes[0].loglog(sizes, [one["processor_s"] for one in grown[kind]], "o-", label=label)
        axes[1].loglog(sizes, [one["peak_mb"] for one in grown[kind]], "o-", label=label)
    for axis, unit in zip(axes[:2], ("time of one core [s]", "peak memory [MB]"), strict=True):
        axis.set_xlabel("rows")
        axis.set_ylabel(unit)
    axes[0].legend(fontsize=8)
    columns = [one["columns"] for one in grown["candidates"]]
    axes[2].plot(columns, [one["processor_s"] for one in grown["candidates"]], "o-")
    axes[2].set_xlabel("columns tried, 5,600 rows")
    axes[2].set_ylabel("time of one core [s]")
    axes[2].set_ylim(bottom=0)
    figure.savefig(PICTURE, dpi=110, metadata={"Software": None})
    plt.close(figure)
