"""TPOINT's observation files: a title, options, the site, one line a star, END.

A star's line holds its azimuth and elevation, then those that the telescope
read, all in degrees, then whatever else (a rotator's angle with ROTNL or ROTNR);
or its right ascension and declination: see `equatorial`. Of an equatorial
mount (EQUAT) it holds hour angles and declinations, or the same right ascensions;
a telescope that had turned over reads a declination beyond the pole. These are TPOINT's
formats 4, 1 and 2; the third is refused, for no public source tells its columns.
`;` and `!` begin a comment; a star's line behind one is masked, not lost.
"""

from __future__ import annotations

import re
from decimal import ROUND_FLOOR, Decimal
from pathlib import Path

import numpy as np

from pyport.columns import SET_ASIDE
from pyport.effects.base import OVER, PIER_SIDE
from pyport.effects.mounts import MOUNT
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats import exact
from pyport.recordings.formats.text import Line, lines_of, raw_of, spelled
from pyport.recordings.formats.tpoint import equatorial
from pyport.recordings.mounted import sides
from pyport.recordings.raw import REFRACTION, Raw
from pyport.recordings.schema import Table

#: Why a row that was commented out is not used.
MASKED = "masked in the file"

TITLE, OPTIONS, SITE = "tpoint_title", "tpoint_options", "tpoint_site"
#: A remark is kept under this, how many stars stand before it, and how many remarks.
REMARK = "tpoint_remark_"
#: What stands behind azimuth and elevation, true and as read.
ROTATOR, AUXILIARY, NOTE = "rotator_deg", "auxiliary_", "note"
#: The option of an equatorial mount, and that of each mount that TPOINT knows.
POLAR = "EQUAT"
OPTION = {"altaz": "ALTAZ", "equatorial": POLAR}
_COMMENT = ";!"
_MARK = re.compile(f"[{_COMMENT}]")
_NAN = "nan"
_HALF_TURN = Decimal(180)


def read(path: Path) -> Raw:
    """Read the cells of a TPOINT observation file of an alt-azimuth or equatorial mount.

    Raises `BadInput`: no title, no `: ALTAZ` or `: EQUAT`, no site, a line that is no star.
    """
    lines = [line for line in lines_of(path) if line.text.strip()]
    first = next((n for n, line in enumerate(lines) if line.text.strip()[0] not in _COMMENT), 0)
    body = lines[first + 1 :]
    above = {f"{REMARK}0_{n}": line.text.strip() for n, line in enumerate(lines[:first])}
    meta = {TITLE: lines[first].text.strip()} | above
    meta |= _options(body, path)
    found: list[tuple[Line, list[str], str, bool]] = []
    site: Line | None = None
    for line in body:
        active = line.text.strip()
        if active.startswith(":"):
            continue
        if active.upper() == "END":
            break
        masked = active[0] in _COMMENT
        content, note = _split(active.lstrip(_COMMENT) if masked else active)
        words = content.split()
        if masked and not _is_star(words):
            remark = f"{REMARK}{len(found)}_{sum(one.startswith(REMARK) for one in meta)}"
            meta[remark] = active
            continue
        if site is None and not masked:
            site = line
            meta |= _site(line, words)
            continue
        found.append((line, words, note, masked))
    if site is None:
        raise BadInput("no line with the latitude, expected one such as 53 05 43.8", path)
    if not found:
        raise BadInput("no observations below the latitude", path, site.number)
    of_catalogue = [equatorial.is_star(line, words) for line, words, _, _ in found]
    if all(of_catalogue):
        return _of_stars(path, meta, found, site)
    if any(of_catalogue):
        other = found[of_catalogue.index(not of_catalogue[0])][0]
        raise other.error("a record of another kind than the first: degrees, or RA and Dec")
    return _tabulated(path, meta, found, site.number)


