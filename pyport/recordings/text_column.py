"""A column of text held by Arrow, and read as words, numbers or times all at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

#: Microseconds that a double holds exactly reach this far from 1970.
_EXACT_US = 2**53
#: Where the years that `datetime` knows begin [microseconds since 1970].
_FIRST_YEAR_US = -62135596800 * 10**6


@dataclass(frozen=True)
class TextColumn:
    """n cells of text in the place of an array of n strings.

    What is asked of all cells is answered here only where the answer is that of Python's
    functions, cell by cell; anything doubtful is left to them.
    """

    cells: Any  #: an Arrow array of strings, without nulls
    dtype = np.dtype(object)

    def __len__(self) -> int:
        """Return how many cells there are."""
        return len(self.cells)

    def __getitem__(self, rows: Any) -> Any:  # noqa: ANN401 - as numpy's arrays
        """Return a cell, or some of them as an array."""
        if isinstance(rows, int | np.integer):
            return self.cells[int(rows)].as_py()
        return np.asarray(self)[rows]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: ANN401, FBT001
        """Return the cells as an array of strings."""
        return np.array(self.tolist(), object if dtype is None else dtype)

    def tolist(self) -> list[str]:
        """Return the cells."""
        return self.cells.to_numpy(zero_copy_only=False).tolist()

    def distinct(self) -> tuple[list[str], NDArray[np.int32]]:
        """Return the different cells, and which of them stands in each row, shape (n,)."""
        encoded = self.cells.dictionary_encode()
        return encoded.dictionary.to_pylist(), encoded.indices.to_numpy()

    def numbers(self) -> Array | None:
        """Return the cells as numbers, NaN where blank; None where a cell is anything else."""
        from pyarrow import ArrowInvalid, compute, float64

        told, blank = self._told()
        try:
            values = told.cast(float64()).to_numpy(zero_copy_only=False)
        except ArrowInvalid:
            return None
        doubtful = ~(np.isfinite(values) | blank)
        if doubtful.any():  # "nan" says nothing, anything longer is for Python to judge
            length = compute.binary_length(self.cells).to_numpy()[doubtful]
            if not (np.isnan(values[doubtful]) & (length == len("nan"))).all():
                return None
        return values

    def seconds(self) -> Array | None:
        """Return ISO 8601 times (UTC) as seconds since 1970, NaN where blank.

        None where a cell is anything else, or where only some tell their zone.
        """
        from pyarrow import ArrowInvalid, int64, timestamp

        told, blank = self._told()
        for kind in (timestamp("us", tz="UTC"), timestamp("us")):
            try:
                since = told.cast(kind).cast(int64())
            except ArrowInvalid:
                continue
            break
        else:
            return None
        us = since.fill_null(0).to_numpy()
        if ((us < _FIRST_YEAR_US) | (np.abs(us) > _EXACT_US)).any():
            return None
        seconds = us / 1e6
        seconds[blank] = np.nan
        return seconds

    def _told(self) -> tuple[Any, NDArray[np.bool_]]:
        """Return the cells with nulls where they are blank, and where that is."""
        from pyarrow import compute, scalar

        blank = compute.equal(self.cells, "")
        told = compute.if_else(blank, scalar(None, self.cells.type), self.cells)
        return told, blank.to_numpy(zero_copy_only=False)
