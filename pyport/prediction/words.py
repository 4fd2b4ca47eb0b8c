"""What a comparison of models says: the table, the verdict, what was rehearsed."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pyport.prediction.compare import Comparison, Row
from pyport.prediction.rehearsal import NIGHTS, Rehearsal
from pyport.recordings.schema import counted

#: Terms of which one is so many times larger than all of them together cancel each other.
CANCEL = 3.0
#: Held terms that do so many times better than terms picked anew have seen what was left out.
FLATTER = 1.25
#: A model that another night bears out so much better alone has been given more than its due.
ALONE = 0.9
_WIDTH = 96


def text(done: Comparison) -> str:
    """Return the table and the verdict."""
    said = [
        textwrap.fill(one, _WIDTH, subsequent_indent="  ", break_on_hyphens=False)
        for one in (*verdict(done), *(f"Warning: {one}." for one in done.warnings))
    ]
    return "\n".join([*_table(done), "", *said])


def _table(done: Comparison) -> Iterator[str]:
    aside = f", {done.outliers} of them outliers that count for nobody" if done.outliers else ""
    yield f"{counted(done.input)}, model {done.model.name}"
    yield from map(counted, done.on)
    yield f"{done.file}: {done.pointings} pointings, {done.numbers} offsets{aside}."
    yield (
        "Rms on the sky [arcsec]: in the fit; on pointings, bands of elevation and sectors of "
        "azimuth left out. Of a model as it stands nothing is fitted."
    )
    rows = done.rows()
    nights = {night: f"night {n}" for n, night in enumerate(rows[0].nights, 1)}
    for night, short in nights.items():
        yield f"{short.capitalize()}, its zero points refitted: {night}."
    wide = max(len(row.name) for row in rows)
    heads = ["terms", "fit", *(way.split()[0] for way in rows[0].unseen), *nights.values()]
    yield " " * wide + "".join(f"{head:>11}" for head in heads)
    for row in rows:
        figures = [row.fitted, *row.unseen.values(), *row.nights.values()]
        cells = [f"{row.terms:.3g}", *(f"{one:.2f}" for one in figures)]
        yield f"{row.name:{wide}}" + "".join(f"{cell:>11}" for cell in cells)


def verdict(done: Comparison) -> Iterator[str]:
    """Yield what the comparison says of every rival, and of the model with waves."""
    for rival in done.rivals:
        yield from _of_rival(done, rival)
    first = next(iter(done.own.unseen))
    better = "better" if done.own.unseen[first] < done.model.unseen[first] else "no better"
    yield (
        f"The model with waves, chosen without the data that it predicts, is {better} than "
        f"{done.model.name}: {done.own.unseen[first]:.2f} against {done.model.unseen[first]:.2f} "
        f"on {first} left out."
    )
    for night, alone in done.model.nights.items():
        best = min(row.nights[night] for row in (*done.rivals, done.own))
        if alone < ALONE * best:
            yield (
                f"On {night} {done.model.name} does better without what any of them added, "
                f"{alone:.2f} against {best:.2f} or more: that belongs to its own night, and this "
                "one judges none of them."
            )


def _of_rival(done: Comparison, rival: Row) -> Iterator[str]:
    first = next(iter(rival.unseen))
    more = rival.unseen[first] / max(rival.fitted, 1e-9)
    yield (
        f"{rival.name}: {rival.terms:.0f} terms leave {rival.fitted:.2f} in the fit and "
        f"{more:.2f} times as much on {first} left out."
    )
    if done.cancel[rival.name] > CANCEL:
        yield (
            f"  Its largest term is {done.cancel[rival.name]:.1f} times all that its terms add to "
            f"{done.model.name}: they cancel each other."
        )
    like = [row for row in done.picked if row.terms == rival.terms]
    if not like:
        return
    held, anew = like
    if anew.unseen[first] > FLATTER * held.unseen[first]:
        yield (
            f"  If its terms were picked on these readings, that figure has seen what it predicts: "
            f"as many terms, picked automatically, leave {held.unseen[first]:.2f} when they are "
            f"held, and {anew.unseen[first]:.2f} when they are picked without the {first} left out."
        )
    if rival.unseen[first] < done.own.unseen[first]:
        yield (
            f"  Held, its terms leave less on {first} left out than the model with waves, "
            f"{rival.unseen[first]:.2f} against {done.own.unseen[first]:.2f}: whether they know "
            "the telescope or these readings, only readings that they were not picked by can tell."
        )
    ratios = {way: anew.unseen[way] / own for way, own in done.own.unseen.items()}
    # an rms of n numbers is known to 1 / sqrt(2 n) of itself
    error = anew.fitted / np.sqrt(2 * max(done.numbers - done.outliers, 1))
    if min(ratios.values()) > 1 and min(anew.unseen.values()) > anew.fitted + error:
        yield (
            f"  So many picked terms are an overfit here: {anew.fitted:.2f} in the fit, and on "
            f"readings that nothing was chosen by {min(ratios.values()):.2f} to "
            f"{max(ratios.values()):.2f} times what the model with waves leaves."
        )


def of_rehearsals(rehearsals: Sequence[Rehearsal]) -> str:
    """Return a table for each telescope that was rehearsed on."""
    lines = []
    for one in rehearsals:
        wide = max(map(len, one.claimed))
        lines += [
            "",
            f"Rehearsed on {NIGHTS} made nights of a telescope exactly as {one.truth} says:",
            " " * wide + f"{'claimed':>11}{'fresh':>11}",
        ]
        lines += [
            f"{name:{wide}}{claimed:>11.2f}{one.fresh[name]:>11.2f}"
            for name, claimed in one.claimed.items()
        ]
    lines.append("Claimed on pointings left out; fresh ones are where nobody observed.")
    return "\n".join(lines)


def as_json(done: Comparison, rehearsals: Sequence[Rehearsal] = ()) -> dict[str, Any]:
    """Return a comparison, and what was rehearsed, for other programs; rms in arcseconds."""
    return {
        "schema": "pyport.prediction/1",
        "file": done.file,
        "input": done.input,
        "on": list(done.on),
        "pointings": done.pointings,
        "offsets": done.numbers,
        "outliers": done.outliers,
        "warnings": list(done.warnings),
        "unit": "arcsec",
        "contenders": [dataclasses.asdict(row) for row in done.rows()],
        "cancel": done.cancel,
        "verdict": [one.strip() for one in verdict(done)],
        "rehearsals": [dataclasses.asdict(one) for one in rehearsals],
    }
