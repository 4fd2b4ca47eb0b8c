"""Fortran's intrinsic functions as the reference build computes them.

A Fortran REAL*8 is a Python float here and the C library's double functions, which ``math`` calls,
are gfortran's too. A REAL*4 is a ``numpy.float32``, whose arithmetic rounds once an operation; its
sine is the C library's ``sinf``, since a rounded double sine differs from it in a few cases of a
hundred. Where ``math`` raises, Fortran returns NaN.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable

import numpy as np

_SINGLE = ctypes.CDLL(None)


def _single(name: str) -> Callable[[np.float32], np.float32]:
    """Return the C library's REAL*4 function of that name."""
    function = getattr(_SINGLE, name)
    function.argtypes = [ctypes.c_float]
    function.restype = ctypes.c_float

    def call(x: np.float32) -> np.float32:
        return np.float32(function(x))

    return call


def or_nan(function: Callable[..., float]) -> Callable[..., float]:
    """Return a function of ``math`` as one that gives NaN outside its domain."""

    def call(*x: float) -> float:
        try:
            return function(*x)
        except ValueError:
            return math.nan

    return call


dsin = or_nan(math.sin)
dcos = or_nan(math.cos)
dasin = or_nan(math.asin)
dmod = or_nan(math.fmod)
dsqrt = or_nan(math.sqrt)
datan2 = math.atan2
dsign = math.copysign

sin = _single("sinf")
cos = _single("cosf")
tan = _single("tanf")


def amod(a: np.float32, p: np.float32) -> np.float32:
    """Return the REAL*4 remainder of a / p with the sign of a; the remainder is exact."""
    return np.float32(dmod(float(a), float(p)))


def sign(a: np.float32, b: np.float32) -> np.float32:
    """Return |a| with the sign of b, that of a signed zero included."""
    return np.float32(np.copysign(a, b))
