"""The table of `pyport dev real`, as text and as Markdown, with what passes and what does not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from pyport.examiner import program, scores
from pyport.examiner.real import sets
from pyport.examiner.real.measures import Row, measure
from pyport.examiner.real.published import Check


def chosen(names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the sets whose names begin with one of some, all for none.

    Raises `KeyError`: no set's name begins so.
    """
    entries = sets.catalogue()
    for name in names:
        if not any(one["name"].lower().startswith(name.lower()) for one in entries):
            raise KeyError(name)
    begins = tuple(name.lower() for name in names) or ("",)
    return [one for one in entries if one["name"].lower().startswith(begins)]


def rows(
    entries: list[dict[str, Any]], data: Path | None, subsets: int, file: Path, jobs: int = 1
) -> Iterator[Row | str]:
    """Yield what came out of each set, or why it could not be examined.

    Every row is appended to the file as soon as it is there, and what the file has of the present
    program is not done again: a run that was stopped goes on.
    """
    kept = read(file, subsets)
    rest = [one for one in entries if one["name"] not in kept]
    yield from (kept[one["name"]] for one in entries if one["name"] in kept)
    call = partial(_row, data=data, subsets=subsets)
    for row in scores.each(call, rest, jobs):
        if isinstance(row, Row):
            line = {"program": program.version(), "subsets": subsets, "row": asdict(row)}
            scores.keep(file, line)
        yield row


def read(file: Path, subsets: int) -> dict[str, Row]:
    """Return the rows that a file has of the present program and as many subsets."""
    return {
        line["row"]["name"]: _row_of(line["row"])
        for line in scores.lines(file)
        if (line["program"], line["subsets"]) == (program.version(), subsets)
    }


def _row_of(line: dict[str, Any]) -> Row:
    lists: dict[str, Any] = {
        key: tuple(one) if isinstance(one, list) else one for key, one in line.items()
    }
    lists["checks"] = tuple(Check(**one) for one in line["checks"])
    return Row(**lists)


def _row(entry: dict[str, Any], data: Path | None, subsets: int) -> Row | str:
    recordings = sets.read(entry, data)
    if isinstance(recordings, str):
        return f"{entry['name']}: {recordings}"
    return measure(recordings, subsets)


#: Scatter of `fit` over Huber's, in the fit and cross-validated; rms z; agreement.
IN_FIT, ACROSS, RMS_Z, AGREEMENT = 1.10, 1.02, (0.8, 1.3), 0.80


def _ratio(plain: float, clipped: float, sigma: float | None = None) -> str:
    error = "" if sigma is None else f" +- {sigma:.3f}"
    return "-" if math.isnan(plain) else f"{plain:.3f}{error} ({clipped:.3f})"


def _rms_z(row: Row) -> str:
    return "-" if math.isnan(row.rms_z) else f"{row.rms_z:.2f} +- {row.rms_z_sigma:.2f}"


def _total(row: Row) -> str:
    return "-" if row.total is None else f"{row.total[0]:.2f} to {row.total[1]:.2f}"


#: Column -> its cell.
COLUMNS: dict[str, Callable[[Row], str]] = {
    "set": lambda row: row.name,
    "rows": lambda row: str(row.rows),
    "nights": lambda row: str(row.nights),
    "in fit": lambda row: _ratio(row.in_fit, row.in_fit_clipped),
    "held out": lambda row: _ratio(row.across, row.across_clipped, row.across_sigma),
    "left out": lambda row: row.scheme or "-",
    "rms z": _rms_z,
    "findings": lambda row: str(len(row.findings)),
    "worse": lambda row: str(row.worse),
    "total, arcsec": _total,
    "unstable": lambda row: str(row.unstable),
    "halves agree": lambda row: "-" if not row.agreement else "{} of {}".format(*row.agreement),
    "few, worse": lambda row: f"{row.few_worse} of {row.few}" if row.few else "-",
}


