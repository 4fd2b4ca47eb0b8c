"""A telescope of rotations does what first-order geometry says, with the right signs."""

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG, wrap
from pyport.examiner.worlds.mount import Mount, Wave, axes, beam, direction, readings

AZ, EL = (grid.ravel() for grid in np.meshgrid(np.arange(-170, 190, 20.0), [5.0, 30, 55, 80]))
AZ, EL = AZ * DEG, EL * DEG

FIRST_ORDER = {
    "tilt_north": (np.sin(EL) * np.sin(AZ), np.cos(AZ)),
    "tilt_east": (-np.sin(EL) * np.cos(AZ), np.sin(AZ)),
    "roll": (-np.sin(EL), 0),
    "pitch": (0, 1),
    "yaw": (np.cos(EL), 0),
    "skew": (np.sin(EL), 0),
    "sag_cosine": (0, np.cos(EL)),
    "sag_sine": (0, np.sin(EL)),
    "beam_left": (1, 0),
    "beam_down": (0, 1),
    "azimuth_zero": (np.cos(EL), 0),
    "elevation_zero": (0, 1),
    "azimuth_scale": (AZ * np.cos(EL), 0),
    "elevation_scale": (0, EL),
    "centre_right": (-np.cos(AZ) * np.cos(EL), 0),
    "centre_ahead": (np.sin(AZ) * np.cos(EL), 0),
}


def offsets(mount):
    """Return encoder minus true on the sky [rad]."""
    az, el = readings(mount, *axes(mount, AZ, EL))
    return wrap(az - AZ) * np.cos(EL), el - EL


@pytest.mark.parametrize("part", FIRST_ORDER)
def test_each_part_askew_gives_its_first_order_offset(part):
    """An arcsecond of anything gives what geometry says, to a thousandth of it."""
    x, y = offsets(Mount(**{part: ARCSEC}))
    expected_x, expected_y = FIRST_ORDER[part]

    np.testing.assert_allclose(x / ARCSEC, expected_x + 0 * AZ, atol=1e-3)
    np.testing.assert_allclose(y / ARCSEC, expected_y + 0 * AZ, atol=1e-3)


@pytest.mark.parametrize("on", ["az", "el"])
def test_a_wave_is_read_on_its_encoder(on):
    """The third harmonic of azimuth appears on the encoder that has it, and on no other."""
    x, y = offsets(Mount(waves=(Wave(on, "az", 3, 2 * ARCSEC, -ARCSEC),)))
    wave = 2 * np.sin(3 * AZ) - np.cos(3 * AZ)

    np.testing.assert_allclose(x / ARCSEC, wave * np.cos(EL) * (on == "az"), atol=1e-6)
    np.testing.assert_allclose(y / ARCSEC, wave * (on == "el"), atol=1e-6)


def test_the_axes_found_put_the_beam_on_the_source():
    """With everything askew by minutes the beam still arrives, to a picoradian."""
    askew = dict.fromkeys(("tilt_north", "tilt_east", "skew", "beam_left", "sag_cosine"), 1e-3)
    mount = Mount(**askew, roll=-5e-4, pitch=3e-4, yaw=2e-3, sag_sine=-1e-3, beam_down=4e-4)

    arrived = beam(mount, *axes(mount, AZ, EL))

    np.testing.assert_allclose(arrived, direction(AZ, EL), atol=1e-12)


def test_parts_may_differ_from_pointing_to_pointing():
    """A tilt given for each pointing acts on that pointing alone."""
    tilted = np.arange(len(AZ)) % 2 == 0
    x, y = offsets(Mount(tilt_north=np.where(tilted, ARCSEC, 0.0)))

    assert np.all(np.hypot(x, y)[~tilted] < 1e-15)
    np.testing.assert_allclose(y[tilted] / ARCSEC, np.cos(AZ[tilted]), atol=1e-3)
