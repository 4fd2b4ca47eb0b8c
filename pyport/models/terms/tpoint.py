"""TPOINT's terms, by the signs that its files have: of alt-azimuth mounts, and of equatorial ones.

TPOINT counts azimuth from south through east, so that its A is 180 deg minus
ours, and its terms are what is to be taken off an elevation. Fits of published
observation files by published models fix every sign: see `docs/formats.md`.

On equatorial mounts its terms give true minus read, ours are read minus true. Hour angle and
declination are counted as here, so that every sign but those of what gravity and the air do is
turned: `docs/mounts.md` derives each.
"""

from __future__ import annotations

import re

from pyport.models.terms.shapes import PRODUCT, Shape, Wave, product, wave_product
from pyport.models.terms.words import Word

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
_HARMONIC = re.compile(r"H([AESZ])([SC])([AEZ])([1-9]?)(?:([SC])([AEZ])([1-9]?))?")
#: Result, coordinate and power, of one coordinate or two; the power one may be left out. A
#: polynomial of azimuth is none of a mount's that turns round, and not read.
_POLYNOMIAL = re.compile(r"P([AESZ])([EZ])([0-9]?)(?:([EZ])([0-9]?))?")
_TX = re.compile(r"TX\d*")

#: What a harmonic's result is of, and its sign: an azimuth is counted in the opposite sense (-1)
#: and taken off (-1), an elevation is taken off.
_RESULT = {"A": ("az", 1), "S": ("xel", 1), "E": ("el", -1), "Z": ("el", 1)}
_LETTER = {"az": "A", "xel": "S", "el": "E"}


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
        return _polynomial(name)
    result, *rest = match.groups()
    axis, sign = _RESULT[result]
    waves = []
    for function, of, k in (rest[:3], rest[3:]):
        if function is not None:
            wave, turn = upward(Wave(function, of, int(k or 1)))
            waves.append(wave)
            sign *= turn * turned(wave)
    return Word(name, ((product(axis, *waves), sign),), "arcsec")


def upward(wave: Wave) -> tuple[Wave, int]:
    """Return a wave of zenith distance as one of elevation, with its sign."""
    if wave.of != "Z" or wave.function == "P":
        return wave, 1
    # of k (90 deg - E): after each quarter turn sine and cosine change places
    quarter, other = wave.k % 4, {"S": "C", "C": "S"}[wave.function]
    sine = ((wave.function, -1), (other, 1), (wave.function, 1), (other, -1))
    cosine = ((wave.function, 1), (other, 1), (wave.function, -1), (other, -1))
    function, sign = (sine if wave.function == "S" else cosine)[quarter]
    return Wave(function, "E", wave.k), sign


def _polynomial(name: str) -> Word | None:
    """Return the word of a polynomial in elevation or zenith distance [rad], `PZZ2`, `PSZ2`."""
    match = _POLYNOMIAL.fullmatch(name)
    if match is None:
        return None
    result, *rest = match.groups()
    axis, sign = _RESULT[result]
    powers = [
        Wave("P", of, int(k or 1)) for of, k in (rest[:2], rest[2:]) if of is not None and k != "0"
    ]
    if not powers:
        return None
    return Word(name, ((product(axis, *powers), sign),), "arcsec")


def turned(wave: Wave) -> int:
    """Return the sign that a wave of azimuth has when 180 deg - A stands for A."""
    if wave.of != "A":
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
    if waves[0].function == "P":
        powers = "".join(f"{wave.of}{wave.k if wave.k > 1 else ''}" for wave in waves)
        return f"P{_LETTER[axis]}{powers}", sign
    name = f"H{_LETTER[axis]}"
    for wave in waves:
        sign *= turned(wave)
        name += f"{wave.function}{wave.of}{wave.k if wave.k > 1 else ''}"
    return name, sign


MOUNT = "equatorial"
#: Terms with a name of their own -> shape about the mount's axes, and sign.
POLAR_NAMED: dict[str, tuple[Shape, int]] = {
    "IH": (Shape("azimuth_zero"), -1),
    "ID": (Shape("elevation_zero"), -1),
    "CH": (Shape("collimation"), -1),
    "NP": (Shape("skew"), -1),
    "ME": (Shape("tilt", 0), -1),
    "MA": (Shape("tilt", 1), -1),
    "TF": (Shape("sag_cosine"), 1),
    "TX": (Shape("refraction"), 1),
    "FO": (Shape("fork_flexure"), 1),
    "DAF": (Shape("declination_axis_flexure"), 1),
    "HCES": (Shape("azimuth_eccentricity", 0), -1),
    "HCEC": (Shape("azimuth_eccentricity", 1), -1),
    "DCES": (Shape("elevation_encoder_harmonics", 0, 1), -1),
    "DCEC": (Shape("elevation_encoder_harmonics", 1, 1), -1),
    "PHH": (Shape("azimuth_scale"), -1),
    "PDD": (Shape("elevation_scale"), -1),
}
_POLAR_NAME_OF = {shape: (name, sign) for name, (shape, sign) in reversed(POLAR_NAMED.items())}

#: Result (hour angle, on the sky, declination), then one wave or two of either angle.
_POLAR_HARMONIC = re.compile(r"H([HXD])([SC])([HD])([1-9]?)(?:([SC])([HD])([1-9]?))?")
_POLAR_RESULT = {"H": "az", "X": "xel", "D": "el"}
_POLAR_LETTER = {axis: letter for letter, axis in _POLAR_RESULT.items()}
_ANGLE = {"H": "A", "D": "E"}
_SYMBOL = {angle: letter for letter, angle in _ANGLE.items()}


def polar_word(name: str) -> Word | None:
    """Return the word of a TPOINT term, None where it is none of an equatorial mount's."""
    if name in POLAR_NAMED:
        return Word(name, (POLAR_NAMED[name],), "arcsec", mount=MOUNT)
    match = _POLAR_HARMONIC.fullmatch(name)
    if match is None:
        return None
    result, *rest = match.groups()
    waves = tuple(
        Wave(function, _ANGLE[of], int(k or 1))
        for function, of, k in (rest[:3], rest[3:])
        if function is not None
    )
    return Word(name, ((_shape(_POLAR_RESULT[result], waves), -1),), "arcsec", mount=MOUNT)


def _shape(axis: str, waves: tuple[Wave, ...]) -> Shape:
    """Return the shape of a product of waves; one of declination is no sag, which goes by E."""
    if axis == "el" and len(waves) == 1 and waves[0][1:] == ("E", 1):
        return Shape("elevation_encoder_harmonics", "SC".index(waves[0].function), 1)
    return product(axis, *waves)


def polar_name_of(shape: Shape) -> tuple[str, int] | None:
    """Return TPOINT's name for a shape and its sign, None where TPOINT has none."""
    if shape in _POLAR_NAME_OF:
        return _POLAR_NAME_OF[shape]
    if shape.effect != PRODUCT and not shape.k:
        return None
    axis, waves = wave_product(shape)
    if not 1 <= len(waves) <= 2 or any(one.function == "P" or one.k > 9 for one in waves):
        return None
    letters = "".join(
        f"{one.function}{_SYMBOL[one.of]}{one.k if one.k > 1 else ''}" for one in waves
    )
    return f"H{_POLAR_LETTER[axis]}{letters}", -1
