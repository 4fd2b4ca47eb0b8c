"""What another program's file cannot hold of a model: its size, and a grid of corrections."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.effects import Circumstances, MissingColumn
from pyport.effects.empirical.fields import Bumps
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.model_file import NAMES, WORDS, ModelFile
from pyport.models.conditions import columns_of
from pyport.models.model import INSIDE, Model, Term
from pyport.models.terms.shapes import Shape, Wave, product

#: What waves may miss of the fields, in rms of what the model left of its recordings. The rms
#: that the file leaves is then larger by a twelfth at most: sqrt(1 + 0.4^2) = 1.077.
MOST_LOST = 0.4
#: Waves of azimuth, and of elevation, go up to so many in a turn: TPOINT's go no further.
MOST_TURNS = 9
#: Waves of elevation are alike on the quarter of a turn that a mount has: what is smaller than
#: this beside the strongest of them is not solved for, or two waves cancel each other.
DISTINCT = 1e-2
#: What a sum of terms may be: tilts, and sines and cosines of elevation in either axis.
SUMMED = (
    *map(Shape, ("azimuth_zero", "collimation", "skew")),
    *map(Shape, ("elevation_zero", "sag_cosine", "sag_sine")),
    *(Shape("tilt", column) for column in (0, 1)),
)
#: Of the largest offset: what a sum may miss, by rounding.
EXACT = 1e-9
#: What a model file says itself, which is no condition.
_OF_SITE = frozenset({"latitude_deg", "longitude_deg"})
#: Kinds of fields that waves of one angle can hold, or products of two.
KINDS = frozenset({"azimuth", "elevation", "curve", "wave", "waves"})


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
        names = ", ".join(dict.fromkeys(name for name, _ in self.values))
        missed = f"they miss {self.missed_arcsec:.2g} arcsec rms over the sky"
        return f"what has no name as {names}: {missed}"


def waves(
    fields: Sequence[Term], vocabulary: str, scatter_arcsec: float, at: Circumstances
) -> Waves | None:
    """Return the fewest waves of a vocabulary that hold fields without a name, None without them.

    Each wave that is added takes most off what is left, all fitted again (orthogonal matching
    pursuit: Pati, Rezaiifar & Krishnaprasad 1993).

    `fields`: terms with values; those that follow more than azimuth and elevation have no waves.
    `vocabulary`: one of `NAMES`.
    `scatter_arcsec`: what the model leaves of its recordings.
    `at`: directions all over the sky, shape (n,), each weighted by its area.
    """
    bumps = [one.effect.member["bumps"] for one in fields if "bumps" in one.effect.member]
    if not fields:
        return Waves()
    if any(one["kind"] not in KINDS for one in bumps):
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
    known = {name: WORDS[vocabulary](name) for name in _names(vocabulary, _pairs(bumps))}
    columns = {name: word.columns(at) for name, word in known.items() if word is not None}
    names = list(columns)
    matrix = np.stack([np.concatenate(columns[name]) * np.tile(root, 2) for name in names], axis=1)
    chosen, sizes, left = _pursued(matrix, wanted, MOST_LOST * scatter_arcsec * ARCSEC)
    missed = float(np.linalg.norm(left)) / ARCSEC
    if missed > MOST_LOST * scatter_arcsec:
        return None
    return Waves(tuple((names[n], float(v)) for n, v in zip(chosen, sizes, strict=True)), missed)


def is_known(term: Term, at: Circumstances) -> bool:
    """Tell whether all is given that a term depends on."""
    try:
        term.effect.columns(at)
    except MissingColumn:
        return False
    return True


def sums(terms: Sequence[Term], vocabulary: str, at: Circumstances) -> Waves | None:
    """Return what terms are a sum of, zeros, tilts and waves of elevation; None for no such sum.

    `at`: directions all over the sky. Nothing is missed.
    """
    try:
        both = [term.effect.columns(at) for term in terms]
    except MissingColumn:
        return None
    values = [np.asarray(term.given(next(iter(term.by), ()))) for term in terms]
    wanted = np.zeros(2 * len(at))
    for pair, value in zip(both, values, strict=True):
        wanted += np.concatenate([axis @ value for axis in pair])
    named = [name for name in map(NAMES[vocabulary], SUMMED) if name is not None]
    names = list(dict.fromkeys(name for name, _ in named))
    words = [WORDS[vocabulary](name) for name in names]
    matrix = np.stack([np.concatenate(word.columns(at)) for word in words if word is not None], 1)
    sizes = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
    largest = float(np.abs(wanted).max(initial=0.0))
    if np.abs(matrix @ sizes - wanted).max(initial=0.0) > EXACT * largest:
        return None
    kept = [(n, float(v)) for n, v in zip(names, sizes, strict=True) if abs(v) > EXACT * largest]
    return Waves(tuple(kept))


def _pursued(matrix: Array, wanted: Array, allowed: float) -> tuple[list[int], Array, Array]:
    """Return columns, how many of each, and what they leave, down to a length that is allowed."""
    lengths = np.linalg.norm(matrix, axis=0)
    # As many rows as columns do: what is orthogonal to them all no choice of them changes.
    small = np.asarray(np.linalg.qr(np.column_stack([matrix / lengths, wanted]), mode="r"))
    unit, wanted = small[:, :-1], small[:, -1]
    chosen: list[int] = []
    sizes, left = np.zeros(0), wanted
    while np.linalg.norm(left) > allowed and len(chosen) < matrix.shape[1]:
        gain = np.abs(unit.T @ left)
        gain[chosen] = 0.0
        chosen.append(int(np.argmax(gain)))
        sizes = np.linalg.lstsq(unit[:, chosen], wanted, rcond=DISTINCT)[0]
        left = wanted - unit[:, chosen] @ sizes
    return chosen, sizes / lengths[chosen], left


def _pairs(bumps: Sequence[Bumps]) -> list[tuple[int, int]]:
    """Return how often the waves over the sky among some fields go around and up."""
    alone = [[(one["around"], one["upward"])] for one in bumps if one["kind"] == "wave"]
    found = [*alone, *(one["each"] for one in bumps if one["kind"] == "waves")]
    return [(around, upward) for each in found for around, upward in each]


def _names(vocabulary: str, pairs: Sequence[tuple[int, int]]) -> list[str]:
    """Return a vocabulary's waves of one angle, its zeros of both axes, and products of waves."""
    shapes = [Shape("collimation"), Shape("elevation_zero")]
    turns = range(1, MOST_TURNS + 1)
    for axis in ("xel", "az", "el"):
        for of in "AE" if axis != "az" else "A":
            shapes += [product(axis, Wave(one, of, k)) for k in turns for one in "SC"]
    for axis, (around, upward), a, e in itertools.product(("xel", "el"), pairs, "SC", "SC"):
        up = [Wave(e, "E", upward)] if upward else []
        shapes.append(product(axis, Wave(a, "A", around), *up))
    found = [NAMES[vocabulary](shape) for shape in shapes]
    return list(dict.fromkeys(one[0] for one in found if one is not None))


