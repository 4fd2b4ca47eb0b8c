"""Hypothesis strategies for the inputs of pointing models: REAL*4 numbers where branches turn."""

import math

import numpy as np
from hypothesis import strategies as st
from rt32_inputs import HALF_PI, MODELA_PLUNGE

from pyport.angles import DEG


def real4(low, high):
    """Draw finite REAL*4 numbers between two bounds."""
    return st.floats(float(np.float32(low)), float(np.float32(high)), width=32).map(np.float32)


def near(value, ulp=3):
    """Draw a REAL*4 at most `ulp` units in the last place away from a threshold."""
    start = int(np.float32(value).view(np.int32))
    return st.integers(-ulp, ulp).map(lambda n: np.int32(start + n).view(np.float32))


#: Any REAL*4 at all: infinities, NaN and subnormals too.
any_real4 = st.integers(0, 2**32 - 1).map(lambda bits: np.uint32(bits).view(np.float32))

#: Azimuths [rad] over the cable's range, and at the branch of Hjump and the wrap.
azimuths = (
    real4(-270 * DEG, 270 * DEG)
    | st.sampled_from([0.0, -0.0]).map(np.float32)
    | st.sampled_from([-math.pi, math.pi, math.pi / 2, 1e-6, -1e-6]).flatmap(near)
)

#: Altitudes [rad] from below the horizon to plunge, and at every threshold of the routines.
altitudes = (
    real4(-5 * DEG, 95 * DEG)
    | st.sampled_from([0.0, -0.0]).map(np.float32)
    | st.sampled_from([HALF_PI, MODELA_PLUNGE, 1e-30, -1e-30]).flatmap(near)
)


def _curve(az):
    """Return the altitude of the jump [rad] at an azimuth [rad]."""
    if az <= 0:
        return (65 + 7 * math.cos(az / 2)) * DEG
    return (55 + ((az / DEG - 95) / 90) ** 2 * 15) * DEG


#: Azimuth and altitude within a few ulp of the jump's curve.
at_the_jump = azimuths.flatmap(lambda az: st.tuples(st.just(az), near(_curve(float(az)))))

#: Azimuth and altitude [rad] of a point anywhere, or at the jump.
directions = st.tuples(azimuths, altitudes) | at_the_jump

_sizes = st.integers(-24, 0).map(lambda quarter: 10 ** (quarter / 4))

#: One parameter [deg]: zero of either sign, or 1e-6 to 1 in size.
parameter = st.sampled_from([0.0, -0.0]).map(np.float32) | st.builds(
    lambda size, share: np.float32(size * share), _sizes, st.floats(-1, 1)
)

#: The twelve parameters [deg] of Model and ModelA, each on its own scale.
parameters = st.lists(parameter, min_size=12, max_size=12)


@st.composite
def at_the_rim(draw):
    """Draw azimuth, altitude and parameters of a point next to the rim of the blind spot.

    In one draw of two the true zenith is on the rim too: what tilt and box offset do to the azimuth
    cancels there.
    """
    radius = draw(_sizes) * DEG
    sign = draw(st.sampled_from([-1, 1]))
    p = np.zeros(12)
    p[draw(st.sampled_from([2, 3]))] = sign * radius / DEG
    off, toward = draw(_sizes), draw(st.sampled_from([0, 90, 180, 270]) | st.floats(0, 360)) * DEG
    if draw(st.booleans()):
        p[4:6] = radius / DEG * math.cos(toward), radius / DEG * math.sin(toward)
        return draw(azimuths), np.float32(math.pi / 2 - sign * 0.05 * off), np.float32(p)
    p[0] = draw(parameter)
    az = draw(azimuths)
    return az, np.float32(math.pi / 2 - radius * (1 + draw(st.floats(-1, 1)) * off)), np.float32(p)
