"""TPOINT's terms for alt-azimuth mounts, by the signs that its own files have.

TPOINT counts azimuth from south through east, so that its A is 180 deg minus
ours, and its terms are what is to be taken off an elevation. Fits of published
observation files by published models fix every sign: see `docs/formats.md`.
"""

from __future__ import annotations

import re

from pyport.formats.terms.shapes import Shape, Wave, product, wave_product
from pyport.formats.terms.words import Word

#: Terms with a name of their own -> shape and sign.
NAMED: dict[str, tuple[Shape, int]] = {
    "IA": (Shape("azimuth_zero"), 1),
    "IE": (Shape("elevation_zero"), -1),
    "CA": (Shape("collimation"), 1),
    "NPAE": (Shape("skew"), 1),
    "AN": (Shape("tilt", 0), 1),
    "AW": (Shape("tilt", 1), -1),
    "TF": (Shape("sag_cosine"), 1),
    "TX": (Shape("refraction"), 1),
    "ACES": (Shape("azimuth_eccentricity", 0), 1),
    "ACEC": (Shape("azimuth_eccentricity", 1), -1),
    "ECES": (Shape("sag_sine"), -1),
    "ECEC": (Shape("sag_cosine"), -1),
    "NRX": (Shape("nasmyth", 0), 1),
    "NRY": (Shape("nasmyth", 1), -1),
}
_NAME_OF = {shape: (name, sign) for name, (shape, sign) in reversed(NAMED.items())}

#: Result, then one wave or two: function, angle, multiple (nothing for one).
_HARMONIC = re.compile(r"H([AES])([SC])([AE])([1-9]?)(?:([SC])([AE])([1-9]?))?")
_TX = re.compile(r"TX\d*")

#: What a harmonic's result is of, and its sign: an azimuth is counted the other way round (-1)
#: and taken off (-1), an elevation is taken off.
_RESULT = {"A": ("az", 1), "S": ("xel", 1), "E": ("el", -1)}
_LETTER = {axis: letter for letter, (axis, _) in _RESULT.items()}


def word(name: str) -> Word | None:
    """Return the word of a TPOINT term, None where it is none of an alt-azimuth mount's.

    `TX10` and its like are `TX` above the elevation that they name.
    """
    key = "TX" if _TX.fullmatch(name) else name
    if key in NAMED:
        shape, sign = NAMED[key]
        return Word(name, ((shape, sign),), "arcsec")
    match = _HARMONIC.fullmatch(name)
    if match is None:
        return None
    result, *rest = match.groups()
    axis, sign = _RESULT[result]
    waves = []
    for function, of, k in (rest[:3], rest[3:]):
        if function is not None:
            waves.append(Wave(function, of, int(k or 1)))
            sign *= turned(waves[-1])
    return Word(name, ((product(axis, *waves), sign),), "arcsec")


def turned(wave: Wave) -> int:
    """Return the sign that a wave of azimuth has when 180 deg - A stands for A."""
    if wave.of == "E":
        return 1
    even = wave.k % 2 == 0
    return 1 if (wave.function == "C") == even else -1


def name_of(shape: Shape) -> tuple[str, int] | None:
    """Return TPOINT's name for a shape and its sign, None where TPOINT has none."""
    if shape in _NAME_OF:
        return _NAME_OF[shape]
    axis, waves = wave_product(shape)
    if not 1 <= len(waves) <= 2 or any(wave.k > 9 for wave in waves):
        return None
    sign = _RESULT[_LETTER[axis]][1]
    name = f"H{_LETTER[axis]}"
    for wave in waves:
        sign *= turned(wave)
        name += f"{wave.function}{wave.of}{wave.k if wave.k > 1 else ''}"
    return name, sign
