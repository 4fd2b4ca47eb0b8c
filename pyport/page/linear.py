"""What the page needs to fit a model's linear terms again, and the model as a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.effects.fields import UNKNOWN
from pyport.errors import BadInput
from pyport.models import toml
from pyport.models.model import Model, Term
from pyport.models.words import label
from pyport.recordings.schema import Recordings
from pyport.toml_text import spelled

#: More coefficients than these are no table to switch them in, and too long for a page.
MOST_COEFFICIENTS = 40
#: A model's file of more characters than this would be most of the page.
LARGEST_FILE = 150_000


@dataclass(frozen=True)
class Linear:
    """A completed model's coefficients and what one unit of each adds to n recordings."""

    #: `names`, `labels`: the coefficient, and the same with the antenna or session that it holds
    #: for.
    names: tuple[str, ...]
    labels: tuple[str, ...]
    #: `units`, `values`: as the model's file has them.
    units: tuple[str, ...]
    values: tuple[float, ...]
    free: tuple[bool, ...]  #: whether it was fitted
    #: `x`, `y`: offsets of one unit [rad], shape (P, n) each.
    x: Array
    y: Array


def linear(model: Model, recordings: Recordings) -> Linear | None:
    """Return what can be fitted again of a completed model, None for nothing or for too much."""
    if model.completed is None or not model.completed.values:
        return None
    columns = list(_columns(model, recordings))
    kept = [
        (one, x, y)
        for one, (x, y) in zip(model.completed.values, columns, strict=True)
        if one.effect != UNKNOWN
    ]
    if not 0 < len(kept) <= MOST_COEFFICIENTS:
        return None
    values = [one for one, _, _ in kept]
    return Linear(
        tuple(one.name for one in values),
        tuple(map(label, values)),
        tuple(one.unit for one in values),
        tuple(one.value for one in values),
        tuple(one.sigma is not None for one in values),
        np.stack([x for _, x, _ in kept]),
        np.stack([y for _, _, y in kept]),
    )


def as_file(model: Model) -> str | None:
    """Return the text of the model's file, None where none can hold it or it is too long."""
    try:
        text = spelled(toml.tree(model))
    except BadInput:
        return None
    return text if len(text) <= LARGEST_FILE else None


def _columns(model: Model, recordings: Recordings) -> Iterator[tuple[Array, Array]]:
    """Yield what one unit of each coefficient adds, in the order of a completed model's values."""
    for term in model.terms:
        x, y = term.effect.columns(recordings.at)
        for labels in term.by or {(): ()}:
            there = _rows(term, labels, recordings)
            for n, coefficient in enumerate(term.effect.coefficients):
                yield x[:, n] * there * coefficient.scale, y[:, n] * there * coefficient.scale


def _rows(term: Term, labels: tuple[str, ...], recordings: Recordings) -> Array:
    """Return 1 for the recordings that a set of labels is of, shape (n,)."""
    there = np.ones(len(recordings), bool)
    for name, value in zip(term.per, labels, strict=False):
        there &= recordings.label(name).astype(str) == value
    return there.astype(float)