def _of_stars(
    path: Path, meta: dict[str, str], found: list[tuple[Line, list[str], str, bool]], site: Line
) -> Raw:
    """Return the columns of equatorial records, turned into azimuth and elevation."""
    words_of_site = site.text.split()
    stars = [equatorial.star(line, words, words_of_site) for line, words, _, _ in found]
    widest = max(len(one.rest) for one in stars)
    rows = [one.polar() if MOUNT in meta else one.across() for one in stars]
    columns = {name: [f"{row[name]:.10f}" for row in rows] for name in rows[0]}
    meta[REFRACTION] = equatorial.refracted(words_of_site)
    _add_sides(meta, columns, [one.over for one in stars])
    for n in range(widest):
        cells = [one.rest[n] if n < len(one.rest) else "" for one in stars]
        columns[f"{AUXILIARY}{n + 1}"] = cells
    columns[NOTE] = [note for _, _, note, _ in found]
    columns[SET_ASIDE] = [MASKED if masked else "" for _, _, _, masked in found]
    for name in (NOTE, SET_ASIDE):
        if not any(columns[name]):
            del columns[name]
    return raw_of(path, meta, columns, [line.number for line, *_ in found], site.number)


def _options(body: list[Line], path: Path) -> dict[str, str]:
    """Return the options of the `:` lines, and the mount where it is an equatorial one."""
    options = [
        word.upper()
        for line in body
        if line.text.strip().startswith(":")
        for word in line.text.replace(":", " ").split()
    ]
    kinds = [one for one in ("ALTAZ", POLAR) if one in options]
    if len(kinds) != 1:
        wanted = f"expected one of them: azimuths and elevations, or hour angles ({POLAR})"
        way = "--columns reads any other table"
        raise BadInput(f"no line ': ALTAZ' or ': {POLAR}', {wanted}; {way}", path)
    return {OPTIONS: " ".join(options)} | ({MOUNT: "equatorial"} if kinds == [POLAR] else {})


def _add_sides(meta: dict[str, str], columns: dict[str, list[str]], over: list[bool]) -> None:
    """Say on which side of its pier a telescope was, if it was on both: a German mount."""
    if any(over):
        meta[MOUNT] = "german"
        columns[PIER_SIDE] = [OVER if one else "east" for one in over]


def _split(text: str) -> tuple[str, str]:
    """Return what stands before a comment, and the comment."""
    mark = _MARK.search(text)
    return (text, "") if mark is None else (text[: mark.start()], text[mark.end() :].strip())


def _is_star(words: list[str]) -> bool:
    """Tell whether a comment is a line of numbers that was masked."""
    try:
        return len([float(_NAN if _unread(word) else word) for word in words]) >= 4
    except ValueError:
        return False


def _unread(word: str) -> bool:
    """Tell whether a number was never read, however a program padded it."""
    return word.endswith(("n", "N")) and word.lstrip("0+-").lower() == _NAN


def _site(line: Line, words: list[str]) -> dict[str, str]:
    """Return the latitude from degrees, minutes and seconds; what follows is kept as it stands."""
    if len(words) < 3:
        wanted = "expected the latitude such as 53 05 43.8"
        raise line.error(f"this is {line.text.strip()[:60]!r}, {wanted}")
    degrees, minutes, seconds = (line.decimal(word, "the latitude") for word in words[:3])
    sign = -1 if words[0].startswith("-") else 1
    latitude = sign * (abs(degrees) + minutes / 60 + seconds / 3600)
    if minutes < 0 or minutes >= 60 or seconds < 0 or seconds >= 60 or abs(latitude) > 90:
        raise line.error(f"the latitude is {' '.join(words[:3])}, expected such as 53 05 43.8")
    return {SITE: " ".join(words), "latitude_deg": spelled(latitude.quantize(Decimal("1e-9")))}


