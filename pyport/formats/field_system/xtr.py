"""Pointing data as the Field System extracts them (xtr), and as its fits repeat them (err).

Degrees: flag, azimuth, elevation, offsets in azimuth (as a coordinate) and
elevation, raw minus true, and their one-sigma errors. A flag of 1 means use it.
"""

from __future__ import annotations

from pathlib import Path

from pyport.formats.field_system.sections import section, sections
from pyport.formats.lines import Line, raw_of, spelled
from pyport.recordings.columns import SET_ASIDE
from pyport.recordings.raw import Raw

#: Why a row whose flag is not 1 is not used.
FLAGGED = "flagged in the file"

XTR_COLUMNS = ("az_deg", "el_deg", "d_az_deg", "d_el_deg", "sigma_az_deg", "sigma_el_deg")
ERR_COLUMNS = XTR_COLUMNS[:4]


def read_xtr(path: Path) -> Raw:
    """Read the cells of an xtr file.

    Raises
    ------
    BadInput
        No `$data`, or a line of it that is no recording.
    """
    found = sections(path)
    return _tabulated(path, section(found, "data", path), _antenna(found, path), XTR_COLUMNS)


def read_err(path: Path) -> Raw:
    """Read the observations that an err file repeats, rounded as it holds them.

    Raises
    ------
    BadInput
        No `$observed`, or a line of it that is no recording.
    """
    found = sections(path)
    return _tabulated(path, section(found, "observed", path), _antenna(found, path), ERR_COLUMNS)


def _antenna(found: dict[str, list[Line]], path: Path) -> dict[str, str]:
    """Return the telescope's name; a mount that is no alt-azimuth is refused."""
    (line, *_) = section(found, "antenna", path)
    words = line.words
    if len(words) < 2:
        raise line.error(f"this is {line.text.strip()[:60]!r}, expected a name and azel")
    if words[1].lower() not in {"azel", "xxxx"}:
        raise line.error(f"the axes are {words[1]!r}, expected azel")
    return {"telescope": words[0], "field_system_antenna": " ".join(words)}


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
