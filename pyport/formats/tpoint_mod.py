"""TPOINT's model files: a caption, a line of statistics, one line a term, END.

A term's line begins with `&` where it is applied in parallel, `=` where it is
fixed, and holds the name, the coefficient and its sigma in arcseconds. What a term that nobody
has published does, a user says in a comment below the caption: `! HVSA3: x = sin 3A sin E`.
"""

from __future__ import annotations

import re
from decimal import Decimal
from pathlib import Path

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.model_file import Entry, ModelFile
from pyport.models.terms import editing, tpoint
from pyport.recordings.formats.text import Line, lines_of, padded

#: What the statistics are: number of stars, sky rms, two constants of refraction [arcsec].
STATISTICS = ("stars", "sky_rms_arcsec", "refraction_a_arcsec", "refraction_b_arcsec")
#: A user's term in a comment.
_MEANT = re.compile(r"[;!]\s*(\w+)\s*:\s*([xy]\s*=.*)")


def read(path: Path) -> ModelFile:
    """Read a TPOINT model file.

    Raises `BadInput`: no line of statistics, a line that is no known term, no END, or terms of two
      kinds of mount.
    """
    title, *rest = lines_of(path)
    meant = _meant(rest)
    body = [line for line in rest if line.text.strip() and line.text.lstrip()[0] not in ";!"]
    if not body or not body[0].text.strip().startswith("T"):
        wanted = "expected a line such as 'T   54   3.1416    0.000   0.0000'"
        raise BadInput(f"no line of statistics, {wanted}", path, body[0].number if body else 1)
    ends = [n for n, line in enumerate(body) if line.text.strip().upper() == "END"]
    if not ends:
        last = body[-1].number
        raise BadInput("no line END below the terms: the file may be cut off", path, last)
    if ends[0] + 1 < len(body):
        raise body[ends[0] + 1].error("this stands below END, expected one model a file")
    found: dict[str, Entry] = {}
    for line in body[1 : ends[0]]:
        one = _entry(line, meant)
        if one.name in found:
            raise line.error(f"{one.name} stands twice, expected each term once")
        found[one.name] = one
    entries = tuple(found.values())
    if not entries:
        raise BadInput("no terms below the statistics", path, body[0].number)
    known = [one.name for one in entries if not one.formula]
    polar = any(tpoint.word(name) is None for name in known)
    foreign = [name for name in known if polar and tpoint.polar_word(name) is None]
    if polar and len(known) < len(entries):
        raise BadInput(
            "a user's formula is one of azimuth and elevation, the mount's are not", path
        )
    if foreign:
        wrong = f"{foreign[0]} is a term of an alt-azimuth mount, others are of an equatorial one"
        raise BadInput(wrong, path)
    details = {"statistics": _statistics(body[0])}
    vocabulary = "tpoint-equatorial" if polar else "tpoint"
    return ModelFile(vocabulary, entries, title.text.strip(), details=details)


def _statistics(line: Line) -> dict[str, Decimal]:
    words = line.text.strip()[1:].split()
    return {
        name: line.decimal(word, name.replace("_", " "))
        for name, word in zip(STATISTICS, words, strict=False)
    }


def _meant(lines: list[Line]) -> dict[str, str]:
    """Return the formulae of a user's terms.

    Raises `BadInput`: one is no formula.
    """
    found = {}
    for line in lines:
        match = _MEANT.fullmatch(line.text.strip())
        if match is None:
            continue
        try:
            editing.formula_word(*match.groups())
        except BadInput as error:
            raise line.error(error.message) from None
        found[match[1]] = match[2]
    return found


def _entry(line: Line, meant: dict[str, str]) -> Entry:
    text = line.text.strip()
    marks = text[: len(text) - len(text.lstrip("&= "))]
    words = text.lstrip("&= ").split()
    if len(words) < 2:
        raise line.error(f"this is {text[:60]!r}, expected a term and its coefficient")
    name = words[0]
    if name not in meant and tpoint.word(name) is None and tpoint.polar_word(name) is None:
        wrong = f"{name[:20]!r} is no term of an alt-azimuth or equatorial mount that pyport knows"
        example = f"! {name[:20]}: x = sin 3A sin E"
        raise line.error(f"{wrong}; say what it does in a line such as '{example}'")
    return Entry(
        words[0],
        line.decimal(words[1], "the coefficient"),
        "arcsec",
        sigma=line.decimal(words[2], "the sigma") if len(words) > 2 else None,
        fixed="=" in marks,
        parallel="&" in marks,
        formula=meant.get(name, ""),
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
                meant = f"! {entry.name}: {entry.formula}\n" if entry.formula else ""
                marks = ("&" if entry.parallel else " ") + ("=" if entry.fixed else " ")
                sigma = "" if entry.sigma is None or entry.fixed else padded(entry.sigma, 12, 5)
                value = padded(entry.value, 10, 4, "+")
                out.write(f"{meant}{marks}{entry.name:8s}{value}{sigma}\n")
        out.write("END\n")
