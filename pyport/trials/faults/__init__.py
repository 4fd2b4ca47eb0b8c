"""Hidden causes by name: of the catalogue, and strangers to it."""

from __future__ import annotations

from pyport.trials.faults import heavens, mount, moving, strangers, surroundings, times
from pyport.trials.faults.base import Draw, Fault

#: Causes that the catalogue of effects names, by its names ("ut1" is a `clock`).
CATALOGUED: dict[str, Draw] = {
    **mount.FAULTS,
    **heavens.FAULTS,
    **moving.FAULTS,
    **surroundings.FAULTS,
    **times.FAULTS,
}

#: Causes that no catalogue names.
STRANGERS: dict[str, Draw] = strangers.FAULTS

#: Causes that the altaz base swallows whole, or all but: hidden only from a model that is held.
SWALLOWED = (
    "azimuth_zero",
    "elevation_zero",
    "collimation",
    "skew",
    "tilt",
    "sag_cosine",
    "site_latitude",
    "site_longitude",
    "clock",
    "ut1",
    "polar_motion",
)

#: Causes that are smaller than what any of these telescopes measures.
TOO_SMALL = ("diurnal_aberration",)

__all__ = ["CATALOGUED", "STRANGERS", "SWALLOWED", "TOO_SMALL", "Draw", "Fault"]
