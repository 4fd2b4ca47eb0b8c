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
    for heading in ("work", "against", "promised", "measured", "kept", "last recorded"):
        table.add_column(heading, overflow="fold")
    rows = rows_of(recorded, grown)
    for row in rows:
        then = last[row.group]
        change = "" if then is None or row.value is None else f" ({row.value / then - 1:+.0%})"
        table.add_row(
            row.spec["work"], row.spec["against"], row.promised, row.measured,
            "yes" if row.met else "NO", "" if then is None else f"{then:.3g}{change}",
        )  # fmt: skip
    Console(width=150).print(table)
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
        *(f"- {name}: {what}" for name, what in recorded["machine"].items()),
        "",
        "| work | against | promised | measured | kept |",
        "|---|---|---|---|---|",
        *(
            f"| {row.spec['work']} | {row.spec['against']} | {row.promised} "
            f"| {row.measured} | {'yes' if row.met else '**no**'} |"
            for row in rows
        ),
        "",
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
    """Return how far from the unavoidable the exact model is."""
    told = [row for row in rows if "floor" in row.told]
    if not told:
        return []
    return [
        "## What cannot be avoided",
        "",
        "Two angles come in and two offsets go out, and the geometry of a mount that leans and has",
        "a skewed axis asks for an arctangent of two numbers, an arctangent, an arcsine and a",
        "square root; scattered points also for a tangent of each angle, from which its sine and",
        "cosine follow. Those functions alone, on as many numbers, memory read and written, take:",
        "",
        "| work | these alone [ns a point] | pyport [ns a point] | share |",
        "|---|---|---|---|",
        *(
            f"| {row.spec['work']} | {1e9 * row.told['floor'] / row.told['points']:.1f} "
            f"| {1e9 * row.told['seconds'] / row.told['points']:.1f} "
            f"| {row.told['floor'] / row.told['seconds']:.0%} |"
            for row in told
        ),
        "",
        "The rest are products and sums: numpy makes one pass over a block of points for each,",
        "through the second cache; a compiled loop would make them in registers.",
        "",
    ]


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
    if what != "show":
        if grown is not None:
            growth_page.draw(grown)
        RECORDED.write_text(json.dumps(recorded, indent=1) + "\n")
        PAGE.write_text(page(recorded, grown), encoding="utf-8")


if __name__ == "__main__":
    main()
