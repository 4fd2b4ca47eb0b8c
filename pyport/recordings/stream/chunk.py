"""A chunk of rows as arrays: angles in radians, labels as numbers, what is unusable counted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.columns import LABELS, SCAN_RATE, TIME, angle_of
from pyport.effects.base import Circumstances
from pyport.errors import BadInput
from pyport.mounts import ALTAZ
from pyport.recordings import interpret, mounted
from pyport.recordings.formats.tables import is_text, refuse_long
from pyport.recordings.raw import WEATHER, Raw
from pyport.recordings.stream.pieces import Piece

#: So many excluded rows are listed; of the others the reasons are counted.
MOST_LISTED = 1000

#: Of so many sets of labels each could have a place of its own in memory.
MOST_CODES = 1 << 22

NO_OFFSET = "no offset on either axis"
NO_POSITION = "no azimuth or no elevation"


@dataclass
class Aside:
    """Rows that cannot be used: how many for which reason, and where the first ones stand."""

    counts: dict[str, int] = field(default_factory=dict)
    listed: list[tuple[str, int, str]] = field(default_factory=list)

    def note(self, file: Path, rows: NDArray[np.int64], reason: str) -> None:
        """Count rows, and list them while there is room."""
        if len(rows) == 0:
            return
        self.counts[reason] = self.counts.get(reason, 0) + len(rows)
        room = MOST_LISTED - len(self.listed)
        self.listed += [(str(file), int(row), reason) for row in rows[:room]]

    def add(self, other: Aside) -> None:
        """Add what another piece excluded."""
        for reason, count in other.counts.items():
            self.counts[reason] = self.counts.get(reason, 0) + count
        self.listed += other.listed[: MOST_LISTED - len(self.listed)]


@dataclass(frozen=True)
class Chunk:
    """n usable rows."""

    #: `az`, `el`, `x`, `y`: direction as the file counts it and offsets [rad], shape (n,); NaN
    #: where an axis was not measured.
    az: Array
    el: Array
    x: Array
    y: Array
    time: Array  #: seconds since 1970, shape (n,); zero where no time is given
    direction: Array  #: of the scan, +1, -1 or 0, shape (n,)
    #: Further columns of numbers by the name they have in the file, shape (n,) each.
    numbers: dict[str, Array]
    #: `label`, `names`: number of each row's set of labels, shape (n,), and what these sets are:
    #: values in the order of `label_names`.
    label: NDArray[np.int64]
    names: list[tuple[str, ...]]
    label_names: tuple[str, ...]  #: which labels there are

    def take(self, mask: NDArray[np.bool_]) -> Chunk:
        """Return some of the rows."""
        rows = ("az", "el", "x", "y", "time", "direction", "label")
        some = {name: getattr(self, name)[mask] for name in rows}
        return replace(self, **some, numbers={k: v[mask] for k, v in self.numbers.items()})


def chunk_of(batch: Any, piece: Piece, first_row: int, aside: Aside) -> Chunk:  # noqa: ANN401
    """Return the usable rows of a record batch, note the others.

    Raises `BadInput`: a column that is needed is missing, has no unit, or holds what no telescope
      can have.
    """
    raw, texts = cells(batch, piece, first_row)
    angles = interpret.angles_of(raw)
    interpret.check_ranges(raw, angles)
    if not {"az", "el"} <= set(angles):
        raise raw.error("no columns az_deg and el_deg: a data set of many files must have them")
    az, el = angles["az"], angles["el"]
    if (mount := mounted.mount_of(raw, angles)) is not ALTAZ:
        raise raw.error(f"{mount.sentence}: a data set of many files must be of alt-azimuth ones")
    x, y = mounted.offsets_of(raw, angles, Circumstances(az, el))
    time = raw.seconds(TIME) if TIME in raw.columns else np.zeros(len(az))
    numbers = {
        name: _measured(name, raw.numbers(name))
        for name in raw.columns
        if name not in {TIME, "scan_direction"} and not _spoken_for(name)
    }
    direction = np.zeros(len(az))
    if "scan_direction" in raw.columns:
        direction = np.nan_to_num(raw.numbers("scan_direction"))
        raw.refuse(~np.isin(direction, (-1, 0, 1)), "scan_direction is not +1, -1, 0 or blank")
    label, names, label_names = _labels(texts, piece, len(az))
    no_offset = np.isnan(x) & np.isnan(y)
    no_position = np.isnan(az) | np.isnan(el)
    no_time = np.isnan(time)
    good = ~(no_offset | no_position | no_time)
    chunk = Chunk(az, el, x, y, time, direction, numbers, label, names, label_names)
    if good.all():
        return chunk
    aside.note(piece.file, raw.line[no_offset], NO_OFFSET)
    aside.note(piece.file, raw.line[no_position & ~no_offset], NO_POSITION)
    aside.note(piece.file, raw.line[no_time & ~no_position & ~no_offset], f"no {TIME}")
    return chunk.take(good)


def _measured(name: str, values: Array) -> Array:
    """Return a column's numbers, impossible weather as NaN: a mean would hide it."""
    low, high = WEATHER.get(name, (-np.inf, np.inf))
    with np.errstate(invalid="ignore"):
        return np.where((values < low) | (values > high), np.nan, values)


