"""Cases on disk: recordings as the contract has them, the truth as canonical JSON, apart."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner.worlds.case import Case
from pyport.files import write_whole

#: Decimals of columns: offsets to a third of a milliarcsecond, places to four of them.
_DECIMALS = {
    "d_az_deg": 7,
    "d_el_deg": 7,
    "az_deg": 6,
    "el_deg": 6,
    "ra_deg": 6,
    "dec_deg": 6,
    "hour_angle_h": 6,
}
_OTHER_DECIMALS = 2


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
    with write_whole(path) as file:
        file.write(canonical(case.truth))


def _texts(name: str, values: NDArray[Any]) -> list[str]:
    """Return a column as text, blank where there is no number."""
    if values.dtype.kind != "f":
        return [str(value) for value in values]
    decimals = _DECIMALS.get(name, _OTHER_DECIMALS)
    return ["" if np.isnan(value) else f"{value:.{decimals}f}" for value in values]
