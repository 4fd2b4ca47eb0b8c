"""The published routines Model, ModelA and Hjump, compiled from their text.

f2py converts whatever it is given, in silence: "1.5" becomes 1.5 and 1e300 becomes infinity. The
functions here take only numbers that the build represents exactly.
"""

from __future__ import annotations

import json
from importlib.resources import files
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport_oracle import _converted, _promoted

Real = NDArray[np.floating]


def model(
    az: ArrayLike, alt: ArrayLike, p: ArrayLike, *, promoted: bool = False
) -> tuple[Real, Real]:
    """Return (dAz, dAlt) [deg] of subroutine Model at each point.

    Parameters
    ----------
    az, alt
        Azimuth from South through West and altitude [rad], shape (n,).
    p
        The twelve parameters [deg], shape (12,) or (n, 12).
    promoted
        Call the build in which every REAL*4 is REAL*8 instead of the reference build.

    Raises
    ------
    TypeError
        For anything but real numbers.
    ValueError
        For a number that is not exactly one of the build's REALs, or a wrong shape.
    """
    build, arguments = _arguments(az, alt, p, promoted=promoted)
    daz, dalt = build.models(*arguments)
    return daz, dalt


def modela(
    az: ArrayLike, alt: ArrayLike, p: ArrayLike, *, promoted: bool = False
) -> tuple[Real, Real]:
    """Return (dAz, dAlt) [deg] of subroutine ModelA; arguments as for :func:`model`."""
    build, arguments = _arguments(az, alt, p, promoted=promoted)
    daz, dalt = build.modelas(*arguments)
    return daz, dalt


def hjump(az: ArrayLike, alt: ArrayLike, *, promoted: bool = False) -> Real:
    """Return function Hjump: 0 or 1, and the jump's altitude [deg] where `alt` is negative."""
    build, arguments = _arguments(az, alt, promoted=promoted)
    jump: Real = build.hjumps(*arguments)
    return jump


def provenance() -> dict[str, object]:
    """Return the compiler, the flags, and the SHA-256 of each published file."""
    folder = files(__name__)
    record: dict[str, object] = json.loads(folder.joinpath("provenance.json").read_text())
    rows = folder.joinpath("SHA256SUMS").read_text().splitlines()
    record["published_sha256"] = {name: digest for digest, name in map(str.split, rows)}
    return record


def _arguments(
    az: ArrayLike, alt: ArrayLike, p: ArrayLike | None = None, *, promoted: bool
) -> tuple[ModuleType, list[Real]]:
    """Return the build to call and its arguments, each of the build's own REAL."""
    build, real = (_promoted, np.float64) if promoted else (_converted, np.float32)
    arguments = [_exactly("az", az, real), _exactly("alt", alt, real)]
    shape = arguments[0].shape
    if len(shape) != 1 or arguments[1].shape != shape:
        raise ValueError(f"az and alt must have one shape (n,): {shape}, {arguments[1].shape}")
    if p is not None:
        parameters = _exactly("p", p, real)
        if parameters.shape not in {(12,), (*shape, 12)}:
            raise ValueError(f"p must have shape (12,) or (n, 12), not {parameters.shape}")
        arguments.append(np.asfortranarray(np.broadcast_to(parameters, (*shape, 12)).T))
    return build, arguments


def _exactly(name: str, values: ArrayLike, real: type[np.floating]) -> Real:
    """Return `values` as the build's REAL; raise where that would change one."""
    given = np.asarray(values)
    if given.dtype.kind not in "fiu":
        raise TypeError(f"{name} must hold real numbers, not {given.dtype}")
    with np.errstate(over="ignore"):
        converted = given.astype(real)
    same = (converted == given) | (np.isnan(converted) & np.isnan(given))
    if not same.all():
        raise ValueError(f"{name}: {given[~same].flat[0]!r} is no {np.dtype(real).name}")
    return converted
