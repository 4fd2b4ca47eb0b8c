"""Models compared by what they predict, and what makes one of them an overfit."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.angles import ARCSEC
from pyport.errors import BadInput
from pyport.least_squares.gram import spanned
from pyport.models.model import Model
from pyport.prediction.contenders import Contender, Night, OwnChoice, Picked, Refitted, solved
from pyport.prediction.rehearsal import NIGHTS, Rehearsal, left_out, on_another, on_the_sky, schemes
from pyport.recordings.schema import Recordings, as_input, counted
from pyport.runs.workers import one_thread
from pyport.thresholds import OUTLIER_WEIGHT

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
        for one in verdict(done)
    ]
    return "\n".join([*_table(done), "", *said])


def _table(done: Comparison) -> Iterator[str]:
    aside = f", {done.outliers} of them outliers that count for nobody" if done.outliers else ""
    yield f"{counted(done.input)}, model {done.model.name}"
    yield from map(counted, done.on)
    yield f"{done.file}: {done.pointings} pointings, {done.numbers} offsets{aside}."
    yield (
        "Rms on the sky [arcsec]: in the fit; on pointings, bands of elevation and sectors of "
        "azimuth left out."
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
    if min(ratios.values()) > 1:
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
        "unit": "arcsec",
        "contenders": [dataclasses.asdict(row) for row in done.rows()],
        "cancel": done.cancel,
        "verdict": [one.strip() for one in verdict(done)],
        "rehearsals": [dataclasses.asdict(one) for one in rehearsals],
    }


#: What is left of the readings when some are left out must still determine a model.
KEPT = 0.8
#: With so many offsets for each term picking costs next to nothing, and is not tried.
PLENTY = 100


@dataclass(frozen=True)
class Row:
    """What one contender comes to: rms on the sky [arcsec]."""

    #: `name`, `terms`: who, and of how many coefficients.
    name: str
    terms: float
    fitted: float  #: over the readings that it was fitted to
    unseen: dict[str, float]  #: over readings left out, by the way in which they were
    nights: dict[str, float]  #: over other files' readings, their zero points refitted


@dataclass(frozen=True)
class Comparison:
    """All contenders: the model, its rivals, the model with waves, and terms picked anew.

    `cancel` tells of each rival how large its largest single term is over all that its
    terms beyond the model's come to.
    """

    file: str
    pointings: int
    numbers: int
    outliers: int
    model: Row
    rivals: tuple[Row, ...]
    own: Row
    picked: tuple[Row, ...]
    cancel: dict[str, float]
    #: `input`, `on`: the recordings and those of other nights, as `as_input` says.
    input: dict[str, Any]
    on: tuple[dict[str, Any], ...]

    def rows(self) -> tuple[Row, ...]:
        """Return all in the order of a table."""
        return (self.model, *self.rivals, *self.picked, self.own)


@one_thread
def compare(
    recordings: Recordings,
    model: Model,
    rivals: Sequence[Model] = (),
    others: Sequence[Recordings] = (),
    *,
    seed: int = 0,
    tell: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Compare models by their predictions of readings that they were not fitted to.

    `recordings`, `model`: the measurements, and the model that the choice for prediction starts
      from.
    `rivals`: other models. For each of more terms, where readings are few beside them, there are
      contenders of as many that pick their own: once from all readings, and anew wherever readings
      are left out.
    `others`: recordings of other nights.
    `seed`: of the deal of pointings.
    `tell`: called with a line whenever there is news.
    Raises `BadInput`: there are several antennas, or too few readings for a model.
    """
    stems = [one.file.stem for one in others]
    for one in others:
        if stems.count(one.file.stem) > 1:
            raise BadInput(
                f"two nights are called {one.file.stem}, expected different names", one.file
            )
    night, nights = Night.of(recordings), [Night.of(one) for one in others]
    mount = recordings.at.mount
    first = Refitted(night, model.on(mount))
    others_of = [Refitted(night, one.on(mount)) for one in rivals]
    for each in (first, *others_of):
        if len(night.stack) * KEPT < each.terms + 1:
            raise BadInput(
                f"{len(night.stack)} measured offsets are too few to leave some out beside the "
                f"{each.terms:.0f} coefficients of {each.name}",
                recordings.file,
            )
    more = sorted(
        {
            int(one.terms)
            for one in others_of
            if one.terms > first.terms and len(night.stack) < PLENTY * one.terms
        }
    )
    pickers = [Picked(night, model, count, anew=one) for count in more for one in (False, True)]
    own = OwnChoice(night, model)

    def row(one: Contender) -> Row:
        tell(one.name)
        return _row(one, night, nights, model, seed)

    return Comparison(
        recordings.file.name,
        len(night.pointings[0]),
        len(night.stack),
        int(np.count_nonzero(~_counted(night, model))),
        row(first),
        tuple(row(one) for one in others_of),
        row(own),
        tuple(row(one) for one in pickers),
        {one.name: cancelled(one, first) for one in others_of},
        as_input(recordings),
        tuple(as_input(one) for one in others),
    )


def _row(one: Contender, night: Night, nights: Sequence[Night], model: Model, seed: int) -> Row:
    counted, is_y = _counted(night, model), night.stack.is_y
    fitted = one.residual(np.ones(len(night.stack), bool))
    return Row(
        one.name,
        one.terms,
        on_the_sky(fitted, is_y, counted) / ARCSEC,
        {
            way.name: on_the_sky(left_out(one, way), is_y, counted) / ARCSEC
            for way in schemes(night, seed)
        },
        {
            other.recordings.file.stem: on_the_sky(
                on_another(one, night, other), other.stack.is_y, _counted(other, model)
            )
            / ARCSEC
            for other in nights
        },
    )


def _counted(night: Night, model: Model) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Tell which readings are no outliers beside the model, shape (m,)."""
    everything = np.ones(len(night.stack), bool)
    weight = solved(night.columns(model), night.value(model), night.stack.is_y, everything)[1]
    return np.asarray(weight >= OUTLIER_WEIGHT)


def cancelled(rival: Refitted, model: Refitted) -> float:
    """Return the rms of a rival's largest term over that of what it adds to the model.

    Each is taken with the model projected out; terms that are the model's own add nothing.
    """
    everything = np.ones(len(rival.value), bool)
    values, _ = solved(rival.columns, rival.value, rival.night.stack.is_y, everything)
    terms = rival.columns * values
    basis = spanned(model.columns)[0]
    whole = terms.sum(axis=1)
    added = whole - basis @ (basis.T @ whole)
    single = terms - basis @ (basis.T @ terms)
    return float(
        np.linalg.norm(single, axis=0).max(initial=0.0) / max(np.linalg.norm(added), 1e-300)
    )
