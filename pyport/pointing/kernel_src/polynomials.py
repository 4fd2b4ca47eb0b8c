"""The polynomials of the kernel: `python polynomials.py` writes polynomials.h.

Each is what is left of a function after its first term or two, in the square z of its argument,
interpolated at the Chebyshev points of the range in fifty digits. The error beside each is that
of the rounded coefficients, as a share of the function; a double's last digit is 1.1e-16.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath

Function = Callable[[Any], Any]


def _over(function: Function) -> Function:
    """Return what is left of function(x)/x behind its 1, over z = x^2."""
    return lambda z: (function(mpmath.sqrt(z)) / mpmath.sqrt(z) - 1) / z


with mpmath.workdps(50):
    _EIGHTH, _SIXTEENTH = mpmath.pi**2 / 16, mpmath.tan(mpmath.pi / 8) ** 2
#: Name -> what the polynomial stands for, its largest z, coefficients, and with what power of z it
#: enters the function or, where that begins with x, function(x)/x.
POLYNOMIALS = {
    "SINE": (_over(mpmath.sin), _EIGHTH, 6, 1),
    "COSINE": (lambda z: (mpmath.cos(mpmath.sqrt(z)) - 1 + z / 2) / z**2, _EIGHTH, 6, 2),
    "ARCTANGENT": (_over(mpmath.atan), _SIXTEENTH, 11, 1),
    "ARCSINE": (_over(mpmath.asin), mpmath.mpf(1) / 4, 13, 1),
}


@mpmath.workdps(50)
def coefficients(name: str) -> tuple[list[float], float]:
    """Return a polynomial's coefficients, the constant first, and the largest relative error."""
    function, largest, count, power = POLYNOMIALS[name]
    angles = ((n + mpmath.mpf(1) / 2) * mpmath.pi / count for n in range(count))
    points = [largest * (1 + mpmath.cos(one)) / 2 for one in angles]
    powers = mpmath.matrix([[z**n for n in range(count)] for z in points])
    found = [float(one) for one in mpmath.lu_solve(powers, [function(z) for z in points])]
    shown = [largest * n / 200 for n in range(1, 201)]
    errors = [sum(c * z**n for n, c in enumerate(found)) - function(z) for z in shown]
    error = max(abs(one) * z**power for one, z in zip(errors, shown, strict=True))
    return found, float(error)


def header() -> str:
    """Return polynomials.h."""
    lines = ["/* Written by polynomials.py: coefficients, the constant first. */"]
    for name in POLYNOMIALS:
        found, error = coefficients(name)
        lines += ["", f"/* error {error:.1e} */", f"#define {name}_TERMS {len(found)}"]
        lines += [f"static const double {name}[{name}_TERMS] = {{"]
        lines += [f"    {one.hex()}, /* {one!r} */" for one in found]
        lines += ["};"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("polynomials.h").write_text(header())
