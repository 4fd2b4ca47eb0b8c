"""A log that grows, read line by line: half-written lines, rotation, truncation, restarts.

Text with one row a line is read as it grows. Files of other formats are read anew when they change,
and the rows that were there before are left out. Of a folder the files are read one after the
other in the order of their names; the last one grows.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.recordings.files import read_raw
from pyport.recordings.formats import katpoint_csv
from pyport.recordings.formats import registry as tables
from pyport.recordings.interpret import interpret
from pyport.recordings.notes import sentences
from pyport.recordings.raw import FileOptions
from pyport.recordings.schema import Recordings, SetAside

#: Rows that are taken in together: after them the state is kept.
BATCH = 100
#: So many bytes before where reading stopped tell whether the file is still the same.
FINGERPRINT = 256
#: No more than this is read of a log at once [bytes].
BLOCK = 2**20


@dataclass(frozen=True)
class Cursor:
    """How far a log was read."""

    file: str = ""  #: name of the file, of a folder that of the last one begun
    #: `inode`, `offset`, `fingerprint`: which file it is, the byte that comes next, and a hash of
    #: those before it.
    inode: int = 0
    offset: int = 0
    fingerprint: str = ""
    lines: int = 0  #: lines read so far, or rows of a file that is read as a whole
    header: str = ""  #: the lines above the rows
    changed: float = 0.0  #: time of the last change of a file that is read as a whole


@dataclass(frozen=True)
class Batch:
    """What was read: recordings, rows that cannot be used, and how far the log was read."""

    recordings: Recordings | None
    skipped: tuple[SetAside, ...]
    cursor: Cursor
    #: What the recordings say against themselves, by kind: see `pyport.recordings.notes`.
    notes: Mapping[str, str] = field(default_factory=dict)


def new(path: Path, given: FileOptions, cursor: Cursor, size: int = BATCH) -> Iterator[Batch]:
    """Yield what a log has that was not read before; nothing where it has not grown.

    `path` is a file, or a folder of files of one format; `size` rows are yielded at once.

    Raises `BadInput`: there is no such log, or it is not of the format that its name says.
    """
    if not path.is_dir():
        yield from _file(path, given, cursor, size)
        return
    some = (one for one in path.iterdir() if one.is_file() and not one.name.startswith("."))
    left = sorted(one for one in some if one.name >= cursor.file)
    for one in left:
        if one.name != cursor.file:
            cursor = Cursor(one.name)
        for batch in _file(one, given, cursor, size, ended=one != left[-1]):
            cursor = batch.cursor
            yield batch


def _file(
    path: Path, given: FileOptions, cursor: Cursor, size: int, *, ended: bool = False
) -> Iterator[Batch]:
    """Read what a file has beyond the cursor; one that has `ended` grows no more."""
    cursor = replace(cursor, file=path.name)
    if _by_line(path, given):
        yield from _lines(path, given, cursor, size, ended=ended)
    else:
        yield from _whole(path, given, cursor, size)


def _by_line(path: Path, given: FileOptions) -> bool:
    """Tell whether a file is text with a line of names at most above its rows."""
    if given.format:
        return given.format == "csv"
    known = tables.BY_SUFFIX.get(path.suffix.lower())
    if known is None:
        return bool(given.mapping or given.columns)
    return known.name == "csv" and not (path.is_file() and katpoint_csv.looks_like(path))


def _whole(path: Path, given: FileOptions, cursor: Cursor, size: int) -> Iterator[Batch]:
    """Read a file that cannot be read by the line; a file with fewer rows is another one."""
    try:
        changed = path.stat().st_mtime
    except FileNotFoundError:
        return
    if changed == cursor.changed:
        return
    try:
        raw = read_raw(path, given)
        recordings = interpret(raw)
    except (BadInput, OSError):
        if cursor.lines:
            return  # it is being written
        raise
    total = len(recordings)
    done = cursor.lines if total >= cursor.lines else 0
    if done == total:
        yield Batch(None, (), replace(cursor, changed=changed))
    notes = sentences(recordings, raw) if done < total else {}
    for first in range(done, total, size):
        last = min(first + size, total)
        at = changed if last == total else cursor.changed
        part = recordings.take(np.arange(first, last))
        aside = recordings.set_aside if first == 0 else ()
        yield Batch(part, aside, replace(cursor, lines=last, changed=at), notes)


def _lines(
    path: Path, given: FileOptions, cursor: Cursor, size: int, *, ended: bool
) -> Iterator[Batch]:
    """Read the whole lines that a file has beyond where it was read."""
    if cursor.inode:
        try:
            there = path.stat()
        except FileNotFoundError:
            there = None
        if there is None or there.st_ino != cursor.inode:
            former = _renamed(path, cursor.inode)
            if there is not None and _goes_on(path, former, cursor):
                cursor = replace(cursor, inode=there.st_ino)
            else:
                if former is not None:
                    for batch in _beyond(former, path, given, cursor, size, ended=True):
                        cursor = batch.cursor
                        yield batch
                if there is None:
                    return
                cursor = Cursor(path.name)
        elif not _same(path, cursor):
            cursor = Cursor(path.name)
    if path.is_file():
        yield from _beyond(path, path, given, cursor, size, ended=ended)


def _renamed(path: Path, inode: int) -> Path | None:
    """Return what a log that was rotated is called now, None where it is gone."""
    for one in path.parent.iterdir():
        if one != path and one.is_file() and one.stat().st_ino == inode:
            return one
    return None


def _goes_on(path: Path, former: Path | None, cursor: Cursor) -> bool:
    """Tell whether a file that took a log's place is a longer copy of it, as rsync leaves one.

    `former` is the log under another name, None where it is gone.
    """
    if not _same(path, cursor):
        return False
    if former is None:
        return True
    size = former.stat().st_size
    with path.open("rb") as copy, former.open("rb") as file:
        return _fingerprint(copy, size) == _fingerprint(file, size)


def _same(path: Path, cursor: Cursor) -> bool:
    """Tell whether a file still begins as it did when it was read."""
    with path.open("rb") as file:
        return _fingerprint(file, cursor.offset) == cursor.fingerprint


def _fingerprint(file: Any, offset: int) -> str:  # noqa: ANN401 - a file of bytes
    """Return a hash of what stands before a byte; of a shorter file another one."""
    file.seek(max(0, offset - FINGERPRINT))
    before = file.read(min(FINGERPRINT, offset))
    if len(before) < min(FINGERPRINT, offset):
        return "shorter"
    return hashlib.sha256(before).hexdigest()[:16]


def _beyond(
    path: Path, log: Path, given: FileOptions, cursor: Cursor, size: int, *, ended: bool
) -> Iterator[Batch]:
    """Yield the whole lines of a file from the cursor on; `log` is what it was called first.

    A line that nothing ends may be half of one, but not in a file that has `ended`.
    """
    with path.open("rb") as file:
        inode = os.fstat(file.fileno()).st_ino
        while True:
            file.seek(cursor.offset)
            block = file.read(BLOCK)
            whole = block[: block.rfind(b"\n") + 1]
            if ended and not whole and len(block) < BLOCK:
                whole = block
            if not whole:
                if len(block) == BLOCK:
                    wrong = f"a line of more than {BLOCK // 2**20} MB, expected one a recording"
                    raise BadInput(wrong, path, cursor.lines + 1)
                return
            pieces = whole.splitlines(keepends=True)
            for some in _together(pieces, size, cursor.header, given):
                offset = cursor.offset + sum(map(len, some))
                text = [one.decode("utf-8-sig", errors="replace") for one in some]
                header, rows = _split(cursor, text, given)
                read = _read(log, given, header, rows, cursor.lines, len(text))
                recordings, skipped, notes = read
                cursor = Cursor(
                    cursor.file,
                    inode,
                    offset,
                    _fingerprint(file, offset),
                    cursor.lines + len(text),
                    header,
                )
                if recordings is not None or skipped or cursor.header:
                    yield Batch(recordings, skipped, cursor, notes)


def _together(
    pieces: list[bytes], size: int, header: str, given: FileOptions
) -> Iterator[list[bytes]]:
    """Yield lines that are read together, at most `size`; with a line of names others begin."""
    some: list[bytes] = []
    named = bool(_names(header) or given.columns or given.mapping)
    for piece in pieces:
        again = False
        if not named or piece[:1].isalpha():
            line = piece.decode("utf-8-sig", errors="replace")
            again = _named_anew(header, line, given)
            header = line if again else header if named else header + line
            named = named or bool(_names(header))
        if some and (again or len(some) == size):
            yield some
            some = []
        some.append(piece)
    if some:
        yield some


def _names(header: str) -> set[str]:
    """Return the names of the columns below a header's comments, none where it has no such line."""
    lines = [one for one in header.splitlines() if one.strip() and not one.startswith("#")]
    return {one.strip() for one in lines[-1].split(",")} if lines else set()


