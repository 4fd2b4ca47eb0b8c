"""Recordings from a file and into a file; the suffix says which format.

`printed/` holds the tables as printed, `data/` the recordings made of them by
`python -m pyport.studies.gmrt.recovery`; README.md tells how.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.errors import BadInput
from pyport.files import is_file, is_folder
from pyport.recordings import naming
from pyport.recordings.formats import csv
from pyport.recordings.interpret import interpret
from pyport.recordings.masks import masked
from pyport.recordings.notes import noted
from pyport.recordings.raw import NOTHING, FileOptions, Raw
from pyport.recordings.schema import Recordings, tabulate
from pyport.recordings.where import where
from pyport.runs.workers import Spread

DATA = Path(__file__).parent / "data"

#: Name on the command line -> the sessions in that file.
NAMES: dict[str, tuple[str, ...]] = {
    "gmrt-2003-03-31": ("2003-03-31",),
    "gmrt-2003-05-31": ("2003-05-31",),
    "gmrt-2003-06-01": ("2003-06-01",),
    "gmrt-2003-06-02": ("2003-06-02",),
    "gmrt-2003-06-05": ("2003-06-05",),
    "gmrt-cyg-a": ("2003-06-01", "2003-06-02", "2003-06-05"),
}


def shipped(name: str) -> Path:
    """Return the CSV file of a shipped set: `gmrt-2003-06-01`, `2003-06-01`, `cyg-a`, ..."""
    full = name if name.startswith("gmrt-") else f"gmrt-{name}"
    if full not in NAMES:
        raise KeyError(name)
    return DATA / f"{full}.csv"


def resolve(name: str | Path) -> Path:
    """Return the file that a path, or the name of recordings shipped with pyport, stands for.

    Raises
    ------
    BadInput
        There is neither such a file nor such a name.
    """
    path = Path(name)
    if is_file(path):
        return path
    if str(name) in NAMES:
        return shipped(str(name))
    if is_folder(path):
        from pyport.recordings.stream import is_data_set

        if is_data_set(path):
            return path
        raise BadInput("a folder without Parquet files, expected recordings", path)
    names = ", ".join(NAMES)
    raise BadInput(f"no such file, expected a path or one of {names}", path)


def read(
    name: str | Path,
    given: FileOptions = NOTHING,
    spread: Spread[Any, Any] = map,
    beside: Path | None = None,
) -> Recordings:
    """Read recordings from CSV, ECSV, Parquet, TPOINT's .dat, the Field System's .xtr or .err.

    Parameters
    ----------
    name
        A file, the name of recordings shipped with pyport (`gmrt-2003-06-01`), or a folder of
        Parquet files, which is reduced to normal points.
    given
        What the file itself does not say: header keys, names of its columns.
    spread
        How the pieces of such a folder are gone through: `map`, or another that keeps order.
    beside
        Folder in which is kept how far that has come, if it is to go on after a kill.

    Returns
    -------
    Recordings
        In radians, azimuth from north through east, encoder minus true; the
        rows that cannot be used are in `set_aside`.

    Raises
    ------
    BadInput
        With file and line: what is wrong and what was expected.
    """
    path, raw = resolve(name), None
    if path.is_dir():
        from pyport.recordings.stream import read_data_set

        recordings = read_data_set(path, given, spread, beside)
    else:
        raw = read_raw(path, given)
        recordings = interpret(raw)
    kept = where(recordings, given.where) if given.where else recordings
    if not len(kept):
        raise BadInput(nothing_left(recordings, given.where), path)
    return kept if raw is None else noted(kept, raw)


def nothing_left(recordings: Recordings, expression: str = "") -> str:
    """Return why no recording is left to use."""
    if len(recordings):
        return f"--where {expression!r} holds for none of the {len(recordings)} recordings"
    reasons = Counter(one.reason for one in recordings.set_aside).most_common(2)
    listed = "; ".join(f"{count} rows: {reason}" for reason, count in reasons)
    return f"no row can be used: {listed or 'there is none'}"


def read_raw(path: Path, given: FileOptions = NOTHING) -> Raw:
    """Read the cells of a file as they stand, with what was said about it and its mask.

    Raises
    ------
    BadInput
        The suffix names no format, or the file is not of it.
    """
    from pyport.recordings.formats import registry as tables

    raw = tables.read(path, given.format, given.columns, given.mapping)
    raw = replace(raw, meta=naming.as_keys(raw.meta))
    try:
        naming.refuse_keys(given.keys, "--set ")
        naming.refuse_slips(given.keys, "--set ")
        naming.refuse_columns(raw.columns)
    except BadInput as error:
        raise raw.error(error.message) from None
    for key in raw.meta:
        try:
            naming.refuse_keys([key], "header key ")
        except BadInput as error:
            raise raw.error(error.message, key=key) from None
    return masked(replace(raw, meta=raw.meta | dict(given.keys)))


def write(recordings: Recordings, path: str | Path) -> None:
    """Write recordings as CSV, ECSV or Parquet, so that reading them gives them back.

    Azimuth is written from north through east, angles in degrees. Rows that
    were excluded stand at the end, each with its reason and nothing else.

    Raises
    ------
    BadInput
        The suffix names no format.
    """
    from pyport.recordings.formats import registry as tables

    tables.write(tabulate(recordings), Path(path))


@dataclass(frozen=True)
class Survey:
    """Surveyed places of antennas about the array's reference."""

    file: Path  #: where they are from
    names: tuple[str, ...]  #: of the n antennas, as the recordings spell them
    east_m: Array  #: toward east of the reference, shape (n,)


def read_survey(path: Path) -> Survey:
    """Read a CSV file with the columns `name` and `east_m`; others are ignored.

    Raises `BadInput`: with file and line: no such file, a column is missing, a name is blank or
      there twice, a place is no number.
    """
    if not is_file(path):
        raise BadInput("no such file, expected a CSV file with columns name,east_m", path)
    raw = csv.read(path)
    for wanted in ("name", "east_m"):
        if wanted not in raw.columns:
            raise raw.error(f"no column {wanted!r}, expected name,east_m")
    names, east = raw.words("name"), raw.numbers("east_m")
    raw.refuse(names == "", "name is blank, expected an antenna's")
    raw.refuse(np.isnan(east), "east_m is blank, expected metres toward east of the reference")
    _, first = np.unique(names, return_index=True)
    again = ~np.isin(np.arange(len(names)), first)
    raw.refuse(again, "this antenna stands there twice, expected it once")
    return Survey(path, tuple(names.tolist()), east)
