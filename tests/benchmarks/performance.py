"""What was measured, against what was promised: a table on the terminal and `docs/performance.md`.

python performance.py show RUN.json       print the table, beside the last recorded run
python performance.py record RUN.json     print it, record the run and write the page
python performance.py page                write the page from what is recorded
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import growth_page
from promises import ROOT, Row, condensed, rows_of, with_profiles

PAGE = ROOT / "docs" / "performance.md"
RECORDED = ROOT / "docs" / "performance.json"


def show(recorded: dict[str, Any], before: dict[str, Any], grown: dict[str, Any] | None) -> None:
    """Print the table, and for what is not kept where its time goes."""
    from rich.console import Console
    from rich.table import Table

    last = {row.group: row.value for row in rows_of(before, grown)}
    table = Table(title="what was promised and what was measured")
    headings = "work", "against", "promised", "measured", "limit", "by numpy", "kept", "recorded"
    for heading in headings:
        table.add_column(heading, overflow="fold")
    rows = rows_of(recorded, grown)
    for name, what in recorded["machine"].items():
        sys.stdout.write(f"{name}: {what}\n")
    for row in rows:
        then = last[row.group]
        change = "" if then is None or row.value is None else f" ({row.value / then - 1:+.0%})"
        table.add_row(
            row.spec["work"], row.spec["against"], row.promised, row.measured,
            shared(row), row.without, kept(row).strip("*").upper(),
            "" if then is None else f"{then:.3g}{change}",
        )  # fmt: skip
    Console(width=170).print(table)
    for row in rows:
        if "profile" in row.told:
            sys.stdout.write(f"\n{row.spec['work']}: {row.spec['limit']}\n")
            sys.stdout.writelines(f"  {line}\n" for line in row.told["profile"])


def page(recorded: dict[str, Any], grown: dict[str, Any] | None) -> str:
    """Return the page."""
    rows = rows_of(recorded, grown)
    lines = [
        "# Performance",
        "",
        "`make bench` measures every row below beside what one would take instead, in turn, and",
        "prints the table; `make bench-record` also records the run and writes this page. Each",
        "number is the least of several rounds, the grid three times in each.",
        "",
        "The compiled kernel, `pyport-pointing-kernel`, is optional: `make wheel` builds its",
        "wheel, `pip install pyport/pointing/kernel_src` installs it where there is a C compiler.",
        "It holds loops for AVX-512, AVX2 and SSE2, or NEON, and takes the best that the processor",
        "has; `PYPORT_KERNEL=off` leaves it out. Its functions are within 2.5 units of the last",
        "place of fifty digits, its offsets within 2e-15 rad over cos(altitude) of numpy's.",
        "",
        *(f"- {name}: {what}" for name, what in recorded["machine"].items()),
        "",
        "| work | against | promised | measured | of the limit | by numpy | kept |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| {row.spec['work']} | {row.spec['against']} | {row.promised} "
            f"| {row.measured} | {shared(row)} | {row.without} | {kept(row)} |"
            for row in rows
        ),
        "",
        "*By numpy* is the same without the compiled kernel, in the same run. The limit is what",
        "cannot be avoided, counted and then done alone, below.",
        "",
        *elsewhere(recorded),
        "## In seconds",
        "",
        "| work | pyport | its peers |",
        "|---|---|---|",
        *(f"| {row.spec['work']} | {row.told['seconds']:.4g} | {peers(row)} |"
          for row in rows if row.told),
        *(f"| {group}: {name} | {seconds:.4g} | |"
          for group, members in recorded["others"].items() for name, seconds in members.items()),
        "",
        *limits(rows),
        *stages(rows),
        *missed(rows),
        *growth_page.lines(grown, rows),
    ]  # fmt: skip
    return "\n".join(lines).rstrip() + "\n"


def peers(row: Row) -> str:
    """Return the seconds of all peers."""
    return ", ".join(f"{seconds:.4g} ({who})" for who, seconds in row.told["peers"].items())


def limits(rows: list[Row]) -> list[str]:
    """Return how far from the unavoidable each row is."""
    told = [row for row in rows if row.share is not None]
    if not told:
        return []
    return [
        "## What cannot be avoided",
        "",
        "Counted, then done alone on as many numbers in the same run, functions by the path that",
        "computes, memory read and written:",
        "",
        "| work | counted | these alone [s] | pyport [s] | share |",
        "|---|---|---|---|---|",
        *(
            f"| {row.spec['work']} | {row.told['limit']} | {row.told['limit_s']:.4g} "
            f"| {row.told['seconds']:.4g} | {row.share:.0%} |"
            for row in told
        ),
        "",
    ]


def kept(row: Row) -> str:
    """Return whether a promise was kept, blank where it was not measured."""
    return "" if row.value is None else "yes" if row.met else "**no**"


def shared(row: Row) -> str:
    """Return the limit's share in words."""
    return "" if row.share is None else f"{row.share:.0%}"