def _named_anew(header: str, line: str, given: FileOptions) -> bool:
    """Tell whether a line among the rows names columns, as a program does that was started anew."""
    if given.columns or given.mapping or _has_number(line):
        return False
    names = _names(header)
    return 2 * len(names & _names(line)) > max(len(names), 1)


def _split(cursor: Cursor, text: list[str], given: FileOptions) -> tuple[str, list[str]]:
    """Return the header, completed by lines that belong to it, and the lines of rows."""
    header, rows = cursor.header, list(text)
    complete = bool(_names(header))
    if rows and _named_anew(header, rows[0], given):
        above = header.splitlines(keepends=True)
        header = "".join(one for one in above if one.startswith("#") or not one.strip())
        header += rows.pop(0)
    while rows and not complete:
        line = rows[0]
        if line.startswith("#") or not line.strip():
            header += line
            rows.pop(0)
            continue
        named = not given.columns and not _has_number(line)
        if named:
            header += line
            rows.pop(0)
        break
    return header, rows


def _has_number(line: str) -> bool:
    """Tell whether a line of cells is a row of numbers and no line of names."""
    for cell in line.replace(",", " ").replace(";", " ").split():
        try:
            float(cell)
        except ValueError:
            continue
        return True
    return False


def _read(
    path: Path, given: FileOptions, header: str, rows: list[str], lines: int, count: int
) -> tuple[Recordings | None, tuple[SetAside, ...], Mapping[str, str]]:
    """Return the recordings in some lines; where they cannot be read together, one by one.

    With them come the lines that were excluded, and what the others say against themselves.
    """
    first = lines + count - len(rows) + 1
    if not any(one.strip() and not one.startswith("#") for one in rows):
        return None, (), {}
    try:
        found, notes = _interpreted(path, given, header, rows)
    except BadInput as error:
        if len(rows) == 1:
            return None, (SetAside(first, error.message),), {}
        parts = [
            _read(path, given, header, [one], lines + n, count - len(rows) + 1)
            for n, one in enumerate(rows)
        ]
        good = [one for one, *_ in parts if one is not None]
        excluded = tuple(one for _, some, _ in parts for one in some)
        notes = {kind: text for *_, some in parts for kind, text in some.items()}
        return joined(good) if good else None, excluded, notes
    above = header.count("\n")
    aside = tuple(replace(one, line=one.line - above - 1 + first) for one in found.set_aside)
    if not len(found):
        return None, aside, notes
    return replace(found, line=found.line - above - 1 + first, set_aside=()), aside, notes


def _interpreted(
    path: Path, given: FileOptions, header: str, rows: list[str]
) -> tuple[Recordings, dict[str, str]]:
    """Read lines as a file of their own would be read, and call it by the log's name.

    Returns the recordings, and what they say against themselves.
    """
    with tempfile.TemporaryDirectory(prefix="pyport-") as folder:
        part = Path(folder) / path.name
        part.write_text(header + "".join(rows), encoding="utf-8", newline="")
        raw = read_raw(part, given)
    found = interpret(raw)
    return replace(found, file=path), sentences(found, raw)


def joined(some: list[Recordings]) -> Recordings:
    """Return recordings with the same columns as one."""
    first = some[0]
    rows = ("x", "y", "sigma_x", "sigma_y", "line")
    whole: dict[str, Any] = {k: np.concatenate([getattr(one, k) for one in some]) for k in rows}
    az, el = (np.concatenate([getattr(one.at, name) for one in some]) for name in ("az", "el"))
    names = first.at.columns
    columns = {name: np.concatenate([one.at.columns[name] for one in some]) for name in names}
    return replace(first, at=replace(first.at, az=az, el=el, columns=columns), **whole)
