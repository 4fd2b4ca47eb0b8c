"""Files of text, read as UTF-8 within limits: their lines, and the numbers in them."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pyport.errors import BadInput
from pyport.recordings.raw import Raw

#: Digits are kept as they stand, so no line may make them endless.
LONGEST_NUMBER = 40
#: Power of ten beyond which a decimal number is no measurement, either way.
LARGEST_POWER = 99


class Line(NamedTuple):
    """A line of a file, where it stands, and what it says."""

    file: Path
    number: int
    text: str

    @property
    def words(self) -> list[str]:
        """Return what stands between blanks."""
        return self.text.split()

    def error(self, message: str) -> BadInput:
        """Return an error that names this line."""
        return BadInput(message, self.file, self.number)

    def decimal(self, word: str, what: str) -> Decimal:
        """Return a number as it stands, digit for digit.

        Raises `BadInput`: it is no finite number, or longer than any measurement is.
        """
        try:
            value = Decimal(word)
        except InvalidOperation:
            value = Decimal("nan")
        if not is_measured(value) or len(word) > LONGEST_NUMBER:
            raise self.error(f"{what} is {word[:60]!r}, expected a number")
        return value


def is_measured(value: Decimal) -> bool:
    """Tell whether a number may be a measurement: a finite one, of no power of ten beyond all."""
    return value.is_finite() and abs(value.adjusted()) <= LARGEST_POWER


def lines_of(path: Path) -> list[Line]:
    """Return all lines of a text file.

    Raises `BadInput`: the file is empty or is no text.
    """
    return [Line(path, n, text) for n, text in enumerate(read_text(path).splitlines(), 1)]


def spelled(value: Decimal) -> str:
    """Return a decimal number without an exponent, digit for digit."""
    text = str(value)  # four times as fast, and without an exponent for nearly all numbers
    return text if "E" not in text else format(value, "f")


def padded(value: Decimal, width: int, decimals: int, sign: str = "") -> str:
    """Return a number of some width with at least so many decimals, and all that it has."""
    exponent = value.as_tuple().exponent
    own = -exponent if isinstance(exponent, int) else 0
    return f"{value:{sign}{width}.{max(decimals, own)}f}"


def raw_of(
    path: Path, meta: dict[str, str], columns: dict[str, list[str]], lines: list[int], header: int
) -> Raw:
    """Return cells of text, as they stand, for the interpretation that all formats share."""
    cells = {name: np.array(column, object) for name, column in columns.items()}
    return Raw(path, meta, header, cells, np.array(lines, np.int64))


_BLOCK = 2**20
#: Nothing that a telescope writes is larger; a file may be anything at all.
LONGEST_LINE, LARGEST_TEXT, MOST_COLUMNS = 16 * 2**20, 2**30, 10_000

#: How files begin that are no text, and what is said of them: nothing is unpacked here.
_NO_TEXT = {
    b"\x1f\x8b": "packed by gzip, expected it unpacked: gunzip it",
    b"SIMPLE  =": "a FITS file, expected a table as text: of one that holds a table, "
    "astropy's Table.read('FILE.fits').write('FILE.ecsv') makes it",
}


#: A line of a log of the Field System: its time, and what is no cell of a table.
_FS_LOG = re.compile(rb"^\d{4}\.\d{3}\.\d\d:\d\d:\d\d\.\d\d([#&/:?$]|;Log Opened)", re.MULTILINE)
#: It begins with some header lines of its own.
_BEGINNING = 2**12


def refuse_packed(path: Path) -> None:
    """Refuse a file that begins as gzip, FITS or a log does, with what to do about it."""
    with path.open("rb") as file:
        beginning = file.read(_BEGINNING)
    for begins, wrong in _NO_TEXT.items():
        if beginning.startswith(begins):
            raise BadInput(wrong, path)
    if _FS_LOG.search(beginning):
        wanted = "expected the .xtr file that its program xtrac extracts from the log"
        raise BadInput(f"a log of the VLBI Field System, {wanted}", path)


def is_separator(line: str) -> bool:
    """Tell whether a line is the one that Excel takes the separator from, such as `sep=,`."""
    return re.fullmatch(r"sep=[,;|]?", line.strip(), re.IGNORECASE) is not None


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file, with or without a byte-order mark.

    Raises `BadInput`: the file is empty, is no text, or is larger or has a longer line than any
      that a telescope fills; of such a one no more is read than tells so.
    """
    refuse_packed(path)
    content = _content(path)
    place = content.find(b"\0")
    if place < 0:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            place = error.start
        else:
            if not text or text.isspace():
                raise BadInput("the file is empty, expected text", path)
            return text
    line = content.count(b"\n", 0, place) + 1
    wrong = "this is a binary file or text in another encoding (Latin-1, UTF-16, ...)"
    raise BadInput(f"{wrong}, expected UTF-8", path, line)


def _content(path: Path) -> bytes:
    """Return the bytes of a text file, refused as soon as a line or the whole is too long."""
    blocks: list[bytes] = []
    size = since_break = 0
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            last = max(block.rfind(b"\n"), block.rfind(b"\r"))
            since_break = since_break + len(block) if last < 0 else len(block) - 1 - last
            size += len(block)
            blocks.append(block)
            if since_break > LONGEST_LINE:
                wrong = f"a line of more than {LONGEST_LINE // 2**20} MB, expected one a recording"
                break
            if size > LARGEST_TEXT:
                wrong = f"a text of more than {LARGEST_TEXT // 2**20} MB, expected several files"
                wrong = f"{wrong}, or Parquet"
                break
        else:
            return b"".join(blocks)
    raise BadInput(wrong, path, sum(block.count(b"\n") for block in blocks) + 1)
