"""Case studies: what a page says of some sets, from the table of real recordings; and a picture.

A page has blocks between `<!-- real: SET, SET -->` and `<!-- end of real -->`: what docs/real.md
has of the sets whose names begin so. No number is typed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.examiner import program
from pyport.examiner.real import measures, sets
from pyport.examiner.real.sets import Recordings
from pyport.examiner.scores import Array
from pyport.files import write_whole

_BLOCK = re.compile(r"(<!-- real: ([^>]*) -->\n).*?(<!-- end of real -->)", re.DOTALL)
_AXES = ("across", "along elevation")


def filled(page: str, real: str) -> str:
    """Return a page with its blocks written anew.

    `page`: its text.
    `real`: the text of docs/real.md, as `pyport dev real` writes it.
    Raises `BadInput`: the table has no set of a block's.
    """

    def block(match: re.Match[str]) -> str:
        names = [one.strip() for one in match[2].split(",")]
        return match[1] + "\n".join(_of_sets(names, real)) + match[3]

    return _BLOCK.sub(block, page)


def _of_sets(names: Sequence[str], real: str) -> list[str]:
    """Return rows, published facts and findings of some sets."""
    lines = real.splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")]
    starts = tuple(f"- {name}" for name in names)
    chosen = [cells for cells in rows if cells[0].startswith(tuple(names))]
    if not chosen:
        raise BadInput(f"the table of real recordings has no set {', '.join(names)}")
    head = next(cells for cells in rows if cells[0] == "set" and "total, arcsec" in cells)
    totals = ["| set | pointings | nights | predicted, rms before and after |", "|---|---|---|---|"]
    facts = ["", "| set | published | found | |", "|---|---|---|---|"]
    for cells in chosen:
        if len(cells) == len(head):
            own = dict(zip(head, cells, strict=True))
            total = f"{own['total, arcsec']} arcsec"
            totals.append(f"| {own['set']} | {own['rows']} | {own['nights']} | {total} |")
        else:
            facts.append(f"| {' | '.join(cells)} |")
    begin = lines.index("## Findings") + 2
    findings = [line for line in lines[begin : lines.index("", begin)] if line.startswith(starts)]
    return [*totals, *(facts if len(facts) > 3 else []), "", "What the tool found:", "",
            *findings, ""]  # fmt: skip


#: Study -> the sets that are drawn, what is across, and what is marked there with its words.
PICTURES: dict[str, tuple[tuple[str, ...], str, tuple[str, str] | None]] = {
    "iram": (("IRAM 2015-03",), "time", ("2015-03-01T12:00", "dampers softened")),
    "mmt": (("MMT together",), "elevation", None),
    "lmt": (("LMT 2014-10",), "elevation", None),
    "auxtel": (("AuxTel 2020-03-14", "AuxTel 2022-04-06"), "elevation", None),
    "rts2": (("RTS2 2016",), "azimuth", None),
}


def draw(study: str, data: Path, out: Path) -> str:
    """Draw what the fitted model leaves of a study's sets; return what was done, in words.

    `study`: one of `PICTURES`.
    `data`: the folder of public recordings.
    """
    from matplotlib.figure import Figure

    names, along, mark = PICTURES[study]
    entries = {one["name"]: one for one in sets.catalogue()}
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True)
    for name in names:
        found = sets.read(entries[name], data)
        if isinstance(found, str):
            return f"{study}: {found}"
        _points(axes, found, _left(found), along)
    for number, one in enumerate(axes):
        one.axhline(0, color="#8a97a3", lw=0.8)
        one.set_ylabel(f"{_AXES[number]} [arcsec]")
        if mark:
            one.axvline(np.datetime64(mark[0]), color="#c2571a", lw=1.2, label=mark[1])
    unit = "" if along == "time" else " [deg]"
    axes[1].set_xlabel("time (UTC)" if along == "time" else f"{along}{unit}")
    axes[0].set_title(f"what the classical terms leave, {' and '.join(names)}", fontsize=10)
    axes[0].legend(fontsize=7, ncols=3)
    if along == "time":
        figure.autofmt_xdate()
    with write_whole(out, "wb") as file:
        figure.savefig(file, dpi=110, metadata={"Software": None})
    return f"{study}: {out}"


def _left(recordings: Recordings) -> Array:
    """Return what the program's fit of the classical terms leaves [arcsec], shape (n, 2)."""
    fit = program.fitted(recordings.table, recordings.header, recordings.model)
    if isinstance(fit, program.Refused):
        raise BadInput(f"{recordings.name} cannot be fitted: {fit.why}")
    values = measures.coefficients(recordings, fit)[""]
    left: Array = recordings.offsets() - recordings.columns() @ values
    return left


def _points(axes: Any, recordings: Recordings, left: Array, along: str) -> None:  # noqa: ANN401
    """Draw the residuals of both axes, a colour for each night where there are a few."""
    across: Any = {
        "elevation": np.degrees(recordings.el),
        "azimuth": np.degrees(recordings.az) % 360,
    }.get(along)
    if across is None:
        stamps = np.char.rstrip(recordings.table["time_utc"].astype(str), "Z")
        across = stamps.astype("datetime64[s]")
    nights = np.unique(recordings.night)
    few = 1 < len(nights) <= 6 and along != "time"
    for night in nights if few else [None]:
        own = recordings.night == night if few else np.ones(len(left), bool)
        for number, one in enumerate(axes):
            label = str(night) if few else recordings.name
            one.plot(across[own], left[own, number], ".", ms=4, label=label)
