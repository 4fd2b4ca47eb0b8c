"""The derivatives of the exact form are what finite differences say."""

import numpy as np
import pytest

from pyport.angles import DEG
from pyport.effects import Circumstances
from pyport.pointing import Rt32Model, exact_offsets, printed
from pyport.pointing.jacobian import exact_slopes
from pyport.pointing.leaning import Axis

pytestmark = pytest.mark.usefixtures("both_paths")

STEP = 1e-6


def directions(lowest, highest, n=400):
    """Return azimuths all round the cable and altitudes [rad]."""
    rng = np.random.default_rng(3)
    return rng.uniform(-270, 270, n) * DEG, rng.uniform(lowest, highest, n) * DEG


@pytest.mark.parametrize("size", [0.0, 1.0, -40.0])
@pytest.mark.parametrize("altitudes", [(-2, 85), (95, 100)])
def test_slopes_are_central_differences(size, altitudes):
    """Without tilt, with the published one and with one of degrees; in plunge too."""
    az, alt = directions(*altitudes)
    p = printed() * size
    slopes = exact_slopes(Axis.of(az), Axis.of_altitudes(alt), p)

    for k, slope in slopes.items():
        step = np.zeros(12)
        step[k] = STEP
        ahead, behind = (exact_offsets(az, alt, p + s) for s in (step, -step))
        for axis in (0, 1):
            difference = (ahead[axis] - behind[axis]) / (2 * STEP)
            np.testing.assert_allclose(slope[axis], difference, rtol=2e-7, atol=2e-7)


def test_azimuth_does_not_change_where_it_stops():
    """Within |skew + box| of the zenith the azimuth of the routine stands still."""
    p = np.zeros(12)
    p[2:4] = 0.01
    at = Circumstances(az=np.array([0.3]), el=np.array([np.pi / 2 - 0.001]))
    x, y = Rt32Model(p).slopes(at)

    assert np.isfinite([*x.values(), *y.values()]).all()
    assert x[2] == x[3] == 0