def _tabulated(
    path: Path, meta: dict[str, str], found: list[tuple[Line, list[str], str, bool]], header: int
) -> Raw:
    """Return the columns: true place, offsets as read minus true, and all that follows."""
    widest = max(len(words) for _, words, _, _ in found)
    extra = [ROTATOR if n == 0 else f"{AUXILIARY}{n}" for n in range(widest - 4)]
    polar = MOUNT in meta
    angles = ("az_deg", "el_deg", "d_az_deg", "d_el_deg")
    angles = ("ha_deg", "dec_deg", "d_ha_deg", "d_dec_deg") if polar else angles
    names = (*angles, *extra, NOTE, SET_ASIDE)
    meta[REFRACTION] = equatorial.as_seen(meta[SITE].split())
    rows, over = [], []
    for line, words, note, masked in found:
        if len(words) < 4:
            wanted = "expected azimuth and elevation, true and as read"
            raise line.error(f"{len(words)} number{'s' * (len(words) != 1)}, {wanted}")
        az, el = (
            None if _unread(word) else line.decimal(word, what)
            for word, what in zip(words, ("azimuth", "elevation"), strict=False)
        )
        rest = words[4:] + [""] * (widest - len(words))
        first, second, beyond = _turned_back(line, words[2], words[3], polar=polar)
        over.append(beyond)
        offsets = (_offset(line, first, az), _offset(line, second, el))
        place = ["" if one is None else spelled(one) for one in (az, el)]
        # a row without a direction is excluded for that
        why = MASKED if masked and all(place) else ""
        rows.append((*place, *offsets, *rest, note, why))
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    for name in (NOTE, SET_ASIDE):
        if not any(columns[name]):
            del columns[name]
    _add_sides(meta, columns, over)
    return raw_of(path, meta, columns, [line.number for line, *_ in found], header)


def _turned_back(line: Line, first: str, second: str, *, polar: bool) -> tuple[str, str, bool]:
    """Return what an equatorial mount read as if it had not turned over, and whether it had."""
    if not polar or _unread(first) or _unread(second):
        return first, second, False
    dec = line.decimal(second, "what was read")
    if abs(dec) <= 90:
        return first, second, False
    ahead = line.decimal(first, "what was read") + 180
    return spelled(ahead), spelled(Decimal(180).copy_sign(dec) - dec), True


def _offset(line: Line, word: str, true: Decimal | None) -> str:
    """Return an angle as read minus the true one, blank where either is not known."""
    if true is None or _unread(word):
        return ""
    return spelled(turned(line.decimal(word, "what was read") - true))


def write(table: Table, path: Path) -> exact.Written:
    """Write recordings as TPOINT reads them; return what it has no place for.

    Raises `BadInput`: there is no latitude, or no offset of one axis, or no row has all it needs.
    """
    mount = exact.mount_of(table)
    if mount.model not in OPTION:
        raise BadInput(f"TPOINT has no {mount.sentence.removeprefix('an ')}", path)
    az, el, d_az, d_el = exact.readings(table, mount, path)
    read_az = [_read(a, d, wrapped=True) for a, d in zip(az, d_az, strict=True)]
    read_el = [_read(e, d) for e, d in zip(el, d_el, strict=True)]
    if mount.turns_over:
        read_az, read_el = _turned_over(table, read_az, read_el, path)
    stars = list(zip(az, el, read_az, read_el, strict=True))
    asides = exact.asides(table)
    # A star that was not all measured is none that TPOINT could fit.
    lacking = sum(None in star and not why for star, why in zip(stars, asides, strict=True))
    if lacking and lacking == asides.count(""):
        wrong = "no row has both angles and both offsets"
        raise BadInput(f"{wrong}, expected at least one: TPOINT fits no other", path)
    decimals = exact.decimals_of(az, el, read_az, read_el, least=7)
    extra = [name for name in table.columns if name == ROTATOR or name.startswith(AUXILIARY)]
    rest = [_further(table, name) for name in extra]
    notes = exact.cells(table, NOTE) if NOTE in table.columns else [""] * len(az)
    remarks = {key: text for key, text in table.meta.items() if key.startswith(REMARK)}
    head = [table.meta.get(TITLE, table.meta.get("telescope", "pyport"))]
    head += [f": {one}" for one in table.meta.get(OPTIONS, OPTION[mount.model]).split()]
    with write_whole(path) as out:
        out.writelines(f"{line}\n" for line in [*head, _site_line(table, path)])
        for n, (star, why) in enumerate(zip(stars, asides, strict=True)):
            out.writelines(f"{remarks[key]}\n" for key in _before(remarks, n))
            angles = zip(star, (3, 2, 3, 2), strict=True)
            words = [_padded(value, whole, decimals) for value, whole in angles]
            words += [column[n] for column in rest if column[n]]
            note = f" ; {notes[n]}" if notes[n] else ""
            out.write(f"{';' * (bool(why) or None in star)}{' '.join(words)}{note}\n")
        out.writelines(f"{remarks[key]}\n" for key in _before(remarks, len(az)))
        out.write("END\n")
    sides = (PIER_SIDE,) if mount.turns_over else ()
    return exact.Written(exact.left_out(table, (*exact.held(mount), *extra, NOTE, *sides)), lacking)


