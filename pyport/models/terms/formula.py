"""A user's term by its formula: `x = sin 3A sin E, y = -cos 2A`, as the table of signs has them.

x is the offset across the sky and y the one in elevation, encoder minus true; A and E are azimuth
from north through east and elevation, Z is zenith distance. A product has sines and cosines of
multiples of them, and powers of E and Z in radians.
"""

from __future__ import annotations

import re

from pyport.errors import BadInput
from pyport.models.terms.shapes import Shape, Wave, product
from pyport.models.terms.tpoint import upward
from pyport.models.terms.words import Word

_PART = re.compile(r"([xy])\s*=\s*([-+]?)\s*(.+)")
_FACTOR = re.compile(
    r"(sin|cos)\s*([1-9]?)\s*([AEZ])(?![A-Za-z^])|([EZ])(?:\^([1-9]))?(?![A-Za-z])"
)
_SEPARATED = re.compile(r"\s*\*?\s*")
_AXIS = {"x": "xel", "y": "el"}
_ZEROS = {"x": Shape("collimation"), "y": Shape("elevation_zero")}


def word(name: str, formula: str) -> Word:
    """Return the word that a formula makes of a name, its coefficient in arcseconds.

    Raises `BadInput`: it is no such formula.
    """
    parts = [_part(name, text.strip()) for text in formula.split(",")]
    return Word(name, tuple(parts), "arcsec")


def _part(name: str, text: str) -> tuple[Shape, float]:
    match = _PART.fullmatch(text)
    if match is None:
        raise _wrong(name, text)
    axis, minus, rest = match.groups()
    sign = -1.0 if minus == "-" else 1.0
    if rest == "1":
        return _ZEROS[axis], sign
    waves: list[Wave] = []
    place = 0
    while place < len(rest):
        factor = _FACTOR.match(rest, place)
        if factor is None:
            raise _wrong(name, text)
        wave, turn = upward(_wave(factor))
        waves.append(wave)
        sign *= turn
        separated = _SEPARATED.match(rest, factor.end())
        place = factor.end() if separated is None else separated.end()
    return _shape(_AXIS[axis], waves), sign


def _wave(factor: re.Match[str]) -> Wave:
    function, k, angle, power_of, power = factor.groups()
    if function is None:
        return Wave("P", power_of, int(power or 1))
    return Wave(function[0].upper(), angle, int(k or 1))


def _shape(axis: str, waves: list[Wave]) -> Shape:
    """Return the shape of a product; across the sky, cos E and more are an azimuth's."""
    level = Wave("C", "E")
    if axis == "xel" and len(waves) > 1 and level in waves:
        waves.remove(level)
        return product("az", *waves)
    return product(axis, *waves)


def _wrong(name: str, text: str) -> BadInput:
    wanted = "expected such as 'x = sin 3A sin E' or 'y = -cos 2A', commas between them"
    return BadInput(f"{name[:20]} is {text[:60]!r}, {wanted}")
