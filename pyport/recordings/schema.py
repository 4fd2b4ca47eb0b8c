"""Recordings: measured pointing offsets, the circumstances they were taken in, and their origin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array, Codes
from pyport.columns import AXES, COLUMNS, SET_ASIDE, TIME
from pyport.effects.base import Circumstances, Effect, MissingColumn
from pyport.effects.circumstances import Index
from pyport.errors import BadInput
from pyport.files import sha256
from pyport.recordings.mounted import names_of


@dataclass(frozen=True)
class SetAside:
    """A row that cannot be used: its line in the file and the reason."""

    line: int
    reason: str


@dataclass(frozen=True)
class Reduction:
    """How the rows of a data set became normal points.

    Attributes
    ----------
    rows, points, places
        Rows of all files, normal points, and the places at which effects are computed for them.
    patch_deg, stretch_s
        A point's width in azimuth and elevation [deg] and its length in time [s], None where
        it takes in all times.
    outliers
        Readings without weight: far from others of their antenna, place and time.
    set_aside
        Rows that could not be used, by reason.
    """

    rows: int
    points: int
    places: int
    patch_deg: float
    stretch_s: float | None
    outliers: int
    set_aside: dict[str, int]


@dataclass(frozen=True)
class Recordings:
    """n measured offsets with their circumstances; radians, encoder minus true.

    Attributes
    ----------
    at
        Where, when and in which conditions, shape (n,) each.
    x, y
        Cross-elevation and elevation offset [rad], shape (n,); NaN where that
        axis was not measured.
    sigma_x, sigma_y
        One-sigma errors as recorded [rad], shape (n,); NaN where there is none.
    line
        Line (or row) of the file that each recording came from, shape (n,).
    file
        The file as the user named it.
    meta
        What the header says of all rows, as text, and under `azimuth_zero`,
        `telescope`, ... as the contract names it.
    set_aside
        Rows of the file that are not among the n, none missing; of a data set the first ones.
    reduction
        How the rows of a data set became the n; None for those of one file.
    notes
        What the file says against itself, a sentence each.
    """

    at: Circumstances
    x: Array
    y: Array
    sigma_x: Array
    sigma_y: Array
    line: NDArray[np.int64]
    file: Path
    meta: dict[str, str] = field(default_factory=dict)
    set_aside: tuple[SetAside, ...] = ()
    reduction: Reduction | None = None
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return n."""
        return len(self.y)

    def take(self, index: Index) -> Recordings:
        """Return the recordings that a mask, slice or list of rows selects."""
        return replace(
            self,
            at=self.at.take(index),
            x=self.x[index],
            y=self.y[index],
            sigma_x=self.sigma_x[index],
            sigma_y=self.sigma_y[index],
            line=self.line[index],
        )

    def label(self, name: str) -> NDArray[Any]:
        """Return a label for each row, "" everywhere where the file has none."""
        if name in self.at:
            return self.at.column(name)
        return np.full(len(self), "")


def as_input(recordings: Recordings) -> dict[str, Any]:
    """Return the recordings as every report names them under `input`.

    `file`, `sha256`; `rows` of the file and how many of them are `used`; those that are not in
    `set_aside`, each with line and reason; the `reduction` of a data set, None for one file.
    """
    file, made = recordings.file, recordings.reduction
    aside, used = recordings.set_aside, len(recordings)
    rows = used + len(aside)
    if made is not None:
        rows, used = made.rows, made.rows - sum(made.set_aside.values())
    return {
        "file": file.name,
        "sha256": sha256(file) if file.is_file() else None,
        "rows": rows,
        "used": used,
        "set_aside": [vars(one) for one in aside],
        "reduction": None if made is None else vars(made),
    }


def counted(read: Mapping[str, Any]) -> str:
    """Return in words what `as_input` says: how many recordings, and how many are excluded."""
    aside, what = len(read["set_aside"]), f"{read['used']} recordings"
    if (made := read["reduction"]) is not None:
        aside = sum(made["set_aside"].values())
        what = (
            f"{made['rows']} recordings in {made['points']} normal points "
            f"{made['patch_deg']:g} deg wide, {made['outliers']} readings outliers"
        )
    return f"{read['file']}: {what}, {aside} excluded"


@dataclass(frozen=True)
class Stack:
    """m measured numbers out of n recordings: cross-elevations first, then elevations."""

    row: Codes  #: which recording each number belongs to, shape (m,)
    #: True for an elevation offset, False for a cross-elevation offset, shape (m,).
    is_y: NDArray[np.bool_]
    value: Array  #: the offset [rad], shape (m,)

    def __len__(self) -> int:
        """Return m."""
        return len(self.value)

    def spread(self, x: Array, y: Array) -> Array:
        """Return the numbers of this stack out of (n, ...) arrays for each axis, shape (m, ...)."""
        first = len(self) - int(np.count_nonzero(self.is_y))
        halves = (x, self.row[:first]), (y, self.row[first:])
        # where every row was measured there is nothing to pick
        return np.concatenate([own if len(rows) == len(own) else own[rows] for own, rows in halves])

    def columns(self, effect: Effect, at: Circumstances) -> Array:
        """Return an effect's basis for this stack, shape (m, k)."""
        return self.spread(*effect.columns(at))