def _spoken_for(name: str) -> bool:
    """Tell whether a column is one of the position, the offsets or their errors."""
    angle = angle_of(name)
    return angle is not None and angle[0] in {
        "az", "el", "d_az", "d_xel", "d_el", "d_zd", "sigma_az", "sigma_xel", "sigma_el",
    }  # fmt: skip


def cells(batch: Any, piece: Piece, first_row: int) -> tuple[Raw, dict[str, Any]]:  # noqa: ANN401
    """Return a batch's numbers and times as cells, and its text columns apart."""
    import pyarrow

    kinds = pyarrow.types
    columns: dict[str, NDArray[Any]] = {}
    texts: dict[str, Any] = {}
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        kind = column.type
        if name == TIME and not kinds.is_timestamp(kind):
            column = _as_time(column, piece.file)  # noqa: PLW2901
            kind = column.type
        if name in LABELS:
            texts[name] = column
        elif kinds.is_timestamp(kind):
            times = column.cast(pyarrow.timestamp("us"))
            columns[name] = times.to_numpy(zero_copy_only=False).astype("datetime64[us]")
        elif kinds.is_integer(kind) or kinds.is_floating(kind):
            columns[name] = column.to_numpy(zero_copy_only=False)
        elif name == SCAN_RATE or angle_of(name) is not None:
            raise BadInput(f"column {name!r} is no column of numbers", piece.file)
        # other words are no labels of the contract and no numbers: nothing can follow them
    line = np.arange(first_row, first_row + batch.num_rows)
    return Raw(piece.file, {}, 1, columns, line), texts


def _as_time(column: Any, file: Path) -> Any:  # noqa: ANN401 - pyarrow is not typed
    """Return ISO 8601 text as times, null where it is blank."""
    import pyarrow
    from pyarrow import compute

    try:
        text = column.dictionary if pyarrow.types.is_dictionary(column.type) else column
        known = compute.if_else(compute.equal(text, ""), None, text)
        times = compute.cast(compute.replace_substring(known, "Z", ""), pyarrow.timestamp("us"))
        return times.take(column.indices) if text is not column else times
    except pyarrow.ArrowException as error:
        raise BadInput(f"{TIME}: {str(error).splitlines()[0]}", file) from None


def _labels(
    texts: dict[str, Any], piece: Piece, rows: int
) -> tuple[NDArray[np.int64], list[tuple[str, ...]], tuple[str, ...]]:
    """Return the number of each row's set of labels, the sets, and which labels there are."""
    names = tuple(sorted({*texts, *(name for name, _ in piece.labels)}))
    fixed = dict(piece.labels)
    label = np.zeros(rows, np.int64)
    sets: list[tuple[str, ...]] = [()]
    for name in names:
        if name in texts:
            encoded = texts[name].dictionary_encode()
            own = [*_words(encoded.dictionary, name, piece.file), ""]
            index = encoded.indices.fill_null(len(own) - 1).to_numpy(zero_copy_only=False)
            if len(index) and not 0 <= index.min() <= index.max() < len(own):
                raise BadInput(f"{name} names texts that it does not hold", piece.file)
        else:
            own, index = [fixed[name]], np.zeros(rows, np.int64)
        there, label = _numbered(label * len(own) + index, len(sets) * len(own))
        sets = [(*sets[one // len(own)], own[one % len(own)]) for one in there.tolist()]
    return label, sets, names


def _numbered(code: NDArray[np.int64], size: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return which codes below `size` there are, and the place of each row's code among them."""
    if size > MOST_CODES:
        return np.unique(code, return_inverse=True)
    places = np.zeros(size, np.int64)
    places[code] = 1
    there = np.flatnonzero(places)
    places[there] = np.arange(len(there))
    return there, places[code]


def _words(dictionary: Any, name: str, file: Path) -> list[str]:  # noqa: ANN401
    """Return the texts that a column of labels holds.

    Raises `BadInput`: a text is longer than a cell may be, or none.
    """
    if is_text(dictionary.type):
        refuse_long(dictionary, name, file)
    try:
        return [_word(one) for one in dictionary.to_pylist()]
    except UnicodeDecodeError:
        raise BadInput(f"{name} holds what is no text, expected UTF-8", file) from None


def _word(value: object) -> str:
    """Return a label as text: 130.0 names the same channel as 130."""
    return f"{value:.15g}" if isinstance(value, float) else str(value).strip()
