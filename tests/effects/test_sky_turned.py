"""The sky turned by a finite angle: offsets are differences of the mount's angles."""

import erfa
import numpy as np
from effects.sky import SITE

from pyport.angles import ARCSEC, DEG, wrap
from pyport.effects import Circumstances
from pyport.effects.sky.frame import hour_angle, turned
from pyport.mounts import KINDS

#: As far as precession turns the sky in half a century.
ANGLE = 2500 * ARCSEC
EL = np.array([15.0, 40.0, 70.0, 85.0, 110.0]) * DEG
AZ = np.array([10.0, 130.0, 250.0, 320.0, 200.0]) * DEG

DEC = np.arcsin(
    np.sin(SITE.latitude) * np.sin(EL) + np.cos(SITE.latitude) * np.cos(EL) * np.cos(AZ)
)


def spun(kind):
    """Return circumstances, and the offsets of turning the sky about the pole toward the west."""
    at = Circumstances(AZ, EL, SITE, {"time": np.full(len(AZ), 1.2e9)}, mount=KINDS[kind])
    cos, sin = np.cos(ANGLE), np.sin(ANGLE)
    matrix = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return at, *at.along_axes(*turned(at, np.broadcast_to(matrix, (len(AZ), 3, 3))))


def test_offsets_of_a_fork_are_an_hour_angle():
    """And none in declination, however near the pole."""
    _, x, y = spun("fork")
    up = EL < 90 * DEG

    np.testing.assert_allclose(x[up], (ANGLE * np.cos(DEC))[up], atol=1e-4 * ARCSEC)
    np.testing.assert_allclose(y[up], 0.0, atol=1e-4 * ARCSEC)


def test_offsets_of_azimuth_and_elevation_are_differences_of_angles():
    """Beside the tangent they differ by tens of arcseconds; beyond the zenith, too."""
    at, x, y = spun("altaz")
    az, el = erfa.hd2ae(hour_angle(at) + ANGLE, DEC, SITE.latitude)
    over = np.cos(EL) < 0
    along = np.where(over, np.pi - el, el) - EL
    across = wrap(np.where(over, az + np.pi, az) - AZ) * np.cos(EL)

    np.testing.assert_allclose(x, across, atol=1e-4 * ARCSEC)
    np.testing.assert_allclose(y, along, atol=1e-4 * ARCSEC)
