"""The binary table: little-endian, checked by a CRC, lossless to the ASCII table's digits.

======  =========  ==================================================================
offset  type       content
======  =========  ==================================================================
0       char[8]    ``PYPORTST``
8       int32      version of the layout, 1
12      int32      length of this header in bytes, 512
16      int32 x 2  number of azimuths n and of zenith distances m
24      float64    first azimuth and its step, first zenith distance and its step [deg]
56      float64    the unit of the offsets, 1e-7 deg
64      char[64]   model, filled with blanks
128     char[64]   refraction
192     char[32]   when it was made, ISO 8601
224     char[32]   the program that made it, with its version
256     char[32]   reading: how the model was evaluated
288     byte[224]  zero
512     int32      azimuth offsets, n rows of m, then zenith-distance offsets likewise
end-4   int32      CRC-32 (ISO-HDLC, zlib's) of every byte before it
======  =========  ==================================================================
"""

from __future__ import annotations

import datetime as dt
import os
import struct
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import pyport
from pyport.errors import BadInput
from pyport.files import write_file
from pyport.steering.grid import UNITS_PER_DEG, Grid, Table

MAGIC = b"PYPORTST"
VERSION = 1
HEADER = struct.Struct("<8siiii5d64s64s32s32s32s224x")
_CRC = struct.Struct("<I")


def write_binary(table: Table, path: str | Path) -> None:
    """Write the table; with SOURCE_DATE_EPOCH set the same table gives the same bytes.

    Raises
    ------
    BadInput
        The grid's steps are not equal, or an offset does not fit.
    """
    table.grid.check(path)
    steps_deg = table.grid.steps_deg()
    header = HEADER.pack(
        MAGIC,
        VERSION,
        HEADER.size,
        len(table.grid.az_deg),
        len(table.grid.zd_deg),
        table.grid.az_deg[0],
        steps_deg[0],
        table.grid.zd_deg[0],
        steps_deg[1],
        1 / UNITS_PER_DEG,
        _text(table.model, 64),
        _text(table.refraction, 64),
        _text(_now().isoformat(timespec="seconds"), 32),
        _text(f"pyport {pyport.__version__}", 32),
        _text(table.reading, 32),
    )
    body = header + _stored(table, path)
    write_file(path, body + _CRC.pack(zlib.crc32(body)))


@dataclass(frozen=True)
class Mapped:
    """A binary table in place: what its header says, and its offsets still in the file.

    `units` has shape (2, azimuths, zenith distances), azimuth offsets first, in whole
    units of `unit_deg`.
    """

    grid: Grid
    units: NDArray[np.int32]
    unit_deg: float
    model: str
    refraction: str
    reading: str


def map_binary(path: str | Path) -> Mapped:
    """Check a table's every byte and map its offsets into memory.

    Raises
    ------
    BadInput
        The file is no such table, is of another version, cut short, or damaged.
    """
    found = _checked(path)
    shape = found.units.shape
    units = np.memmap(path, dtype="<i4", mode="r", offset=HEADER.size, shape=shape)
    return replace(found, units=units)


def read_binary(path: str | Path) -> Table:
    """Read a table; raises `BadInput` as :func:`map_binary` does."""
    found = _checked(path)
    d_az_deg, d_zd_deg = found.units / round(1 / found.unit_deg)
    return Table(found.grid, d_az_deg, d_zd_deg, found.model, found.refraction, found.reading)


def _checked(path: str | Path) -> Mapped:
    """Return a table as it was read, every byte of it checked."""
    data = memoryview(Path(path).read_bytes())
    if len(data) < HEADER.size + _CRC.size or data[: len(MAGIC)] != MAGIC:
        raise BadInput("is no binary steering table: it does not begin with PYPORTST", path)
    _, version, length, n, m, *rest = HEADER.unpack_from(data)
    if version != VERSION:
        raise BadInput(f"has layout version {version}, version {VERSION} was expected", path)
    expected = HEADER.size + 8 * n * m + _CRC.size
    if length != HEADER.size or n < 1 or m < 1 or len(data) != expected:
        raise BadInput(f"is {len(data)} bytes long, its header promises {expected}", path)
    body, crc = data[: -_CRC.size], data[-_CRC.size :]
    if zlib.crc32(body) != _CRC.unpack(crc)[0]:
        raise BadInput("is damaged: its checksum does not fit its content", path)
    az_first, az_step, zd_first, zd_step, unit_deg, model, refraction, _, _, reading = rest
    grid = Grid(az_first + az_step * np.arange(n), zd_first + zd_step * np.arange(m))
    units = np.frombuffer(body[HEADER.size :], "<i4").reshape(2, n, m)
    return Mapped(grid, units, unit_deg, _plain(model), _plain(refraction), _plain(reading))


def _stored(table: Table, path: str | Path) -> bytes:
    """Return the offsets as the file holds them."""
    units = table.units()
    if not np.all(np.abs(units) < 2**31):
        raise BadInput("an offset of 214 deg or more does not fit the binary table", path)
    return units.astype("<i4").tobytes()


def _plain(text: bytes) -> str:
    return text.decode("ascii").rstrip()


def _text(text: str, length: int) -> bytes:
    """Return text filled with blanks; of a longer one the beginning, with dots that say so."""
    if len(text) > length:
        text = text[: length - 3] + "..."
    return text.encode("ascii", "replace").ljust(length)


def _now() -> dt.datetime:
    """Return the time, or the one that a reproducible build asks for."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch is None:
        return dt.datetime.now(dt.UTC)
    return dt.datetime.fromtimestamp(int(epoch), dt.UTC)
