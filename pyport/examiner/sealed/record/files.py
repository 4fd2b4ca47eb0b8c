"""Cases on disk: recordings as the contract has them, the truth as canonical JSON, apart."""

from __future__ import annotations

import csv
import functools
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner.scores import Share
from pyport.examiner.sealed.record import code
from pyport.examiner.worlds.case import Case
from pyport.files import write_file, write_whole


def commitment(nonce: str, text: str) -> str:
    """Return SHA-256(nonce || text) as hexadecimal, the nonce given as hexadecimal too.

    The nonce, 256 random bits, keeps anyone from guessing a truth and checking the guess.
    """
    return hashlib.sha256(bytes.fromhex(nonce) + text.encode("utf-8")).hexdigest()


@functools.cache
def parts(unit: code.Unit) -> dict[str, str]:
    """Return the parts of a unit of this program, read once."""
    return code.parts(unit)


def solver() -> str:
    """Return the hash of the program on trial."""
    return code.whole(parts(code.SOLVER))


def examiner() -> str:
    """Return the hash of what examines it, the scoring script in it."""
    return code.whole(parts(code.EXAMINER))


#: Decimals of columns: offsets to a third of a milliarcsecond, places to four of them.
_PLACES = frozenset(
    {"az_deg", "el_deg", "ra_deg", "dec_deg", "ha_deg", "x_deg", "y_deg", "hour_angle_h"}
)


def canonical(truth: dict[str, Any]) -> str:
    """Return the one text that a truth is sealed as: sorted keys, no spaces to spare, one line."""
    return json.dumps(truth, sort_keys=True, separators=(",", ":"), ensure_ascii=False) + "\n"


def write_recordings(case: Case, path: Path) -> None:
    """Write what a solver may see."""
    texts = [_texts(name, values) for name, values in case.columns.items()]
    with write_whole(path) as file:
        for key, value in case.header.items():
            file.write(f"# {key}: {value}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(case.columns)
        table.writerows(zip(*texts, strict=True))


def write_truth(case: Case, path: Path) -> None:
    """Write what a solver may not see."""
    write_file(path, canonical(case.truth))


def _texts(name: str, values: NDArray[Any]) -> list[str]:
    """Return a column as text, blank where there is no number."""
    if values.dtype.kind != "f":
        return [str(value) for value in values]
    decimals = 7 if name.startswith("d_") else 6 if name in _PLACES else 2
    return ["" if np.isnan(value) else f"{value:.{decimals}f}" for value in values]


class Rate(Share):
    """A share of independent outcomes, spelled with its counts."""

    def __str__(self) -> str:
        """Return "93.3 % (56 of 60; 84.1 to 97.4)"."""
        if not self.of:
            return "none"
        low, high = self.interval
        counted = f"{self.hits} of {self.of}; {100 * low:.1f} to {100 * high:.1f}"
        return f"{100 * self.value:.1f} % ({counted})"


def count(outcomes: list[bool]) -> Rate:
    """Return the rate of what came true."""
    return Rate(sum(outcomes), len(outcomes))
