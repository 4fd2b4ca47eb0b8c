"""The cells of a file before they mean anything, what was said about them, and columns of text."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.errors import BadInput


@dataclass(frozen=True)
class FileOptions:
    """Header keys and column names that come from the command line.

    Attributes
    ----------
    keys
        Header keys such as `latitude_deg`; they win over the file's own.
    columns
        Names of the columns of a CSV file without a line of names.
    mapping
        The contract's columns by what this file calls them: see `pyport.recordings.formats.mapped`.
    format
        The file's format, where its suffix does not tell it.
    where
        An expression: rows for which it does not hold are excluded.
    """

    keys: Mapping[str, str] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    format: str = ""
    where: str = ""
    mapping: Mapping[str, str] = field(default_factory=dict)


NOTHING = FileOptions()

#: What weather there is on Earth. A number outside says that nothing was measured.
WEATHER = {
    "temperature_c": (-90.0, 60.0),
    "pressure_hpa": (300.0, 1100.0),
    "humidity_pct": (0.0, 110.0),
    "wind_speed_m_s": (0.0, 120.0),
}
#: Numbers of nines alone, such as -999 or 9999.9, stand for nothing in many logs.
NINES = (999, 9999, 99999, 999999, 999.9, 999.99, 9999.9, 9999.99)
#: Header key under which it is said which cells were taken for blank.
BLANK = "taken_for_blank"
#: Header key under which it is said what a reader assumed of refraction.
REFRACTION = "tpoint_refraction"


#: Times outside are another count of days or of seconds than was thought.
EARLIEST_S, LATEST_S = (datetime(year, 1, 1, tzinfo=UTC).timestamp() for year in (1950, 2100))
SINCE = "between 1950 and 2100"
#: Times that are counted: when it was 1970, and seconds in each.
COUNTED = {"mjd": (40587.0, 86400.0), "jd": (2440587.5, 86400.0), "unix": (0.0, 1.0)}

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

        cells, blank = self._with_nulls()
        try:
            values = cells.cast(float64()).to_numpy(zero_copy_only=False)
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

        cells, blank = self._with_nulls()
        for kind in (timestamp("us", tz="UTC"), timestamp("us")):
            try:
                since = cells.cast(kind).cast(int64())
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

    def _with_nulls(self) -> tuple[Any, NDArray[np.bool_]]:
        """Return the cells with nulls where they are blank, and where that is."""
        from pyarrow import compute, scalar

        blank = compute.equal(self.cells, "")
        cells = compute.if_else(blank, scalar(None, self.cells.type), self.cells)
        return cells, blank.to_numpy(zero_copy_only=False)


#: Numpy pads text to its longest cell: one runaway cell would cost its length in every row.
LONGEST_CELL, LARGEST_COLUMN = 1000, 2**28


@dataclass(frozen=True)
class Raw:
    """Columns of n cells as they stand in a file."""

    file: Path  #: the file as the user named it
    meta: dict[str, str]  #: its `key: value` lines, as text
    header_line: int  #: the line of the column names, for errors that concern a whole column
    #: Name -> cells, shape (n,): text ("" for blank), of a large file held by Arrow, or numbers
    #: (NaN for blank).
    columns: Mapping[str, NDArray[Any] | TextColumn]
    line: NDArray[np.int64]  #: the line (or row) of each cell, shape (n,)
    #: Key -> its line in the file.
    key_line: Mapping[str, int] = field(default_factory=dict)
    #: Name -> the unit that the file gives a column beside its name and that is not yet used.
    units: Mapping[str, str] = field(default_factory=dict)
    note: str = ""  #: what its reader passed over

    def error(self, message: str, row: int | None = None, *, key: str = "") -> BadInput:
        """Return an error that names the file and the line of the row, the key or the header."""
        header = self.key_line.get(key, self.header_line)
        return BadInput(message, self.file, header if row is None else self.line[row])

    def words(self, name: str) -> NDArray[np.str_]:
        """Return a column as text without surrounding blanks.

        Raises `BadInput`: a cell is so long that it is none.
        """
        cells = self.columns[name]
        if cells.dtype.kind in "fiub":
            # 130.0 names the same channel as 130
            return np.array(["" if v != v else f"{v:.15g}" for v in cells.tolist()], np.str_)  # noqa: PLR0124
        different, which = (
            cells.distinct() if isinstance(cells, TextColumn) else (cells.tolist(), slice(None))
        )
        text = [str(cell).strip() for cell in different]
        longest = max(map(len, text), default=0)
        if longest > LONGEST_CELL or longest * len(cells) > LARGEST_COLUMN:
            long = np.array([len(cell) == longest for cell in text])[which]
            most = min(LONGEST_CELL, LARGEST_COLUMN // len(cells))
            raise self.error(f"{name} has more than {most} characters", int(np.argmax(long)))
        return np.array(text, np.str_)[which]

    def numbers(self, name: str) -> Array:
        """Return a column as numbers, NaN where it is blank.

        Raises `BadInput`: a cell is neither blank nor a finite number.
        """
        cells = self.columns[name]
        if isinstance(cells, TextColumn):
            if (values := cells.numbers()) is not None:
                return values
            cells = np.asarray(cells)
        if cells.dtype.kind in "fiub":
            values = cells.astype(float)
        else:
            try:
                values = np.array([_number(cell or "nan") for cell in cells.tolist()])
            except (TypeError, ValueError):
                values = self._numbers_one_by_one(name)
        self.refuse(np.isinf(values), f"{name} is infinite, expected a number or blank")
        return values

    def _numbers_one_by_one(self, name: str) -> Array:
        """Return a column as numbers where some cells are spaces, or say which is no number."""
        values = np.full(len(self.line), np.nan)
        for row, cell in enumerate(self.words(name).tolist()):
            try:
                values[row] = _number(cell or "nan")
            except ValueError:
                wanted = "a number or blank"
                if "," in cell:
                    wanted = "a number with a decimal point"
                elif ":" in cell:
                    wanted = "a number with decimals (--columns '...|dms' reads colons)"
                wrong = f"{name} is {cell!r}, expected {wanted}"
                raise self.error(wrong, row) from None
        return values

    def numbers_or_words(self, name: str) -> NDArray[Any]:
        """Return a column as numbers if all its cells are, else as text."""
        try:
            return self.numbers(name)
        except BadInput:
            return self.words(name)

    def seconds(self, name: str) -> Array:
        """Return times as seconds (UTC) since 1970, NaN where blank.

        Raises `BadInput`: a cell is neither blank nor a time as `seconds_of` reads it, or one that
          no telescope has recorded.
        """
        values = self._seconds(name)
        if np.any(beyond := (values < EARLIEST_S) | (values >= LATEST_S)):
            row = int(np.argmax(beyond))
            word = str(self.columns[name][row]).strip()
            raise self.error(f"{name} is {word!r}, expected a time {SINCE}", row)
        return values

    def _seconds(self, name: str) -> Array:
        cells = self.columns[name]
        if isinstance(cells, TextColumn):
            if (values := cells.seconds()) is not None:
                return values
            cells = np.asarray(cells)
        if cells.dtype.kind == "M":
            return since_1970(cells)
        text = self.words(name)
        seconds = np.full(len(text), np.nan)
        for row, cell in enumerate(text.tolist()):
            if not cell:
                continue
            try:
                seconds[row] = seconds_of(cell)
            except ValueError:
                raise self.error(f"{name} is {cell!r}, expected {a_time(cell)}", row) from None
        return seconds

    def hours(self, name: str) -> Array:
        """Return hours of the day, which are numbers or h:m:s, NaN where blank.

        Raises `BadInput`: a cell is neither.
        """
        cells = self.columns[name]
        if cells.dtype.kind in "fiub" or not any(":" in str(cell) for cell in cells.tolist()):
            return self.numbers(name)
        values = np.full(len(self.line), np.nan)
        for row, cell in enumerate(self.words(name).tolist()):
            try:
                values[row] = hours_of(cell or "nan")
            except ValueError:
                raise self.error(f"{name} is {cell!r}, expected hours or h:m:s", row) from None
        return values

    def refuse(self, wrong: NDArray[np.bool_], message: str) -> None:
        """Raise `BadInput` at the first row where `wrong` holds."""
        if wrong.any():
            raise self.error(message, int(np.argmax(wrong)))


def since_1970(moments: NDArray[np.datetime64]) -> Array:
    """Return times as seconds since 1970, NaN where there is none."""
    since = moments.astype("datetime64[us]").astype(float) / 1e6
    return np.where(np.isnat(moments), np.nan, since)


def seconds_of(moment: str | datetime) -> float:
    """Return a time as seconds since 1970; UTC unless it tells a zone.

    Text is ISO 8601, or has the day as `2024.001.18:00:00` (of the year), `01.02.2024` or
    `01-feb-2024`.

    Raises `ValueError`: the text is none.
    """
    instant = _instant(moment.strip()) if isinstance(moment, str) else moment
    return (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).timestamp()


#: A day of the year with a time: without one it could be a year with decimals.
_DAY_OF_YEAR = re.compile(r"(\d{4})\.(\d{3})\.(\d\d:\d\d.*)")
#: Points between digits, or the name of the month: others do not say which is the month.
_DAY_FIRST = re.compile(r"(\d\d?)(?:\.(\d\d?)\.|[- ]([a-z]{3})[- ])(\d{4})(.*)", re.IGNORECASE)
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")


def _instant(text: str) -> datetime:
    if found := _DAY_OF_YEAR.fullmatch(text):
        year, day, clock = found.groups()
        first = datetime.fromisoformat(f"{year}-01-01T{clock}")
        instant = first + timedelta(days=int(day) - 1)
        if instant.year != first.year:
            raise ValueError(text)
        return instant
    if found := _DAY_FIRST.fullmatch(text):
        date, number, name, year, clock = found.groups()
        month = int(number) if number else 1 + _MONTHS.index(name.lower())
        text = f"{year}-{month:02d}-{int(date):02d}{clock}"
    return datetime.fromisoformat(text)


def _number(text: Any) -> float:  # noqa: ANN401 - text, or what a table holds
    """Return a cell as a number; Python reads 1_0 and the digits of every script besides."""
    if isinstance(text, str) and ("_" in text or not text.isascii()):
        raise ValueError(text)
    return float(text)


_NUMBER = re.compile(r"\d+(\.\d*)?")
#: From 1973 on: smaller numbers count no seconds since 1970.
_COUNTED_S = 1e8


def a_time(instead: str) -> str:
    """Return what was expected instead of a text that is no time."""
    more = ": day and month could be exchanged" if "/" in instead else ""
    if _NUMBER.fullmatch(instead):
        for part, (of_1970, unit) in COUNTED.items():
            if _COUNTED_S <= unit * (float(instead) - of_1970) < LATEST_S:
                more = f" (--columns '...|{part}' reads such numbers)"
    return f"ISO 8601 such as 2003-06-01T18:37:12Z{more}"


_COLONS = re.compile(r"([-+]?)(\d{1,3}):([0-5]?\d)(?::([0-5]?\d(?:\.\d*)?))?")


def sexagesimal(text: str) -> float:
    """Return the degrees of d:m:s or the hours of h:m:s, seconds or none.

    Raises `ValueError`: the text is neither.
    """
    found = _COLONS.fullmatch(text)
    if found is None:
        raise ValueError(text)
    sign, whole, minutes, seconds = found.groups()
    value = int(whole) + int(minutes) / 60 + float(seconds or 0) / 3600
    return -value if sign == "-" else value


def hours_of(text: str) -> float:
    """Return the hours of a number or of h:m:s.

    Raises `ValueError`: the text is neither.
    """
    return sexagesimal(text) if ":" in text else float(text)


def is_hours(text: str) -> bool:
    """Tell whether a text is an hour of the day, as `hours_of` reads it."""
    try:
        return 0 <= hours_of(text) <= 24
    except ValueError:
        return False


def without_blanks(name: str, values: Array, blank: list[str]) -> Array:
    """Return a column's numbers, NaN where one says that nothing was measured.

    What is outside the Earth's weather, and nines alone that are further from all other numbers
    than these are apart. In how many rows is added to `blank`.
    """
    if name in WEATHER:
        low, high = WEATHER[name]
        none, why = (values < low) | (values > high), f"{name} outside {WEATHER[name]}"
    else:
        none = np.isin(np.abs(values), NINES)
        others = values[~none & np.isfinite(values)]
        if not none.any() or not len(others):
            return values
        low, high, apart = others.min(), others.max(), np.ptp(others)
        none &= (values < low - apart) | (values > high + apart)
        why = f"{name} of {', '.join(f'{one:g}' for one in np.unique(values[none]))}"
    if not none.any():
        return values
    count = int(none.sum())
    blank.append(f"{why} in {count} row{'s' * (count > 1)}")
    return np.where(none, np.nan, values)