def failures(row: Row) -> list[str]:
    """Return the targets that a set misses, in words."""
    found = [
        (row.in_fit > IN_FIT, f"in the fit {row.in_fit:.3f} of Huber's scatter"),
        (
            row.across > ACROSS,
            f"held out {row.across:.3f} +- {row.across_sigma:.3f} of Huber's scatter",
        ),
        (_outside(row.rms_z), f"rms z {_rms_z(row)}"),
        (row.worse > 0, f"{row.worse} findings predict worse"),
        (_grows(row.total), f"held out {_total(row)} arcsec"),
        (row.unstable > 0, f"{row.unstable} named findings are not stable"),
        (_apart(row.agreement), f"halves agree in {COLUMNS['halves agree'](row)} names"),
        (row.below_rounding > 0, f"{row.below_rounding} sigmas below the rounding"),
        (row.few_worse > 0, f"{row.few_worse} of {row.few} subsets predict worse"),
        (row.few_refused > 0, f"{row.few_refused} of {row.few} subsets have no answer"),
        (math.isnan(row.in_fit), "not examined"),
    ]
    missed = [words for wrong, words in found if wrong]
    return missed + [f"{one.says}: {one.found}" for one in row.checks if not one.passed]


def _outside(z: float) -> bool:
    return not math.isnan(z) and not RMS_Z[0] <= z <= RMS_Z[1]


def _grows(total: tuple[float, float] | None) -> bool:
    return total is not None and total[1] > total[0] * (1 + 1e-9)


def _apart(agreement: tuple[int, int] | None) -> bool:
    return bool(agreement and agreement[1] and agreement[0] / agreement[1] < AGREEMENT)


def of_set(row: Row) -> str:
    """Return what was found in one set, and what was published beside what came out."""
    lines = [row.name]
    lines += [f"  found: {one}" for one in row.findings]
    lines += [f"  note: {one}" for one in row.notes]
    lines += [f"  {'yes' if one.passed else 'NO'}: {one.says}: {one.found}" for one in row.checks]
    return "\n".join(lines)


def text(rows: Sequence[Row], absent: Sequence[str]) -> str:
    """Return the table for a terminal."""
    cells = [list(COLUMNS), *([cell(row) for cell in COLUMNS.values()] for row in rows)]
    widths = [max(len(line[n]) for line in cells) for n in range(len(COLUMNS))]
    lines = [
        "  ".join(f"{cell:{width}s}" for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in cells
    ]
    missed = {row.name: failures(row) for row in rows}
    lines += ["", *(f"not there: {one}" for one in absent)]
    count = sum(bool(one) for one in missed.values())
    lines.append(f"{len(rows) - count} of {len(rows)} sets meet every target")
    for name, some in missed.items():
        lines += [f"missed in {name}: {one}" for one in some]
    return "\n".join(lines)


def markdown(rows: Sequence[Row], absent: Sequence[str]) -> str:
    """Return the page of the table."""
    lines = [
        "# Recordings of real telescopes",
        "",
        "Written by `make real`. Scatter is that of `fit` over Huber least squares of the same",
        "terms, plain and, in brackets, with residuals cut off at three sigmas: in the fit, and of",
        "what was left out of it (nights, or blocks of time where there is one), +- its scatter",
        "among pointings drawn with replacement. rms z is that of coefficients between halves of",
        "the nights, +- what it scatters by where all sigmas are right: coefficients that go",
        "together are few independent numbers. Targets: at most",
        f"{IN_FIT} and {ACROSS}; rms z {RMS_Z[0]} to {RMS_Z[1]}; no finding and no total that",
        f"predicts worse; halves agree in {AGREEMENT:.0%} of names.",
        "",
        "| " + " | ".join(COLUMNS) + " |",
        "|" + " --- |" * len(COLUMNS),
    ]
    lines += ["| " + " | ".join(cell(row) for cell in COLUMNS.values()) + " |" for row in rows]
    lines += ["", "## What was published, and what came out", "", "| set | published | found | |"]
    lines.append("| --- | --- | --- | --- |")
    for row in rows:
        for one in row.checks:
            cells = (row.name, one.says, one.found, "yes" if one.passed else "**no**")
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    lines += ["", "## Findings", ""]
    for row in rows:
        found = "; ".join((*row.findings, *row.notes)) or "none"
        lines.append(f"- {row.name}: {found}")
    lines += [f"- not there: {one}" for one in absent]
    missed = [(row.name, one) for row in rows for one in failures(row)]
    lines += ["", "## Targets missed", ""]
    lines += [f"- {name}: {one}" for name, one in missed] or ["None."]
    return "\n".join([*lines, ""])
