"""Models compared by what they predict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC
from pyport.errors import BadInput
from pyport.least_squares.gram import spanned
from pyport.models.model import Model
from pyport.noise.outliers import shared
from pyport.prediction.contenders import (
    AsItStands,
    Contender,
    Night,
    OwnChoice,
    Picked,
    Refitted,
    solved,
)
from pyport.prediction.unseen import left_out, on_another, on_the_sky, schemes
from pyport.recordings.schema import Recordings, as_input
from pyport.runs.workers import one_thread
from pyport.thresholds import OUTLIER_WEIGHT

#: What is left of the readings when some are left out must still determine a model.
KEPT = 0.8
#: With so many offsets for each term picking costs next to nothing, and is not tried.
PLENTY = 100
#: [share of a term] What rounding may leave of it beside a model that draws all of it.
ROUNDING = 1e-9


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
    warnings: tuple[str, ...]  #: of outliers that are most of a session, receiver or source
    model: Row
    rivals: tuple[Row, ...]
    standing: tuple[Row, ...]  #: those of them that have coefficients, as they stand
    own: Row
    picked: tuple[Row, ...]
    cancel: dict[str, float]
    #: `input`, `on`: the recordings and those of other nights, as `as_input` says.
    input: dict[str, Any]
    on: tuple[dict[str, Any], ...]

    def rows(self) -> tuple[Row, ...]:
        """Return all in the order of a table."""
        return (self.model, *self.rivals, *self.standing, *self.picked, self.own)


def distinct(models: Sequence[Model], given: Sequence[str]) -> list[Model]:
    """Return models with those of one name called by the files that they were `given` as."""
    files = [Path(one).name for one in given]
    found = []
    for model, file, path in zip(models, files, given, strict=True):
        several = "." in file and [one.name for one in models].count(model.name) > 1
        called = path if files.count(file) > 1 else file
        found.append(replace(model, name=called) if several else model)
    return found


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
    given = [AsItStands(one) for one in (first, *others_of)]
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

    used = _counted(night, model)
    return Comparison(
        recordings.file.name,
        len(night.pointings[0]),
        len(night.stack),
        int(np.count_nonzero(~used)),
        tuple(shared(recordings, night.stack, used)),
        row(first),
        tuple(row(one) for one in others_of),
        tuple(row(one) for one in given if one.has_coefficients),
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
    single = np.linalg.norm(terms - basis @ (basis.T @ terms), axis=0)
    # What rounding leaves of the model's own terms is none of them.
    single = single[single > ROUNDING * np.linalg.norm(terms, axis=0)]
    return float(single.max(initial=0.0) / max(np.linalg.norm(added), 1e-300))
