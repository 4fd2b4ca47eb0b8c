"""Numbers as short text: steps counted from the lowest value, in base64."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

#: The code of a number that is not known, by the bytes of a code.
_NOTHING = {2: 0xFFFF, 4: 0xFFFFFFFF}


def numbers(values: Array, step: float = 0.0) -> dict[str, object]:
    """Return numbers as whole steps above the lowest; NaN for what is not known.

    Two bytes a number, or four where 65 534 steps across the range are coarser
    than `step` (0 for whatever two bytes hold).
    """
    known = np.isfinite(values)
    low, high = (
        (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    )
    size = 2 if step <= 0 or (high - low) / (_NOTHING[2] - 1) <= step else 4
    unit = (high - low) / (_NOTHING[size] - 1)
    # Few digits in the text; rounded up so that the highest still has a code.
    unit = float(f"{unit * (1 + 1e-6):.7g}") or 1.0
    codes = np.full(len(values), _NOTHING[size], f"<u{size}")
    codes[known] = np.round((values[known] - low) / unit)
    return {"low": low, "unit": unit, "bytes": size, "data": _text(codes)}


def words(values: NDArray[np.str_]) -> dict[str, object]:
    """Return labels as their list and a code of two bytes for each."""
    names, codes = np.unique(values, return_inverse=True)
    return {"names": [str(name) for name in names], "data": _text(codes.astype("<u2"))}


def _text(codes: NDArray[np.unsignedinteger]) -> str:
    return base64.b64encode(codes.tobytes()).decode("ascii")
