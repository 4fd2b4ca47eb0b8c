"""The pointing offsets that are measured with katpoint: CSV below an antenna's description.

Degrees; azimuth offsets as a coordinate, what has to be added to point right,
that is encoder minus true. A standard deviation of zero stands for none.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path

from pyport.columns import SET_ASIDE
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats import exact
from pyport.recordings.formats.text import Line, lines_of, raw_of, spelled
from pyport.recordings.naming import comment
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Table

#: Its columns -> the contract's.
COLUMNS = {
    "dataset": "session",
    "target": "source",
    "timestamp_ut": "time_utc",
    "azimuth": "az_deg",
    "elevation": "el_deg",
    "delta_azimuth": "d_az_deg",
    "delta_azimuth_std": "sigma_az_deg",
    "delta_elevation": "d_el_deg",
    "delta_elevation_std": "sigma_el_deg",
    "temperature": "temperature_c",
    "pressure": "pressure_hpa",
    "humidity": "humidity_pct",
    "wind_speed": "wind_speed_m_s",
    "wind_direction": "wind_az_deg",
    "sun_az": "sun_az_deg",
    "sun_el": "sun_el_deg",
}
_OURS = {ours: theirs for theirs, ours in COLUMNS.items()}
_NEEDED = ("azimuth", "elevation", "delta_azimuth", "delta_elevation")
_SIGMAS = frozenset({"sigma_az_deg", "sigma_el_deg"})
ANTENNA = "katpoint_antenna"
#: Where an antenna's description has its pointing model.
MODEL_FIELD = 6
#: What a description says of the place, in its order.
PLACE = ("latitude_deg", "longitude_deg", "height_m")
#: What the first three lines of such a file fit into [bytes]; a line may also be endless.
_HEAD = 2**16
#: What MeerKAT writes behind the name of a session; it is a label of its own.
_SCAN = re.compile(r"(.*\S)\s+(scan \d+)")
SCAN = "scan"
#: A column that says 0 where a row is not to be kept.
KEEP, NOT_KEPT = "keep", "not kept in the file"


def angle(line: Line, text: str) -> Decimal:
    """Return D:M:S, or plain degrees, in arcseconds, digit for digit."""
    parts = text.split(":")
    if len(parts) not in {1, 3}:
        raise line.error(f"the angle is {text[:40]!r}, expected D:M:S or degrees")
    numbers = [line.decimal(part, "the angle") for part in parts]
    whole = [*map(abs, numbers), Decimal(0), Decimal(0)]
    arcsec = whole[0] * 3600 + whole[1] * 60 + whole[2]
    return -arcsec if text.strip().startswith("-") else arcsec


def looks_like(path: Path) -> bool:
    """Tell whether a CSV file is one of these: by its first line, or by its columns."""
    with path.open("rb") as file:
        head = file.read(_HEAD).decode("utf-8", "replace").splitlines()[:3]
    if not head:
        return False
    names = next((line for line in head if not line.startswith("#")), "")
    return head[0].startswith("# antenna =") or "delta_azimuth" in map(str.strip, names.split(","))


def read(path: Path) -> Raw:
    """Read the cells of such a file.

    Raises `BadInput`: there is no line of names, no rows, or a row of another length.
    """
    meta: dict[str, str] = {}
    rows: list[tuple[int, list[str]]] = []
    for line in lines_of(path):
        if line.text.startswith("#"):
            key, equals, value = line.text[1:].partition("=")
            if equals and key.strip() == "antenna":
                meta |= _antenna(Line(path, line.number, value))
            elif pair := comment(line.text):
                meta[pair[0]] = pair[1]
        elif line.text.strip():
            if '"' in line.text:
                (words,) = csv.reader([line.text], skipinitialspace=True)
            else:
                words = line.text.split(",")
            rows.append((line.number, [word.strip() for word in words]))
    if not rows:
        raise BadInput("no line of column names, expected azimuth, elevation, ...", path)
    (header, names), *body = rows
    _check(header, names, body, path)
    cells = dict(zip(names, zip(*(words for _, words in body), strict=True), strict=True))
    kept = cells.pop(KEEP, None)
    columns = {_name(name): _measured(_name(name), words) for name, words in cells.items()}
    scans = [_SCAN.fullmatch(word) for word in columns.get("session", ())]
    if SCAN not in columns and any(scans):
        sessions = zip(columns["session"], scans, strict=True)
        columns["session"] = [word if scan is None else scan[1] for word, scan in sessions]
        columns[SCAN] = ["" if scan is None else scan[2] for scan in scans]
    if kept is not None:
        columns[SET_ASIDE] = ["" if word not in {"0", "False"} else NOT_KEPT for word in kept]
    return raw_of(path, meta, columns, [number for number, _ in body], header)


def _check(header: int, names: list[str], body: list[tuple[int, list[str]]], path: Path) -> None:
    """Refuse a table without the columns or rows that it needs, or with a row of another length."""
    missing = [name for name in _NEEDED if name not in names]
    if missing or len(set(names)) < len(names):
        wrong = f"no column {', '.join(missing)}" if missing else "two columns of one name"
        raise BadInput(f"{wrong}, expected katpoint's names, each once", path, header)
    if not body:
        raise BadInput("no rows below the column names", path, header)
    for number, words in body:
        if len(words) != len(names):
            count = f"{len(words)} cells, expected {len(names)} as in the header"
            raise BadInput(count, path, number)


def _name(theirs: str) -> str:
    return COLUMNS.get(theirs, theirs)


def _measured(name: str, words: Sequence[str]) -> list[str]:
    """Return a column's cells, blank where they are no measurements."""
    if name in _SIGMAS:
        return [word if exact.number(word) else "" for word in words]
    return ["" if word.lower() == "nan" else word for word in words]


