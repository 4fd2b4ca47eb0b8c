"""Real recordings of two telescopes whose models were published by others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.diagnosis import two_axes_words
from pyport.effects import CATALOGUE
from pyport.examiner.acceptance import auxtel
from pyport.examiner.acceptance.drawn import Line
from pyport.examiner.acceptance.said import diagnosed, said
from pyport.recordings import read
from pyport.recordings.raw import FileOptions
from pyport.recordings.schema import Recordings

#: The Large Millimeter Telescope's list has no line of names.
_LMT_COLUMNS = (
    *("date_utc", "ut_h", "obsnum", "source", "az_deg", "el_deg"),
    *("d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec"),
)
_LMT_SITE = {"latitude_deg": "18.9857", "longitude_deg": "-97.3148"}
#: What was published for the LMT: coefficients [arcsec] by axis, in the order of the effects.
_LMT_TERMS = {
    "xel": (("collimation", "skew", "azimuth_zero", "tilt"), (-0.329, 25.016, 774.087)),
    "el": (
        ("elevation_zero", "refraction", "sag_cosine", "sag_sine", "tilt"),
        (216.482, 42.089, -23.064, 84.802),
    ),
}
_LMT_RMS = {"xel": 2.0077, "el": 3.7337}


def lines(data: Path) -> Iterator[Line]:
    """Yield the figures of both telescopes' recordings in a folder of data."""
    yield from lmt(data / "lmt" / "PointingData.csv")
    yield from auxtel.lines(data / "auxtel")


def lmt(file: Path) -> Iterator[Line]:
    """Yield the published terms, refitted, and what is said of the tilt of each axis."""
    recordings = read(file, FileOptions(_LMT_SITE, _LMT_COLUMNS))
    for axis, (names, published) in _LMT_TERMS.items():
        values, covariance, rms = _fitted(recordings, names, axis)
        sigma = np.sqrt(np.diag(covariance))
        off = np.abs(values[: len(published)] - published) / sigma[: len(published)]
        what = f"LMT, {axis}: published terms are off by at most"
        yield Line(what, f"{off.max():.2f} sigma", "1 sigma", bool(off.max() <= 1))
        told = f"{rms:.4f} arcsec, published {_LMT_RMS[axis]}"
        yield Line(f"LMT, {axis}: rms", told, "the same", abs(rms - _LMT_RMS[axis]) < 0.01)
    found = diagnosed(recordings, "altaz")
    apart = [one for one in found.two_axes if one.chosen.candidate.effect.id == "tilt"]
    told = two_axes_words.sentence(apart[0]) if apart else "nothing"
    far = bool(apart) and apart[0].found.sigmas >= 3
    yield Line("LMT: diagnose says of the tilts of both axes", told, "apart by 3 sigma", far)
    yield Line("LMT: diagnose finds", said(found), "shown", None)


def _fitted(
    recordings: Recordings, names: tuple[str, ...], axis: str
) -> tuple[Array, Array, float]:
    """Return values and covariance [arcsec] and rms of a plain fit of some effects to one axis."""
    at = recordings.at
    which = 0 if axis == "xel" else 1
    columns = np.concatenate([CATALOGUE[name].columns(at)[which] for name in names], axis=1)
    data = (recordings.x, recordings.y)[which] / ARCSEC
    units = np.array([c.scale for name in names for c in CATALOGUE[name].coefficients]) / ARCSEC
    columns = columns * units
    values, *_ = np.linalg.lstsq(columns, data, rcond=None)
    left = data - columns @ values
    spare = len(data) - columns.shape[1]
    covariance = np.linalg.inv(columns.T @ columns) * float(left @ left) / spare
    return values, covariance, float(np.sqrt(np.mean(left**2)))