#: Steps of a correction grid, and the sky that it covers [deg].
GRID_STEP_DEG, LOWEST_DEG = 2.0, 2.0


@dataclass(frozen=True)
class Rest:
    """What a format cannot hold of a model."""

    names: tuple[str, ...] = ()  #: the terms, and the RT32's exact form where the model has it
    #: Their rms on the sky, both axes together, None where it depends on more than directions.
    rms_arcsec: float | None = 0.0
    grid: Path | None = None  #: where they were written to, None where they were left out
    #: What stands in the file for fields without a name.
    waves: Waves = field(default_factory=Waves)
    #: What the rms depends on and was not given, as recordings spell it.
    needs: tuple[str, ...] = ()

    @property
    def size(self) -> str:
        """Return how large it is, in words, or why that is not known."""
        if self.rms_arcsec is not None:
            return f"{self.rms_arcsec:.3g} arcsec rms over the sky"
        if fixed := [one for one in self.needs if not _can_be_set(one)]:
            return f"arcsec rms not known: it depends on {' and '.join(fixed)}"
        return f"arcsec rms not known without --set {' and --set '.join(self.needs)}"

    @property
    def words(self) -> str:
        """Return it as a sentence, "" for nothing."""
        if not self.names:
            return self.waves.words
        where = "left out" if self.grid is None else f"in {self.grid}"
        said = f"{where}: {', '.join(self.names)}, {self.size}"
        return f"{self.waves.words}; {said}" if self.waves.words else said


