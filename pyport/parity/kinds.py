"""The Fortran types that are passed, and what NumPy holds them in."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_KIND = re.compile(r"(real|integer|logical|character)\*(\d+)$")
_SIZES = {
    "real": {4: "f4", 8: "f8"},
    "integer": {1: "i1", 2: "i2", 4: "i4", 8: "i8"},
    "logical": {4: "?", 1: "?", 2: "?", 8: "?"},
}


@dataclass(frozen=True)
class Kind:
    """A Fortran type with its length: ``real*8``, ``character*10``."""

    base: str
    size: int

    @classmethod
    def read(cls, text: str) -> Kind:
        """Return the kind that a text names.

        Raises `ValueError`: it is none that is supported; the message says which are.
        """
        found = _KIND.match(text.lower().replace(" ", ""))
        if found and (found[1] == "character" or int(found[2]) in _SIZES[found[1]]):
            return cls(found[1], int(found[2]))
        raise ValueError(
            f"kind {text!r} is not supported, expected real*4, real*8, integer*1, *2, *4 or *8, "
            "logical*1, *2, *4 or *8, or character*N"
        )

    def __str__(self) -> str:
        """Return the Fortran name."""
        return f"{self.base}*{self.size}"

    def dtype(self, *, promoted: bool = False) -> np.dtype:
        """Return the NumPy type of its values; of a build that promotes REAL*4 where `promoted`."""
        if self.base == "character":
            return np.dtype(f"S{self.size}")
        if promoted and self.base == "real":
            return np.dtype("f8")
        return np.dtype(_SIZES[self.base][self.size])

    def value(self, value: Any) -> NDArray:  # noqa: ANN401 - of any kind
        """Return what a description says, a value or a list of them, as this kind holds it."""
        if self.base == "character":
            value = str(value).ljust(self.size).encode("ascii")
        return np.asarray(value, self.dtype())
