"""TPOINT's model files: a caption, a line of statistics, one line a term, END.

A term's line begins with `&` where it is applied in parallel, `=` where it is
fixed, and holds the name, the coefficient and its sigma in arcseconds.
"""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.model_file import Entry, ModelFile
from pyport.models.terms import tpoint, tpoint_polar
from pyport.recordings.formats.lines import Line, lines_of, padded

#: What the statistics are: number of stars, sky rms, two constants of refraction [arcsec].
STATISTICS = ("stars", "sky_rms_arcsec", "refraction_a_arcsec", "refraction_b_arcsec")


def read(path: Path) -> ModelFile:
    """Read a TPOINT model file.

    Raises
    ------
    BadInput
        No line of statistics, a line that is no known term, or terms of two kinds of mount.
    """
    title, *rest = lines_of(path)
    body = [line for line in rest if line.text.strip() and line.text.lstrip()[0] not in ";!"]
    if not body or not body[0].text.strip().startswith("T"):
        wanted = "expected a line such as 'T   54   3.1416    0.000   0.0000'"
        raise BadInput(f"no line of statistics, {wanted}", path, body[0].number if body else 1)
    entries: list[Entry] = []
    for line in body[1:]:
        if line.text.strip().upper() == "END":
            break
        entries.append(_entry(line))
    if not entries:
        raise BadInput("no terms below the statistics", path, body[0].number)
    polar = any(tpoint.word(one.name) is None for one in entries)
    foreign = [one.name for one in entries if polar and tpoint_polar.word(one.name) is None]
    if foreign:
        wrong = f"{foreign[0]} is a term of an alt-azimuth mount, others are of an equatorial one"
        raise BadInput(wrong, path)
    details = {"statistics": _statistics(body[0])}
    vocabulary = "tpoint-equatorial" if polar else "tpoint"
    return ModelFile(vocabulary, tuple(entries), title.text.strip(), details=details)


def _statistics(line: Line) -> dict[str, Decimal]:
    words = line.text.strip()[1:].split()
    return {
        name: line.decimal(word, name.replace("_", " "))
        for name, word in zip(STATISTICS, words, strict=False)
    }


def _entry(line: Line) -> Entry:
    """Return the term of a line."""
    text = line.text.strip()
    marks = text[: len(text) - len(text.lstrip("&= "))]
    words = text.lstrip("&= ").split()
    if len(words) < 2:
        raise line.error(f"this is {text[:60]!r}, expected a term and its coefficient")
    if tpoint.word(words[0]) is None and tpoint_polar.word(words[0]) is None:
        wrong = f"{words[0][:20]!r} is no term of an alt-azimuth or equatorial mount"
        raise line.error(f"{wrong} that pyport knows")
    return Entry(
        words[0],
        line.decimal(words[1], "the coefficient"),
        "arcsec",
        sigma=line.decimal(words[2], "the sigma") if len(words) > 2 else None,
        fixed="=" in marks,
        parallel="&" in marks,
    )


def write(file: ModelFile, path: Path) -> None:
    """Write a model in TPOINT's vocabulary as it writes them."""
    given = file.details.get("statistics", {})
    stars, rms, a, b = (given.get(name, Decimal(0)) for name in STATISTICS)
    with write_whole(path) as out:
        out.write(f"{file.title or 'pyport'}\n")
        out.write(f"T{int(stars):5d}{padded(rms, 9, 4)}{padded(a, 9, 3)}{padded(b, 9, 4)}\n")
        for entry in file.entries:
            if entry.used:
                out.write(_line(entry) + "\n")
        out.write("END\n")


def _line(entry: Entry) -> str:
    marks = ("&" if entry.parallel else " ") + ("=" if entry.fixed else " ")
    sigma = "" if entry.sigma is None or entry.fixed else padded(entry.sigma, 12, 5)
    return f"{marks}{entry.name:8s}{padded(entry.value, 10, 4, '+')}{sigma}"
