"""TPOINT's terms for equatorial mounts: what is to be added to the hour angle and declination read.

Its terms give true minus read, ours are read minus true. Hour angle and declination are counted
as here, so that every sign but those of what gravity and the air do is turned: `docs/mounts.md`
derives each.
"""

from __future__ import annotations

import re

from pyport.models.terms.shapes import PRODUCT, Shape, Wave, product, wave_product
from pyport.models.terms.words import Word

MOUNT = "equatorial"
#: Terms with a name of their own -> shape about the mount's axes, and sign.
NAMED: dict[str, tuple[Shape, int]] = {
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
_NAME_OF = {shape: (name, sign) for name, (shape, sign) in reversed(NAMED.items())}

#: Result (hour angle, on the sky, declination), then one wave or two of either angle.
_HARMONIC = re.compile(r"H([HXD])([SC])([HD])([1-9]?)(?:([SC])([HD])([1-9]?))?")
_RESULT = {"H": "az", "X": "xel", "D": "el"}
_LETTER = {axis: letter for letter, axis in _RESULT.items()}
_ANGLE = {"H": "A", "D": "E"}
_SYMBOL = {angle: letter for letter, angle in _ANGLE.items()}


def word(name: str) -> Word | None:
    """Return the word of a TPOINT term, None where it is none of an equatorial mount's."""
    if name in NAMED:
        return Word(name, (NAMED[name],), "arcsec", mount=MOUNT)
    match = _HARMONIC.fullmatch(name)
    if match is None:
        return None
    result, *rest = match.groups()
    waves = tuple(
        Wave(function, _ANGLE[of], int(k or 1))
        for function, of, k in (rest[:3], rest[3:])
        if function is not None
    )
    return Word(name, ((_shape(_RESULT[result], waves), -1),), "arcsec", mount=MOUNT)


def _shape(axis: str, waves: tuple[Wave, ...]) -> Shape:
    """Return the shape of a product of waves; one of declination is no sag, which goes by E."""
    if axis == "el" and len(waves) == 1 and waves[0][1:] == ("E", 1):
        return Shape("elevation_encoder_harmonics", "SC".index(waves[0].function), 1)
    return product(axis, *waves)


def name_of(shape: Shape) -> tuple[str, int] | None:
    """Return TPOINT's name for a shape and its sign, None where TPOINT has none."""
    if shape in _NAME_OF:
        return _NAME_OF[shape]
    if shape.effect != PRODUCT and not shape.k:
        return None
    axis, waves = wave_product(shape)
    if not 1 <= len(waves) <= 2 or any(one.function == "P" or one.k > 9 for one in waves):
        return None
    told = "".join(f"{one.function}{_SYMBOL[one.of]}{one.k if one.k > 1 else ''}" for one in waves)
    return f"H{_LETTER[axis]}{told}", -1
