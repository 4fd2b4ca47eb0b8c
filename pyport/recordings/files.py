"""Recordings from a file and into a file; the suffix says which format."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pyport.errors import BadInput
from pyport.recordings import gmrt
from pyport.recordings.given import NOTHING, Given
from pyport.recordings.interpret import interpret
from pyport.recordings.masks import masked
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings
from pyport.recordings.tabulate import tabulate
from pyport.recordings.where import where


def resolve(name: str | Path) -> Path:
    """Return the file that a path, or the name of recordings shipped with pyport, stands for.

    Raises
    ------
    BadInput
        There is neither such a file nor such a name.
    """
    path = Path(name)
    if path.is_file():
        return path
    if str(name) in gmrt.NAMES:
        return gmrt.path(str(name))
    if path.is_dir():
        raise BadInput("this is a folder, expected a file of recordings", path)
    names = ", ".join(gmrt.NAMES)
    raise BadInput(f"no such file, expected a path or one of {names}", path)


def read(name: str | Path, given: Given = NOTHING) -> Recordings:
    """Read recordings from CSV, ECSV, Parquet, TPOINT's .dat, the Field System's .xtr or .err.

    Parameters
    ----------
    name
        A file, or the name of recordings shipped with pyport (`gmrt-2003-06-01`).
    given
        What the file itself does not say: header keys, names of its columns.

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
    recordings = interpret(read_raw(resolve(name), given))
    return where(recordings, given.where) if given.where else recordings


def read_raw(path: Path, given: Given = NOTHING) -> Raw:
    """Read the cells of a file as they stand, with what was said about it and its mask.

    Raises
    ------
    BadInput
        The suffix names no format, or the file is not of it.
    """
    from pyport.formats import tables

    raw = tables.read(path, given.format, given.columns)
    return masked(replace(raw, meta=raw.meta | dict(given.keys)))


def write(recordings: Recordings, path: str | Path) -> None:
    """Write recordings as CSV, ECSV or Parquet, so that reading them gives them back.

    Azimuth is written from north through east, angles in degrees. Rows that
    were set aside stand at the end, each with its reason and nothing else.

    Raises
    ------
    BadInput
        The suffix names no format.
    """
    from pyport.formats import tables

    tables.write(tabulate(recordings), Path(path))
