"""Where the antennas of an array stand: a survey to compare recordings with."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pyport.angles import Array
from pyport.errors import BadInput
from pyport.files import is_file
from pyport.recordings.formats import csv


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
