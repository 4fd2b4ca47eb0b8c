"""Strong radio sources that pointing is measured on."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array


@dataclass(frozen=True)
class Sources:
    """Names and ICRS positions [rad] of sources, to an arcsecond, shape (m,)."""

    name: NDArray[np.str_]
    ra: Array
    dec: Array


@cache
def sources() -> Sources:
    """Return the list in `sources.csv`: calibrators from 80 deg north to 80 deg south."""
    text = (files("pyport.examiner.worlds") / "sources.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return Sources(
        np.array([row["name"] for row in rows]),
        np.array([float(row["ra_h"]) for row in rows]) * HOUR,
        np.array([float(row["dec_deg"]) for row in rows]) * DEG,
    )