def elsewhere(recorded: dict[str, Any]) -> list[str]:
    """Return what was measured on other processors, or without the newest instructions."""
    others = recorded.get("elsewhere", [])
    if not others:
        told = "No other kind of processor was at hand: the ratios above may hold on this one only."
        return [told, ""]
    lines = [
        "## On other processors, and without the newest instructions",
        "",
        "`PYPORT_KERNEL=AVX2 NPY_DISABLE_CPU_FEATURES='X86_V4 AVX512_ICL' make bench-record` holds",
        "a processor to what an older one has; the last run of each kind is kept here, with the",
        "program of its day. What was measured above holds for its processor alone.",
        "",
    ]
    for one in others:
        how = one["machine"].get("computed with", "numpy, before there was a kernel")
        lines += [f"{one['machine']['processor']}; {one['machine']['numpy']}; {how}:", ""]
        lines += ["| work | measured |", "|---|---|"]
        lines += [
            f"| {row.spec['work']} | {row.measured} |" for row in rows_of(one, None) if row.told
        ]
        lines.append("")
    return lines


def with_elsewhere(recorded: dict[str, Any], before: dict[str, Any]) -> dict[str, Any]:
    """Return a run with the last ones of each other way to compute, without their profiles."""
    others = [*before.get("elsewhere", []), {key: before[key] for key in ("machine", "rows")}]
    here = way(recorded["machine"])
    kept = {way(one["machine"]): one for one in others}
    slim = [
        {
            "machine": one["machine"],
            "rows": {group: _slim(told) for group, told in one["rows"].items()},
        }
        for how, one in kept.items()
        if how != here
    ]
    return recorded | {"elsewhere": slim}


def way(machine: dict[str, str]) -> tuple[str, str]:
    """Return a processor and the instructions that its run had."""
    return machine.get("processor", ""), machine.get("computed with", "")


def _slim(told: dict[str, Any]) -> dict[str, Any]:
    """Return what a row's value follows from."""
    needed = "seconds", "peers", "rows", "processor_s", "peak_mb"
    return {key: told[key] for key in needed if key in told}


def stages(rows: list[Row]) -> list[str]:
    """Return how long each stage of a diagnosis takes."""
    lines: list[str] = []
    for row in rows:
        if "stages" in row.told:
            taken = sorted(row.told["stages"].items(), key=lambda one: -one[1])
            lines += [f"## Stages of: {row.spec['work']}", ""]
            lines += [f"- {name}: {seconds:.2f} s" for name, seconds in taken]
            lines.append("")
    return lines


def missed(rows: list[Row]) -> list[str]:
    """Return what was not kept, the profile that shows why, and what it would need."""
    lines: list[str] = []
    for row in rows:
        if row.told and not row.met:
            lines += [f"**{row.spec['work']}**: {row.measured}. {row.spec.get('limit', '')}", ""]
            lines += [f"- {line}" for line in row.told.get("profile", [])]
            lines.append("")
    return ["## What is not kept, why, and what it would need", "", *lines] if lines else []


def loaded(path: Path, otherwise: Any) -> Any:
    """Return a JSON file's contents."""
    return json.loads(path.read_text()) if path.exists() else otherwise


def main() -> None:
    """Do what the command line says."""
    what, *run = sys.argv[1:]
    before = loaded(RECORDED, {"machine": {}, "rows": {}, "others": {}})
    grown = loaded(growth_page.GROWN, None)
    if what == "page":
        recorded = before
    else:
        recorded = with_profiles(condensed(json.loads(Path(run[0]).read_text())))
        show(recorded, before, grown)
    if what == "record":
        recorded = with_elsewhere(recorded, before)
    if what != "show":
        if grown is not None:
            growth_page.draw(grown)
        RECORDED.write_text(json.dumps(recorded, indent=1) + "\n")
        PAGE.write_text(page(recorded, grown), encoding="utf-8")


if __name__ == "__main__":
    main()