def _turned_over(
    table: Table, first: exact.Numbers, second: exact.Numbers, path: Path
) -> tuple[exact.Numbers, exact.Numbers]:
    """Return what a mount reads that has turned over in some rows: declinations beyond the pole."""
    if PIER_SIDE not in table.columns:
        raise BadInput(f"no column {PIER_SIDE}, and a German mount reads both sides", path)
    over = (sides(np.array(exact.cells(table, PIER_SIDE))) == OVER).tolist()
    ahead = [a + 180 if a is not None and o else a for a, o in zip(first, over, strict=True)]
    beyond = [180 - b if b is not None and o else b for b, o in zip(second, over, strict=True)]
    return ahead, beyond


def _further(table: Table, name: str) -> list[str]:
    """Return a further column: text as it stands, numbers with leading zeros."""
    recorded = exact.cells(table, name)
    if table.columns[name].dtype.kind in "UO":
        return recorded
    numbers = [exact.number(cell) for cell in recorded]
    decimals = exact.decimals_of(numbers, least=7)
    return ["" if one is None else _padded(one, 3, decimals) for one in numbers]


def _before(remarks: dict[str, str], stars: int) -> list[str]:
    return [key for key in remarks if key.removeprefix(REMARK).partition("_")[0] == str(stars)]


def _read(true: Decimal | None, offset: Decimal | None, *, wrapped: bool = False) -> Decimal | None:
    """Return what the telescope read, within the turn that the true azimuth is in."""
    if true is None or offset is None:
        return None
    value = true + offset
    inside = wrapped and 0 <= true < 360
    return value - 360 * (value / 360).to_integral_value(ROUND_FLOOR) if inside else value


def _padded(value: Decimal | None, whole: int, decimals: int) -> str:
    """Return a number with leading zeros, as TPOINT's users have them."""
    if value is None:
        return _NAN
    return f"{value:0{whole + 1 + decimals}.{decimals}f}"


def _site_line(table: Table, path: Path) -> str:
    """Return the latitude in degrees, minutes and seconds: the file's own text where it has one."""
    recorded = table.meta.get("latitude_deg")
    latitude = None if recorded is None else exact.number(recorded)
    if latitude is None:
        raise BadInput("TPOINT needs a latitude: give --set latitude_deg=...", path)
    own = table.meta.get(SITE, "")
    if own:
        line = Line(path, 1, own)
        same = Decimal(_site(line, own.split())["latitude_deg"])
        if abs(same - latitude) < Decimal("1e-8"):
            return own
    minutes, seconds = divmod(abs(latitude) * 3600, 60)
    degrees, minutes = divmod(minutes, 60)
    return f"{'-' if latitude < 0 else ''}{int(degrees):02d} {int(minutes):02d} {seconds:07.4f}"


def turned(degrees: Decimal) -> Decimal:
    """Return a difference of angles within half a turn."""
    if -_HALF_TURN <= degrees < _HALF_TURN:
        return degrees
    turns = ((degrees + _HALF_TURN) / (2 * _HALF_TURN)).to_integral_value(ROUND_FLOOR)
    return degrees - 2 * _HALF_TURN * turns
