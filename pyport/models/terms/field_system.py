"""The VLBI Field System's P1..P30, which katpoint (P1..P22) and DISCOS share.

Offsets are raw minus true, of the first angle as a coordinate. `phi` is the elevation of the
first axis: 90 deg for an alt-azimuth mount, the latitude for hour angle and declination, 0 for
X and Y. The terms are functions of the two angles of the axes, whichever those are.
Himwich, Mark IV Field System documentation, Pointing Model (1993).
"""

from __future__ import annotations

import math
from dataclasses import replace

from pyport.models.terms import tpoint
from pyport.models.terms.shapes import Shape, Wave, product
from pyport.models.terms.words import Word
from pyport.mounts import ALTAZ

NUMBER, KATPOINT_NUMBER = 30, 22
#: Those that scale an angle, which katpoint gives as a ratio.
RATIOS = frozenset({"P9", "P12"})

ALTAZ_PHI_DEG = 90.0

_SHAPES: dict[int, tuple[Shape, int]] = {
    1: (Shape("azimuth_zero"), 1),
    3: (Shape("skew"), 1),
    4: (Shape("collimation"), -1),
    5: (Shape("tilt", 0), 1),
    6: (Shape("tilt", 1), 1),
    7: (Shape("elevation_zero"), 1),
    8: (Shape("sag_cosine"), 1),
    9: (Shape("elevation_scale"), 1),
    10: (Shape("sag_cosine"), 1),
    11: (Shape("sag_sine"), 1),
    12: (Shape("azimuth_scale"), 1),
    13: (Shape("azimuth_eccentricity", 1), 1),
    14: (Shape("azimuth_eccentricity", 0), 1),
    15: (product("el", Wave("C", "A", 2)), 1),
    16: (product("el", Wave("S", "A", 2)), 1),
    17: (product("az", Wave("C", "A", 2)), 1),
    18: (product("az", Wave("S", "A", 2)), 1),
    19: (product("el", Wave("C", "E", 8)), 1),
    20: (product("el", Wave("S", "E", 8)), 1),
    21: (product("el", Wave("C", "A")), 1),
    22: (product("el", Wave("S", "A")), 1),
    23: (Shape("refraction"), 1),
}
_NUMBER_OF = {shape: (n, sign) for n, (shape, sign) in reversed(_SHAPES.items())}

#: P2 slides along the horizon, P8 sags toward the pole that phi leans to: of one size they are the
#: gravity that pulls a tube down.
_SLIDE = product("xel", Wave("S", "A"))
_POLE = product("el", Wave("S", "E"), Wave("C", "A"))
#: Waves of the second angle, where that is no elevation.
_ALONG = (Shape("elevation_encoder_harmonics", 1, 1), Shape("elevation_encoder_harmonics", 0, 1))
#: What the terms of other mounts are, beyond those of `_SHAPES` that are theirs as well.
_TILTED = {10: (_ALONG[0], 1), 11: (_ALONG[1], 1)}
#: A cotangent of the second angle: refraction where that is the elevation, elsewhere nothing.
_REFRACTION = 23
_NUMBER_OF_TILTED = {
    shape: (n, sign)
    for n, (shape, sign) in reversed({**_SHAPES, **_TILTED}.items())
    if n not in (8, _REFRACTION)
}
#: The terms that together are the gravity on a tube, on a mount whose first axis leans.
GRAVITY = ("P2", "P8")


def word(name: str, phi_deg: float = ALTAZ_PHI_DEG, unit: str = "deg") -> Word | None:
    """Return the word of P1..P30, None for any other name.

    P24..P30 have no part: the Field System reserves them.
    """
    if not (name[:1] == "P" and name[1:].isdigit() and name[1] != "0"):
        return None
    number = int(name[1:])
    if number > NUMBER:
        return None
    leans = phi_deg != ALTAZ_PHI_DEG
    shapes = {**_SHAPES, **_TILTED} if leans else _SHAPES
    parts: tuple[tuple[Shape, float], ...] = (shapes[number],) if number in shapes else ()
    if leans:
        sine, cosine = math.sin(math.radians(phi_deg)), math.cos(math.radians(phi_deg))
        if number == 2:
            parts = ((_SLIDE, -cosine),)
        if number == 8:
            parts = ((_ALONG[0], sine), (_POLE, -cosine))
    return Word(
        name,
        parts,
        unit,
        silent=number == 2 and not parts,
        mounts=() if leans and number != _REFRACTION else (ALTAZ.model,),
    )


def katpoint_word(name: str) -> Word | None:
    """Return the word of katpoint's P1..P22: arcseconds, and ratios for P9 and P12.

    katpoint has no P10, where the Field System has P8 again.
    """
    one = word(name, unit="" if name in RATIOS else "arcsec")
    if one is None or int(name[1:]) > KATPOINT_NUMBER:
        return None
    return Word(name, (), one.unit, silent=True) if name == "P10" else one


def word_on_leaning(name: str) -> Word | None:
    """Return the word of a mount whose first axis leans, by however much.

    P2 and P8 share gravity according to that: P8 stands for it, and P2 is nothing without it.
    """
    one = word(name, 0.0)
    if one is None or name not in (*GRAVITY, f"P{_REFRACTION}"):
        return one
    parts = ((Shape("sag_cosine"), 1.0),) if name == GRAVITY[1] else ()
    return replace(one, parts=parts, silent=name == GRAVITY[0])


def name_on_leaning(shape: Shape) -> tuple[str, int] | None:
    """Return the parameter of a mount whose first axis leans, for a shape; None without one.

    Gravity has two of one size, of which this is the second: `GRAVITY`.
    """
    if shape == Shape("sag_cosine"):
        return GRAVITY[1], 1
    number, sign = _NUMBER_OF_TILTED.get(shape, (0, 0))
    return (f"P{number}", sign) if number else None


def name_of(shape: Shape, last: int = NUMBER) -> tuple[str, int] | None:
    """Return the parameter of an alt-azimuth mount for a shape and its sign, None without one."""
    number, sign = _NUMBER_OF.get(shape, (NUMBER + 1, 0))
    return (f"P{number}", sign) if number <= last else None


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


def ska_mid_word(name: str) -> Word | None:
    """Return the word of one of the eighteen, without a part where no formula is known."""
    if name not in UNITS:
        return None
    return Word(name, (), UNITS[name]) if name in UNPUBLISHED else tpoint.word(name)


_NAME_OF = {
    one.parts[0]: name for name in UNITS if (one := ska_mid_word(name)) is not None and one.parts
}


def ska_mid_name_of(shape: Shape) -> tuple[str, int] | None:
    """Return SKA-Mid's name for a shape and its sign, None where there is none."""
    for sign in (1, -1):
        if (shape, sign) in _NAME_OF:
            return _NAME_OF[shape, sign], sign
    return None
