"""Pointing data as the Field System extracts them (xtr), and as its fits repeat them (err).

Degrees: flag, azimuth, elevation, offsets in azimuth (as a coordinate) and
elevation, raw minus true, and their one-sigma errors. A flag of 1 means use it.
The antenna's record tells the axes: azimuth and elevation, hour angle and declination, or X and Y.
"""

from __future__ import annotations

from pathlib import Path

from pyport.columns import SET_ASIDE
from pyport.effects.mounts import MOUNT
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.mounts import ALTAZ, KINDS, Mount
from pyport.recordings.formats import exact
from pyport.recordings.formats.text import Line, lines_of, raw_of, spelled
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Table


def sections(path: Path) -> dict[str, list[Line]]:
    """Return the lines of every section under its name; comments (`*`) and blanks are left out.

    Raises `BadInput`: the file holds no section, or one of them twice.
    """
    found: dict[str, list[Line]] = {}
    current: list[Line] = []
    for line in lines_of(path):
        text = line.text.strip()
        if text.startswith("$"):
            name = text[1:].split()[0].lower() if text[1:].split() else ""
            if name in found:
                raise line.error(f"a second section ${name}, expected one")
            current = found[name] = []
        elif text and not text.startswith("*"):
            current.append(line)
    if not found:
        raise BadInput("no line begins with $, expected sections such as $data", path)
    return found


def section(found: dict[str, list[Line]], name: str, path: Path) -> list[Line]:
    """Return a section's lines.

    Raises `BadInput`: there is none, or it is empty.
    """
    if not found.get(name):
        raise BadInput(f"no section ${name} with lines in it, expected one", path)
    return found[name]


#: Why a row whose flag is not 1 is not used.
FLAGGED = "flagged in the file"

#: The Field System's words for the axes, and the mount that has them.
AXES = {"azel": "altaz", "hadc": "equatorial", "xyns": "xy-ns", "xyew": "xy-ew"}
#: What it writes where it knows none.
NO_AXES = "xxxx"
#: Least decimals of each column.
_DIGITS = (5, 5, 7, 7, 7, 7)
ANTENNA = "field_system_antenna"


def read_xtr(path: Path) -> Raw:
    """Read the cells of an xtr file.

    Raises `BadInput`: no `$data`, or a line of it that is no recording.
    """
    found = sections(path)
    return _tabulated(path, section(found, "data", path), _antenna(found, path), 6)


def read_err(path: Path) -> Raw:
    """Read the observations that an err file repeats, rounded as it holds them.

    Raises `BadInput`: no `$observed`, or a line of it that is no recording.
    """
    found = sections(path)
    return _tabulated(path, section(found, "observed", path), _antenna(found, path), 4)


def write(table: Table, path: Path) -> exact.Written:
    """Write recordings as an xtr file; return what it has no place for.

    Raises `BadInput`: an axis or its errors are missing: the Field System weighs by them.
    """
    mount = exact.mount_of(table)
    word = _word(mount)
    if word is None:
        raise BadInput(f"no axes of {mount.sentence}, expected {', '.join(AXES.values())}", path)
    errors = exact.sigmas(table, mount, path)
    if None in errors:
        names = f"sigma_{mount.across_column[2:]}_deg and sigma_{mount.second.offset[2:]}_deg"
        raise BadInput(f"no errors {names}, and this format holds them", path)
    columns = (*exact.readings(table, mount, path), *filter(None, errors))
    decimals = [
        exact.decimals_of(column, least=least)
        for column, least in zip(columns, _DIGITS, strict=True)
    ]
    own = table.meta.get(ANTENNA)
    name = table.meta.get("telescope", "antenna").split() or ["antenna"]
    with write_whole(path) as out:
        out.write(f"$antenna\n {own or f'{name[0]} {word} 1'}\n$data\n")
        for n, why in enumerate(exact.asides(table)):
            values = [column[n] for column in columns]
            if None in values:
                raise BadInput(f"row {n + 1} lacks a number, and this format holds them all", path)
            digits = zip(values, decimals, strict=True)
            words = [f"{value:{5 + count}.{count}f}" for value, count in digits]
            out.write(f" {0 if why else 1} {' '.join(words)}\n")
        out.write("$stats\n")
    return exact.Written(exact.left_out(table, exact.held(mount, sigmas=True)))


def _antenna(found: dict[str, list[Line]], path: Path) -> dict[str, str]:
    """Return the telescope's name and its mount; axes that are not known are refused."""
    (line, *_) = section(found, "antenna", path)
    words = line.words
    if len(words) < 2:
        raise line.error(f"this is {line.text.strip()[:60]!r}, expected a name and azel")
    axes = words[1].lower()
    if axes not in {*AXES, NO_AXES}:
        raise line.error(f"the axes are {words[1]!r}, expected {', '.join(AXES)}")
    meta = {"telescope": words[0], ANTENNA: " ".join(words)}
    mount = AXES.get(axes, ALTAZ.id)
    return meta if mount == ALTAZ.id else meta | {MOUNT: mount}


def _word(mount: Mount) -> str | None:
    """Return the word for a mount's axes; None for one that turns over, which has no place here."""
    same = (
        word
        for word, one in AXES.items()
        if one == mount.id or (mount.needs_latitude and KINDS[one].model == mount.model)
    )
    return None if mount.turns_over else next(same, None)


def _names(mount: Mount) -> tuple[str, ...]:
    """Return the columns of a file of a mount, in its order."""
    first, second = mount.axes
    angles = (first.column, second.column, first.offset, second.offset)
    sigmas = (f"sigma_{one.offset.removeprefix('d_')}" for one in mount.axes)
    return tuple(f"{one}_deg" for one in (*angles, *sigmas))


def _tabulated(path: Path, lines: list[Line], meta: dict[str, str], count: int) -> Raw:
    names = _names(KINDS[meta.get(MOUNT, ALTAZ.id)])[:count]
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