def _antenna(line: Line) -> dict[str, str]:
    fields = [part.strip() for part in line.text.split(",")]
    meta = {ANTENNA: line.text.strip()}
    if len(fields) < 4:
        return meta
    meta["telescope"] = fields[0]
    for key, text in zip(PLACE[:2], fields[1:3], strict=True):
        degrees = angle(line, text) / 3600
        if abs(degrees) > 360:
            raise line.error(f"{key} is {text!r}, expected at most 360 degrees")
        meta[key] = spelled(exact.plain(degrees.quantize(Decimal("1e-9"))))
    return meta | {"height_m": spelled(line.decimal(fields[3], "the height"))}


def write(table: Table, path: Path) -> exact.Written:
    """Write such a file; nothing is left out, since it keeps any column.

    Raises `BadInput`: the table lacks a position or an offset.
    """
    az, el = exact.position(table, path)
    d_az, d_el = exact.offsets(table, path)
    size = len(az)
    sigma_az = exact.coordinate(table, "sigma_az", "sigma_xel", path) or [None] * size
    sigma_el = exact.in_degrees(table, "sigma_el") or [None] * size
    columns = {
        "azimuth": _texts(az, "nan"),
        "elevation": _texts(el, "nan"),
        "delta_azimuth": _texts(d_az, "nan"),
        "delta_azimuth_std": _texts(sigma_az, "0"),
        "delta_elevation": _texts(d_el, "nan"),
        "delta_elevation_std": _texts(sigma_el, "0"),
    }
    first: dict[str, list[str]] = {}
    for name in exact.left_out(table, (*exact.OFFSETS_HELD, *exact.SIGMAS_HELD)):
        goes_first = _OURS.get(name) in {"dataset", "target", "timestamp_ut"}
        (first if goes_first else columns)[_OURS.get(name, name)] = exact.cells(table, name)
    columns = first | columns
    scans = columns.get(SCAN, ["none"])
    if "dataset" in columns and all(one.startswith(SCAN) for one in scans if one):
        both = zip(columns["dataset"], scans, strict=True)
        del columns[SCAN]
        columns["dataset"] = [f"{session} {scan}".rstrip() for session, scan in both]
    if any(exact.asides(table)):
        columns[KEEP] = ["0" if why else "1" for why in exact.asides(table)]
    antenna = table.meta.get(ANTENNA) or _description(table)
    of_antenna = _antenna(Line(path, 1, antenna))
    with write_whole(path) as out:
        out.write(f"# antenna = {antenna}\n")
        # a description without one of them has none: katpoint passes over these lines
        out.writelines(
            f"# {key}: {table.meta[key]}\n"
            for key in PLACE
            if key in table.meta and key not in of_antenna
        )
        out.write(", ".join(columns) + "\n")
        for row in zip(*columns.values(), strict=True):
            out.write(", ".join(cell.replace(",", ";") for cell in row) + "\n")
    return exact.Written()


def _texts(values: exact.Numbers, blank: str) -> list[str]:
    return [blank if value is None else spelled(value) for value in values]


def _description(table: Table) -> str:
    """Return the description of an antenna: its name alone where its place is not known."""
    name = table.meta.get("telescope", "antenna").replace(",", " ")
    if not {"latitude_deg", "longitude_deg"} <= table.meta.keys():
        return name
    place = [table.meta.get(key, "0") for key in PLACE]
    fields = [name, *place]
    return ", ".join([*fields, *[""] * (MODEL_FIELD - len(fields)), "", ""])
