"""TPOINT's observation files: a title, options, the site, one line a star, END.

A star's line holds its azimuth and elevation, then those that the telescope
read, all in degrees, then whatever else (a rotator's angle with ROTNL or ROTNR).
`;` and `!` begin a comment; a star's line behind one is masked, not lost.
"""

from __future__ import annotations

from decimal import ROUND_FLOOR, Decimal
from pathlib import Path

from pyport.errors import BadInput
from pyport.formats.lines import Line, lines_of, raw_of, spelled
from pyport.recordings.columns import SET_ASIDE
from pyport.recordings.raw import Raw

#: Why a row that was commented out is not used.
MASKED = "masked in the file"

TITLE, OPTIONS, SITE = "tpoint_title", "tpoint_options", "tpoint_site"
#: What stands behind azimuth and elevation, true and as read.
ROTATOR, NOTE = "rotator_deg", "note"
_COMMENT = ";!"
_NAN = "nan"


def read(path: Path) -> Raw:
    """Read the cells of a TPOINT observation file of an alt-azimuth mount.

    Raises
    ------
    BadInput
        No title, no `: ALTAZ`, no site, a line that is no star.
    """
    lines = lines_of(path)
    body = [line for line in lines[1:] if line.text.strip()]
    meta = {TITLE: lines[0].text.strip()}
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
    return _tabulated(path, meta, found, site.number)


def _options(body: list[Line], path: Path) -> dict[str, str]:
    """Return the options of the `:` lines; a mount that is no alt-azimuth is refused."""
    options = [
        word.upper()
        for line in body
        if line.text.strip().startswith(":")
        for word in line.text.replace(":", " ").split()
    ]
    if "ALTAZ" not in options:
        raise BadInput("no line ': ALTAZ', expected azimuths and elevations in degrees", path)
    return {OPTIONS: " ".join(options)}


def _split(text: str) -> tuple[str, str]:
    """Return what stands before a comment, and the comment."""
    places = [text.find(mark) for mark in _COMMENT if mark in text]
    cut = min(places, default=len(text))
    return text[:cut], text[cut + 1 :].strip()


def _is_star(words: list[str]) -> bool:
    """Tell whether a comment is a line of numbers that was masked."""
    try:
        numbers = [float(_NAN if _unread(word) else word) for word in words]
    except ValueError:
        return False
    return len(numbers) >= 4


def _unread(word: str) -> bool:
    """Tell whether a number was never read, however a program padded it."""
    return word.lstrip("0+-").lower() == _NAN


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
    path: Path,
    meta: dict[str, str],
    found: list[tuple[Line, list[str], str, bool]],
    header: int,
) -> Raw:
    """Return the columns: true place, offsets as read minus true, and all that follows."""
    widest = max(len(words) for _, words, _, _ in found)
    extra = [ROTATOR if n == 0 else f"auxiliary_{n}" for n in range(widest - 4)]
    columns: dict[str, list[str]] = {
        name: [] for name in ("az_deg", "el_deg", "d_az_deg", "d_el_deg", *extra, NOTE, SET_ASIDE)
    }
    for line, words, note, masked in found:
        if len(words) < 4:
            wanted = "expected azimuth and elevation, true and as read"
            raise line.error(f"{len(words)} number{'s' * (len(words) != 1)}, {wanted}")
        az, el = line.decimal(words[0], "azimuth"), line.decimal(words[1], "elevation")
        rest = words[4:] + [""] * (widest - len(words))
        offsets = (_offset(line, words[2], az), _offset(line, words[3], el))
        cells = [spelled(az), spelled(el), *offsets]
        for name, cell in zip(
            columns, [*cells, *rest, note, MASKED if masked else ""], strict=True
        ):
            columns[name].append(cell)
    for name in (NOTE, SET_ASIDE):
        if not any(columns[name]):
            del columns[name]
    return raw_of(path, meta, columns, [line.number for line, *_ in found], header)


def _offset(line: Line, word: str, true: Decimal) -> str:
    """Return an angle as read minus the true one, blank where none was read."""
    return "" if _unread(word) else spelled(turned(line.decimal(word, "what was read") - true))


def turned(degrees: Decimal) -> Decimal:
    """Return a difference of angles within half a turn."""
    return degrees - 360 * ((degrees + 180) / 360).to_integral_value(ROUND_FLOOR)
