"""A field without a name as waves that another program has names for: the fewest that hold it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.effects import Circumstances, MissingColumn
from pyport.formats.model_file import NAMES, WORDS
from pyport.models.model import Term
from pyport.models.terms.shapes import Shape, Wave, product

#: What waves may miss of the fields, in rms of what the model left of its recordings. The rms
#: that the file leaves is then larger by a twelfth at most: sqrt(1 + 0.4^2) = 1.077.
MOST_LOST = 0.4
#: Waves of azimuth, and of elevation, go up to so many in a turn: TPOINT's go no further.
MOST_TURNS = 9
#: Waves of elevation are alike on the quarter of a turn that a mount has: what is smaller than
#: this beside the strongest of them is not solved for, or two waves cancel each other.
DISTINCT = 1e-2
#: Kinds of fields that waves of one angle can hold, or a product of two.
KINDS = frozenset({"azimuth", "elevation"})


@dataclass(frozen=True)
class Waves:
    """Names in a program's vocabulary with values [rad], and what they miss of the fields.

    `missed_arcsec` is an rms over the sky.
    """

    values: tuple[tuple[str, float], ...] = ()
    missed_arcsec: float = 0.0

    @property
    def words(self) -> str:
        """Return it as a sentence, "" for none."""
        if not self.values:
            return ""
        names = ", ".join(name for name, _ in self.values)
        missed = f"they miss {self.missed_arcsec:.2g} arcsec rms over the sky"
        return f"fields without a name as {names}: {missed}"


def waves(
    fields: Sequence[Term], vocabulary: str, scatter_arcsec: float, at: Circumstances
) -> Waves | None:
    """Return the fewest waves of a vocabulary that hold fields without a name, None without them.

    Each wave that is added takes most off what is left, all fitted again (orthogonal matching
    pursuit: Pati, Rezaiifar & Krishnaprasad 1993).

    Parameters
    ----------
    fields
        Terms with values that follow azimuth or elevation.
    vocabulary
        One of `NAMES`.
    scatter_arcsec
        What the model leaves of its recordings.
    at
        Directions all over the sky, shape (n,), each weighted by its area.
    """
    if any(term.effect.member["bumps"]["kind"] not in KINDS for term in fields):
        return None
    try:
        both = [term.effect.columns(at) for term in fields]
    except MissingColumn:
        return None
    values = [np.asarray(term.given(next(iter(term.by), ()))) for term in fields]
    root = np.sqrt(np.cos(at.el) / np.cos(at.el).sum())
    wanted = np.concatenate(
        [sum(pair[axis] @ one for pair, one in zip(both, values, strict=True)) for axis in (0, 1)]
    ) * np.tile(root, 2)
    known = {name: WORDS[vocabulary](name) for name in _names(vocabulary)}
    columns = {name: word.columns(at) for name, word in known.items() if word is not None}
    names = list(columns)
    matrix = np.stack([np.concatenate(columns[name]) * np.tile(root, 2) for name in names], axis=1)
    chosen, sizes, left = _pursued(matrix, wanted, MOST_LOST * scatter_arcsec * ARCSEC)
    missed = float(np.linalg.norm(left)) / ARCSEC
    if missed > MOST_LOST * scatter_arcsec:
        return None
    return Waves(tuple((names[n], float(v)) for n, v in zip(chosen, sizes, strict=True)), missed)


def _pursued(matrix: Array, wanted: Array, allowed: float) -> tuple[list[int], Array, Array]:
    """Return columns, how many of each, and what they leave, down to a length that is allowed."""
    unit = matrix / np.linalg.norm(matrix, axis=0)
    chosen: list[int] = []
    sizes, left = np.zeros(0), wanted
    while np.linalg.norm(left) > allowed and len(chosen) < matrix.shape[1]:
        gain = np.abs(unit.T @ left)
        gain[chosen] = 0.0
        chosen.append(int(np.argmax(gain)))
        sizes = np.linalg.lstsq(unit[:, chosen], wanted, rcond=DISTINCT)[0]
        left = wanted - unit[:, chosen] @ sizes
    return chosen, sizes / np.linalg.norm(matrix[:, chosen], axis=0), left


def _names(vocabulary: str) -> list[str]:
    """Return a vocabulary's waves of one angle, and its zeros of both axes."""
    shapes = [Shape("collimation"), Shape("elevation_zero")]
    turns = range(1, MOST_TURNS + 1)
    for axis in ("xel", "az", "el"):
        for of in "AE" if axis != "az" else "A":
            shapes += [product(axis, Wave(one, of, k)) for k in turns for one in "SC"]
    found = [NAMES[vocabulary](shape) for shape in shapes]
    return list(dict.fromkeys(one[0] for one in found if one is not None))
