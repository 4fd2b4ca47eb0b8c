"""The azimuth track, or bearing: how the mount rocks as it turns."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import AXES, Circumstances, Coefficient, Effect, stack
from pyport.effects.mounts import times
from pyport.effects.telescope.encoders import harmonics


def azimuth_track(k: int) -> Effect:
    """Return the k-th harmonic of a rail: F2 sin E - F1 cos E across, F3 along elevation.

    At each azimuth the mount is twisted by F1 about the vertical, leans by F2
    sideways and by F3 backwards; each is a wave (sin kA, cos kA). k = 1 is a tilt.
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        sin_e, cos_e = np.sin(at.el), np.cos(at.el)
        waves = np.sin(k * at.az), np.cos(k * at.az)
        return stack(
            at,
            *[(-cos_e * wave, 0) for wave in waves],
            *[(sin_e * wave, 0) for wave in waves],
            *[(0, wave) for wave in waves],
        )

    return Effect(
        "azimuth_track",
        "the mount rocks as it turns in azimuth",
        "Lew 2018, Experimental Astronomy 45, 81: the rail of the RT32",
        tuple(
            Coefficient(f"track_{motion}_{phase}")
            for motion in ("twist", "roll", "pitch")
            for phase in ("sine", "cosine")
        ),
        basis,
        variant=f"k = {k}",
        profile=_tracks,
        formula=("F2(A) sin E - F1(A) cos E", "F3(A), each F = s sin kA + c cos kA, k >= 2"),
        parameter=k,
        member={"k": k},
        make=azimuth_track,
        acts_in=AXES,
        mounts=("altaz",),
        pattern=f"{times(k)} per turn of azimuth, in both axes",
        means={
            "wheel-and-track": "the track, not level or not round",
            "bearing": "the azimuth bearing, not flat or not round",
        },
    )


def _tracks(at: Circumstances) -> tuple[Effect, ...]:
    return tuple(map(azimuth_track, harmonics(at)))


EFFECTS = (azimuth_track(2),)
