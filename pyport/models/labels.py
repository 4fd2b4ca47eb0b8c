"""Labels that terms have coefficients for: receivers, bands, antennas; others are refused.

A night of its own has no coefficients, and needs none; a receiver or an antenna that the model
does not know points somewhere else, and nobody knows where.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.columns import LABELS
from pyport.effects import Effect
from pyport.effects.telescope.receiver import band_of
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.models.conditions import Completed

#: So many labels are listed.
MOST_LISTED = 12
_FREQUENCY = "frequency_mhz"


def split_of(effect: Effect) -> tuple[str, tuple[str, ...]]:
    """Return the label whose values an effect itself distinguishes, and those; "" for none."""
    member = effect.member
    return (str(member["by"]), tuple(member["values"])) if "by" in member else ("", ())


def refuse_unknown(effect: Effect, columns: Mapping[str, Any]) -> None:
    """Refuse labels that an effect has no coefficients for; blank ones say nothing, and count zero.

    `columns`: by the names inside the program, scalars or arrays.
    Raises `BadInput`: with the labels that it has them for.
    """
    found = first_unknown(effect, columns)
    if found is not None:
        raise BadInput(found[1])


def first_unknown(effect: Effect, columns: Mapping[str, Any]) -> tuple[int, str] | None:
    """Return the first row that `refuse_unknown` refuses, and why; None where it refuses none."""
    by, values = split_of(effect)
    if not by or by not in columns:
        return None
    labels = np.atleast_1d(np.asarray(columns[by]))
    if by == _FREQUENCY:
        labels = labels.astype(float)
        starts = np.array(effect.member["starts_mhz"])
        strange = np.isfinite(labels) & (band_of(labels, starts) == "")
    else:
        strange = ~np.isin(labels.astype(str), [*values, ""])
    if not strange.any():
        return None
    row = int(np.argmax(strange))
    return row, (
        f"the model's term {effect.id} has no coefficients for {by} {str(labels[row])!r}: "
        f"it has them for {', '.join(sorted(values)[:MOST_LISTED])}"
    )


def taken_for(completed: Completed | None, columns: Mapping[str, Any]) -> Iterator[str]:
    """Yield of each label that coefficients of a single other one are taken for it.

    A model of one antenna holds wherever it is asked; that it is another's is said.
    """
    values = () if completed is None else completed.values
    for name in sorted(LABELS - {"session"}):
        known = {one.labels[name] for one in values if name in one.labels}
        labels = np.unique(np.asarray(columns.get(name, "")).astype(str))
        others = [one for one in labels.tolist() if one and one not in known]
        if len(known) == 1 and others:
            listed = ", ".join(others[:MOST_LISTED])
            yield f"the coefficients are those of {name} {next(iter(known))}, taken for {listed}"