def stack(recordings: Recordings) -> Stack:
    """Return every measured number of the recordings."""
    has_x = np.flatnonzero(np.isfinite(recordings.x))
    has_y = np.flatnonzero(np.isfinite(recordings.y))
    return Stack(
        row=np.concatenate([has_x, has_y]),
        is_y=np.repeat([False, True], [len(has_x), len(has_y)]),
        value=np.concatenate([recordings.x[has_x], recordings.y[has_y]]),
    )


def term_columns(data: Stack, effect: Effect, recordings: Recordings) -> Array:
    """Return the basis of a model's term for a stack of these recordings, shape (m, k).

    Raises `BadInput`: the term needs more than these recordings tell.
    """
    try:
        return data.columns(effect, recordings.at)
    except MissingColumn as lack:
        said = f"the model's term {effect.id} {lack}, which is not there"
        raise BadInput(said, recordings.file) from None


def group(recordings: Recordings, per: Sequence[str]) -> tuple[Codes, list[tuple[str, ...]]]:
    """Give rows with the same values of some labels the same number.

    Returns for each row the number of its group, shape (n,).
    Returns the label values of each group.
    """
    codes = np.zeros(len(recordings), dtype=np.intp)
    names: list[tuple[str, ...]] = [()]
    for label in per:
        values, inverse = np.unique(recordings.label(label).astype(str), return_inverse=True)
        pairs, codes = np.unique(codes * len(values) + inverse, return_inverse=True)
        names = [(*names[pair // len(values)], str(values[pair % len(values)])) for pair in pairs]
    return codes, names


#: Columns of the program -> the contract's name and the radians (or s) of one of its units.
_UNITS = {
    **{name: (f"{name}_deg", DEG) for name in AXES},
    **{one.name: (one.written, one.scale) for one in COLUMNS if one.spoken and one.written},
}


@dataclass(frozen=True)
class Table:
    """What a file of recordings holds: header keys, and columns of numbers or text."""

    meta: dict[str, str]
    columns: dict[str, NDArray[Any]]


def tabulate(recordings: Recordings) -> Table:
    """Return the columns that a file of these recordings has, excluded rows at the end."""
    at = recordings.at
    columns: dict[str, NDArray[Any]] = {"az_deg": at.az / DEG, "el_deg": at.el / DEG}
    names = names_of(at.mount)
    offsets = {
        f"{names.across}_deg": recordings.x,
        f"{names.along}_deg": recordings.y,
        f"{names.sigmas[1]}_deg": recordings.sigma_x,
        f"{names.sigmas[2]}_deg": recordings.sigma_y,
    }
    for name, values in offsets.items():
        if name.startswith("d_") or np.isfinite(values).any():
            columns[name] = values / DEG
    for name, values in at.columns.items():
        if name == "time":
            columns[TIME] = iso_8601(values)
        else:
            label, unit = _UNITS.get(name, (name, 1.0))
            columns[label] = values if values.dtype.kind == "U" else values / unit
    if recordings.set_aside:
        more = len(recordings.set_aside)
        for name, values in columns.items():
            blank = np.full(more, "" if values.dtype.kind == "U" else np.nan)
            columns[name] = np.concatenate([values, blank])
        reasons = [aside.reason for aside in recordings.set_aside]
        columns[SET_ASIDE] = np.array([""] * len(recordings) + reasons, np.str_)
    return Table(_meta(recordings), columns)


def _meta(recordings: Recordings) -> dict[str, str]:
    """Return the header keys, with the azimuth's zero as it is written."""
    meta = {k: v for k, v in recordings.meta.items() if k != "azimuth_zero"}
    site = recordings.at.site
    if site is not None and "latitude_deg" not in meta:
        meta["latitude_deg"] = f"{site.latitude / DEG:.15g}"
        if site.longitude is not None:
            meta["longitude_deg"] = f"{site.longitude / DEG:.15g}"
        meta["height_m"] = f"{site.height_m:.15g}"
    return meta


def iso_8601(seconds: NDArray[np.float64]) -> NDArray[np.str_]:
    """Return seconds since 1970 as ISO 8601 in UTC to the microsecond, "" for NaN."""
    micro = np.round(np.nan_to_num(seconds) * 1e6).astype("datetime64[us]")
    return np.where(np.isnan(seconds), "", np.datetime_as_string(micro, timezone="UTC"))
