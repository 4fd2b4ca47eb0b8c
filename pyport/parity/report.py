"""Say in text, JSON and a summary in Markdown how the ports compare with the Fortran."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from pyport.parity.compare import UNLIKE, Comparison
from pyport.parity.described.description import PROMISE_TEXT, Port
from pyport.parity.described.loading import load
from pyport.parity.promise import bound, tolerance
from pyport.parity.run import Parity, run

#: Distances from here on are shown as powers of ten: two models, no longer two roundings.
LONG = 10**12


def text(parity: Parity) -> str:
    """Return a table a person reads: worst distances by port, routine and output."""
    sizes = ", ".join(f"{number:,} {name}" for name, number in parity.points.items())
    lines = [f"Against {oracle_text(parity)}", f"Points: {sizes}", ""]
    for port in parity.description.ports:
        lines += [f"{port.name}: {PROMISE_TEXT[port.promise]}", *_rows(parity, port), ""]
    lines += footnotes(parity)
    notes = [f"  {one.name}: {one.note}" for one in parity.description.routines if one.note]
    lines += ["Different on purpose:", *notes, ""] if notes else []
    for port in parity.description.ports:
        lines.append(verdict(parity, port))
        if not parity.kept(port):
            lines += [f"  {c}" for c in parity.comparisons(port, "beyond") if c.differing]
    if parity.minimal:
        lines += ["", "Minimal inputs:"]
        lines += [f"  {port}: {one}" for (port, _), one in parity.minimal.items()]
    return "\n".join(lines) + "\n"


def _rows(parity: Parity, port: Port) -> list[str]:
    head, rows = table(parity, port)
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    return [
        "  " + "  ".join(
            cell.ljust(w) if k < 2 else cell.rjust(w)
            for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (head, *rows)
    ]  # fmt: skip


def table(parity: Parity, port: Port) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of a port's table."""
    d = parity.description
    bits = port.promise == "bits"
    head = ["routine", "output", "points", "differing"]
    head += ["worst ulp"] if bits else ["median", "p99", "worst ulp", "distance*", "beyond**", "N"]
    rows = []
    outputs = {(r.name, o.label): o for r in d.routines for o in r.outputs}
    lists = (parity.comparisons(port, what) for what in ("plain", "outside", "beyond"))
    for plain, outside, beyond in zip(*lists, strict=True):
        one = outputs[plain.routine, plain.output]
        row = [plain.routine, plain.output, f"{plain.points:,}", f"{plain.differing:,}"]
        if bits:
            row.append(ulp(plain.most))
        else:
            promised = f"{tolerance(port, one):g}" if port.promise == "within" else bound(port, one)
            row += [ulp(plain.quantile(share)) for share in (0.5, 0.99)]
            row += [ulp(plain.most), f"{outside.physical:.2g} {outside.unit}".rstrip()]
            row += [ulp(beyond.most), str(promised)]
        rows.append(row)
    return head, rows


def footnotes(parity: Parity) -> list[str]:
    """Return what the stars of the tables mean, where there are any."""
    if all(port.promise == "bits" for port in parity.description.ports):
        return []
    return [
        " * worst distance in the output's unit; from here on without what the ledger explains",
        "** worst ulp beyond what the promise allows anyway (the oracle's own spread, a tolerance)",
        "",
    ]


def oracle_text(parity: Parity) -> str:
    """Return which oracle was asked, and what made it."""
    made_by = f"{parity.provenance['compiler']}, {parity.provenance['flags']}"
    if parity.source == "live":
        return f"the compiled oracle ({made_by})"
    return f"the oracle's stored answers ({made_by}; {parity.provenance['libc']})"


def verdict(parity: Parity, port: Port) -> str:
    """Say in one sentence whether a port keeps its promise."""
    blocks = [n for (name, _), n in parity.blocks.items() if name == port.name]
    if port.promise == "bits":
        of = parity.description.title
        if parity.kept(port):
            also = f", at all {max(n for _, n in blocks)} stored digests too" if blocks else ""
            return f"The {port.name} port equals {of} bit for bit{also}."
        differing = sum(c.differing for c in parity.comparisons(port))
        also = f", and {sum(n for n, _ in blocks):,} of the stored digests" if blocks else ""
        return f"The {port.name} port is NOT {of}: {differing:,} answers differ{also}."
    explained = parity.explained(port)
    named = ", ".join(f"{name} {n:,}" for name, n in explained.items())
    ledger = ""
    if parity.description.ledger is not None:
        ledger = f"; the ledger explains {sum(explained.values()):,} answers"
        ledger += f" ({named})" if named else ""
    keeps = "keeps" if parity.kept(port) else "BREAKS"
    return f"The {port.name} port {keeps} its promise{ledger}."


def markdown(parity: Parity) -> str:
    """Return the summary that a continuous integration shows beside its run."""
    lines = [f"### Parity: {parity.description.title}", "", f"Against {oracle_text(parity)}.", ""]
    for port in parity.description.ports:
        mark = "✅" if parity.kept(port) else "❌"
        head, rows = table(parity, port)
        lines += [f"{mark} {verdict(parity, port)}", "", markdown_table(head, rows)]
    lines += [f"- `{one}`" for one in parity.minimal.values()]
    return "\n".join(lines) + "\n"


def markdown_table(heads: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    escaped = [[cell.replace("|", "\\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in escaped)


def as_json(parity: Parity) -> dict[str, Any]:
    """Return the same as plain data."""
    ports = {}
    for port in parity.description.ports:
        lists = {
            what: [_comparison(c) for c in parity.comparisons(port, what)]
            for what in ("plain", "outside", "beyond")
        }
        blocks = [n for (name, _), n in parity.blocks.items() if name == port.name]
        ports[port.name] = {
            "promise": port.promise,
            "kept": parity.kept(port),
            "answers": lists["plain"],
            "outside_ledger": lists["outside"],
            "beyond_promise": lists["beyond"],
            "explained": parity.explained(port),
            "digests_differing": sum(n for n, _ in blocks),
            "minimal": [
                dataclasses.asdict(one)
                for (name, _), one in parity.minimal.items()
                if name == port.name
            ],
        }
    return {
        "schema": "pyport.parity/2",
        "name": parity.description.name,
        "source": parity.source,
        "provenance": parity.provenance,
        "points": parity.points,
        "promise_kept": parity.promise_kept,
        "ports": ports,
    }


def _comparison(comparison: Comparison) -> dict[str, Any]:
    return {
        "routine": comparison.routine,
        "output": comparison.output,
        "points": comparison.points,
        "differing": comparison.differing,
        "median_ulp": comparison.quantile(0.5),
        "p99_ulp": comparison.quantile(0.99),
        "max_ulp": comparison.most,
        "max_distance": comparison.physical,
        "unit": comparison.unit,
        "worst": comparison.worst and dataclasses.asdict(comparison.worst),
    }


def ulp(distance: int) -> str:
    """Return a distance as a cell of a table."""
    if distance == UNLIKE:
        return "unlike"
    return f"{distance:,}" if distance < LONG else f"{distance:.1e}"


def summary(path: Path) -> str:
    """Return the short account of a description's parity that the demonstration prints."""
    return text(run(load(path), 5000))