def _can_be_set(need: str) -> bool:
    """Tell whether one value of what a term needs can be given for the whole sky."""
    return all(one.isidentifier() for one in need.split(" or ")) and need not in _OF_SITE


def _open(model: Model, at: Circumstances) -> tuple[str, ...]:
    """Return what a model needs and was not given."""
    return tuple(
        need
        for need in model.needs()
        if not any(INSIDE.get(one, one) in at.columns for one in need.split(" or "))
    )


def sky() -> tuple[tuple[Array, Array], Circumstances]:
    """Return the directions of a correction grid [deg], shape (n,), and the same as pointings."""
    az_deg, el_deg = (
        one.ravel()
        for one in np.meshgrid(
            np.arange(0.0, 360.0, GRID_STEP_DEG),
            np.arange(LOWEST_DEG, 90.0, GRID_STEP_DEG),
            indexing="ij",
        )
    )
    return (az_deg, el_deg), Circumstances(az_deg * DEG, el_deg * DEG)


def sky_under(
    model: Model, conditions: Mapping[str, Any]
) -> tuple[tuple[Array, Array], Circumstances]:
    """Return the same for a model, at its site and under conditions that are given by name."""
    grid, at = sky()
    known = columns_of(conditions, model.needs())
    columns = {name: np.broadcast_to(one, len(at)) for name, one in known.items()}
    return grid, replace(at, site=model.site, columns=columns)


def rest_of(
    model: Model,
    file: ModelFile,
    lost: Sequence[str],
    path: Path | None,
    conditions: Mapping[str, Any],
) -> Rest:
    """Return what a file lacks of a model, and write it where a path is given.

    Raises `BadInput`: it has to be written and depends on more than directions.
    """
    if not lost:
        return Rest()
    (az_deg, el_deg), at = sky_under(model, conditions)
    try:
        x, y = (
            one - other
            for one, other in zip(
                model.offsets_on_sky(at), file.model("held").offsets_on_sky(at), strict=True
            )
        )
    except BadInput as error:
        if path is None:
            return Rest(tuple(lost), None, needs=_open(model, at))
        wanted = "a grid of directions tells none: --set COLUMN=VALUE gives one value for all"
        if "of the hours before" in error.message:
            wanted = "no grid of directions holds what was before: keep the .toml"
        raise BadInput(f"{error.message}; {wanted}", path) from None
    weight = np.cos(at.el)
    rms = float(np.sqrt(((x**2 + y**2) * weight).sum() / weight.sum())) / ARCSEC
    if path is not None:
        _write_grid(path, az_deg, el_deg, (x / ARCSEC, y / ARCSEC), lost, conditions)
    return Rest(tuple(lost), rms, path)


def _write_grid(
    path: Path,
    az_deg: Array,
    el_deg: Array,
    offsets_arcsec: tuple[Array, Array],
    names: Sequence[str],
    conditions: Mapping[str, Any],
) -> None:
    with write_whole(path) as out:
        out.write(f"# corrections: {', '.join(names)}\n# azimuth_zero: north\n")
        out.writelines(f"# {name}: {value}\n" for name, value in conditions.items())
        out.write("az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n")
        for row in zip(az_deg, el_deg, *offsets_arcsec, strict=True):
            out.write(f"{row[0]:g},{row[1]:g},{row[2]:.6f},{row[3]:.6f}\n")
