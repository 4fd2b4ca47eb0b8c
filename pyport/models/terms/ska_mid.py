"""SKA-Mid's eighteen coefficients: TPOINT's names, and four that are its own."""

from __future__ import annotations

from pyport.models.terms import tpoint
from pyport.models.terms.shapes import Shape
from pyport.models.terms.words import Word

#: In the order in which the dish structure takes them, each with its unit.
UNITS = {
    "IA": "arcsec",
    "CA": "arcsec",
    "NPAE": "arcsec",
    "AN": "arcsec",
    "AN0": "arcsec",
    "AW": "arcsec",
    "AW0": "arcsec",
    "ACEC": "arcsec",
    "ACES": "arcsec",
    "ABA": "arcsec",
    "ABphi": "deg",
    "IE": "arcsec",
    "ECEC": "arcsec",
    "ECES": "arcsec",
    "HECE4": "arcsec",
    "HESE4": "arcsec",
    "HECE8": "arcsec",
    "HESE8": "arcsec",
}

#: Names whose formula has not been published.
UNPUBLISHED = frozenset({"AN0", "AW0", "ABA", "ABphi"})


def word(name: str) -> Word | None:
    """Return the word of one of the eighteen, without a part where no formula is known."""
    if name not in UNITS:
        return None
    return Word(name, (), UNITS[name]) if name in UNPUBLISHED else tpoint.word(name)


_NAME_OF = {one.parts[0]: name for name in UNITS if (one := word(name)) is not None and one.parts}


def name_of(shape: Shape) -> tuple[str, int] | None:
    """Return SKA-Mid's name for a shape and its sign, None where there is none."""
    for sign in (1, -1):
        if (shape, sign) in _NAME_OF:
            return _NAME_OF[shape, sign], sign
    return None
