"""Pointing data as the Field System extracts them (xtr), and as its fits repeat them (err).

Degrees: flag, azimuth, elevation, offsets in azimuth (as a coordinate) and
elevation, raw minus true, and their one-sigma errors. A flag of 1 means use it.
"""

from __future__ import annotations

from pathlib import Path

from pyport.columns import SET_ASIDE
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats import exact
from pyport.recordings.formats.lines import Line, raw_of, spelled
from pyport.recordings.formats.sections import section, sections
from pyport.recordings.raw import Raw
from pyport.recordings.tabulate import Table

#: Why a row whose flag is not 1 is not used.
FLAGGED = "flagged in the file"

XTR_COLUMNS = ("az_deg", "el_deg", "d_az_deg", "d_el_deg", "sigma_az_deg", "sigma_el_deg")
#: Least decimals of each.
_DIGITS = (5, 5, 7, 7, 7, 7)
ANTENNA = "field_system_antenna"
ERR_COLUMNS = XTR_COLUMNS[:4]


def read_xtr(path: Path) -> Raw:
    """Read the cells of an xtr file.

    Raises `BadInput`: no `$data`, or a line of it that is no recording.
    """
    found = sections(path)
    return _tabulated(path, section(found, "data", path), _antenna(found, path), XTR_COLUMNS)


def read_err(path: Path) -> Raw:
    """Read the observations that an err file repeats, rounded as it holds them.

    Raises `BadInput`: no `$observed`, or a line of it that is no recording.
    """
    found = sections(path)
    return _tabulated(path, section(found, "observed", path), _antenna(found, path), ERR_COLUMNS)


def write(table: Table, path: Path) -> list[str]:
    """Write recordings as an xtr file; return the columns that it has no place for.

    Raises `BadInput`: an axis or its errors are missing: the Field System weighs by them.
    """
    az, el = exact.position(table, path)
    sigma_az = exact.coordinate(table, "sigma_az", "sigma_xel", path)
    sigma_el = exact.in_degrees(table, "sigma_el")
    if sigma_az is None or sigma_el is None:
        raise BadInput("no errors sigma_xel_deg and sigma_el_deg, and this format holds them", path)
    columns = (az, el, *exact.offsets(table, path), sigma_az, sigma_el)
    decimals = [
        exact.decimals_of(column, least=least)
        for column, least in zip(columns, _DIGITS, strict=True)
    ]
    own = table.meta.get(ANTENNA)
    name = table.meta.get("telescope", "antenna").split() or ["antenna"]
    with write_whole(path) as out:
        out.write(f"$antenna\n {own or f'{name[0]} azel 1'}\n$data\n")
        for n, why in enumerate(exact.asides(table)):
            values = [column[n] for column in columns]
            if None in values:
                raise BadInput(f"row {n + 1} lacks a number, and this format holds them all", path)
            digits = zip(values, decimals, strict=True)
            words = [f"{value:{5 + count}.{count}f}" for value, count in digits]
            out.write(f" {0 if why else 1} {' '.join(words)}\n")
        out.write("$stats\n")
    return exact.left_out(table, (*exact.OFFSETS_HELD, *exact.SIGMAS_HELD))


def _antenna(found: dict[str, list[Line]], path: Path) -> dict[str, str]:
    """Return the telescope's name; a mount that is no alt-azimuth is refused."""
    (line, *_) = section(found, "antenna", path)
    words = line.words
    if len(words) < 2:
        raise line.error(f"this is {line.text.strip()[:60]!r}, expected a name and azel")
    if words[1].lower() not in {"azel", "xxxx"}:
        raise line.error(f"the axes are {words[1]!r}, expected azel")
    return {"telescope": words[0], ANTENNA: " ".join(words)}


def _tabulated(path: Path, lines: list[Line], meta: dict[str, str], names: tuple[str, ...]) -> Raw:
    columns: dict[str, list[str]] = {name: [] for name in (*names, SET_ASIDE)}
    for line in lines:
        flag, *words = line.words
        if len(words) < len(names):
            raise line.error(f"{len(words)} numbers behind the flag, expected {len(names)}")
        for name, word in zip(names, words, strict=False):
            columns[name].append(spelled(line.decimal(word, name)))
        if not flag.isdigit():
            raise line.error(f"the flag is {flag[:20]!r}, expected 1 or 0")
        columns[SET_ASIDE].append("" if int(flag) == 1 else FLAGGED)
    if not any(columns[SET_ASIDE]):
        del columns[SET_ASIDE]
    return raw_of(path, meta, columns, [line.number for line in lines], lines[0].number - 1)
