"""Effects that look alike: which, under which circumstances, and what distinguishes them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from pyport.effects import known
from pyport.effects.mounts import said
from pyport.mounts import ALTAZ, BY_MODEL, Mount


@dataclass(frozen=True)
class Alike:
    """Two effects that recordings may not distinguish."""

    ids: tuple[str, str]  #: the two
    where: str  #: under which circumstances, one of :data:`WHERE`
    decide: str  #: the observation that distinguishes them
    beside: tuple[str, ...] = ()  #: effects that are fitted together with them, as most models do
    exact: bool = True  #: true where the two draw the same curves, False where nearly the same


#: Circumstances under which effects look alike, in words.
WHERE = {
    "always": "whatever one antenna observes",
    "wide": "over 10 to 85 deg of elevation",
    "narrow": "over 30 to 60 deg of elevation",
    "one night": "within a day or two",
    "one year": "in sessions over a year",
    "azimuth only": "where azimuth alone was measured",
    "elevation only": "where elevation alone was measured",
    "south": "with sources that all culminate on the equator's side of the zenith",
    "steady air": "in air that hardly changes",
    "one frequency": "at one frequency",
    "one rate": "with scans at one rate",
    "near targets": "with targets that are all equally near",
    "seasons": "where each session has a temperature of its own",
    "slow season": "where the temperature changes slowly",
    "box swaps": "where each session has a receiver of its own",
    "channels": "where each receiver has a channel of its own",
    "one hour": "at one time of the day",
    "own hours": "where each session has a time of the day of its own",
    "wind": "in a steady wind from where the Sun is",
    "two epochs": "in two campaigns far apart",
    "one season": "within some weeks",
    "prevailing wind": "in a wind from always the same side",
    "two turns": "in azimuths over two turns",
    "rotator with elevation": "where the rotator turns as the elevation does",
}

#: What nearly every model fits beside an effect under test.
USUAL = ("azimuth_zero", "elevation_zero", "collimation", "skew", "tilt", "sag_cosine")

_INCLINOMETER = "read an inclinometer on the azimuth axis"
_SURVEY = (
    f"{_INCLINOMETER}, or compare with surveyed coordinates: over an array a site error grows "
    "with the distance from the reference, a tilt does not"
)
_AT_REST = "point at what does not move with the sky (a mast, a geostationary satellite)"
_MAST = f"{_AT_REST}, or compare antennas: a clock error is one for all"
_LEVEL = "read the elevation on a level: gravity bends the dish and leaves the encoder right"
_LOW = "observe below 15 deg elevation, where cot E turns up"
_WIDER = "observe over a wider range of elevation"
_HALF_A_YEAR = "observe again after half a year: what the sky does has changed by then"
_IN_BETWEEN = "observe in between: a step stays a step, a slow change fills in"
_ACROSS = "follow single sources through the edge: a step is sudden, a curve is not"
_SWAP = "put one box back, or swap both within a session"
_WARM_AND_COLD = "observe through a warm day and a cold night of one session"
_DAY_AND_NIGHT = "observe through a day and a night, under cloud and in the sun"


def _nearly(one: str, other: str, where: str, decide: str, beside: tuple[str, ...] = ()) -> Alike:
    return Alike((one, other), where, decide, beside, exact=False)


ALIKE = (
    # The frame of the sky and the mount.
    Alike(("site_latitude", "tilt"), "always", _SURVEY),
    Alike(
        ("site_longitude", "tilt"),
        "always",
        "find the azimuth zero by a survey (a longitude error turns it with the sky), "
        f"or {_INCLINOMETER}",
        ("azimuth_zero",),
    ),
    Alike(("clock", "tilt"), "always", _MAST, ("azimuth_zero",)),
    Alike(
        ("epoch_clock", "epoch_tilt"),
        "elevation only",
        f"measure azimuth where it was not, or {_MAST}",
    ),
    Alike(
        ("site_longitude", "clock"),
        "always",
        "compare antennas: a clock error is one for all, a longitude error is each one's own; "
        "or compare days: a longitude stays",
    ),
    _nearly(
        "polar_motion",
        "tilt",
        "one night",
        f"take the pole from the IERS: its share must come out one; or {_INCLINOMETER}",
        ("azimuth_zero",),
    ),
    _nearly("polar_motion", "epoch_tilt", "one year", _INCLINOMETER, USUAL),
    # Drives that follow the sky.
    Alike(
        ("servo_lag_azimuth", "clock"),
        "azimuth only",
        f"measure elevation where it was not, or {_MAST}",
    ),
    Alike(
        ("servo_lag_elevation", "clock"),
        "elevation only",
        f"measure azimuth where it was not, or {_MAST}",
    ),
    Alike(("servo_lag_azimuth", "site_longitude"), "azimuth only", _MAST),
    Alike(("servo_lag_elevation", "site_longitude"), "elevation only", _MAST),
    Alike(
        ("servo_lag_azimuth", "servo_lag_elevation"),
        "always",
        "drive one axis at a time, at several rates, and read its servo error",
        ("azimuth_zero", "tilt"),
    ),
    Alike(
        ("backlash_azimuth", "azimuth_zero"),
        "south",
        "observe between the pole and the zenith, where azimuth runs backwards",
    ),
    _nearly(
        "backlash_elevation",
        "subreflector_jump",
        "wide",
        "come to one source from above and from below: backlash changes its sign",
        USUAL,
    ),
    Alike(
        ("scan_direction", "scan_timing"),
        "one rate",
        "scan once more at half the rate: a time tag shifts the peak half as far, "
        "mechanical play by the same amount; or compare days: only a time tag differs between them",
    ),
    # Positions on the sky.
    _nearly("precession", "nutation", "one night", _HALF_A_YEAR),
    _nearly("precession", "source_position", "one night", _HALF_A_YEAR),
    _nearly("nutation", "source_position", "one night", _HALF_A_YEAR),
    _nearly("annual_aberration", "source_position", "one night", _HALF_A_YEAR),
    Alike(
        ("clock", "source_position"),
        "always",
        "observe other sources: a clock error turns all right ascensions by one angle",
    ),
    Alike(
        ("site_longitude", "source_position"),
        "always",
        "observe other sources: a longitude error turns all right ascensions by one angle",
    ),
    Alike(("parallax", "sag_cosine"), "near targets", "observe stars too: they have no parallax"),
    _nearly(
        "azimuth_eccentricity",
        "diurnal_aberration",
        "wide",
        "look at the size: aberration by the Earth's spin is never above 0.32 arcsec",
        USUAL,
    ),
    # The air.
    Alike(
        ("refraction", "wet_refraction"),
        "steady air",
        "observe in dry and in humid air: only water vapour follows the humidity",
    ),
    _nearly(
        "refraction",
        "ionosphere",
        "one frequency",
        "observe at another frequency: the ionosphere goes with its inverse square",
    ),
    _nearly(
        "refraction",
        "refraction_curvature",
        "wide",
        "observe between 3 and 15 deg elevation",
        USUAL,
    ),
    # Curves of elevation.
    _nearly("refraction", "sag_cosine", "narrow", _LOW, ("elevation_zero",)),
    _nearly("refraction", "sag_sine", "narrow", _LOW, ("elevation_zero", "sag_cosine")),
    _nearly("refraction", "elevation_scale", "wide", _LOW, USUAL),
    _nearly("refraction", "elevation_encoder_harmonics", "wide", _LOW, USUAL),
    _nearly("elevation_zero", "sag_cosine", "wide", _WIDER),
    _nearly("elevation_zero", "sag_sine", "wide", _WIDER),
    _nearly("elevation_scale", "sag_sine", "wide", "read the elevation on a level or a collimator"),
    _nearly("elevation_encoder_harmonics", "sag_cosine", "wide", _LEVEL),
    _nearly("elevation_encoder_harmonics", "sag_sine", "wide", _LEVEL),
    _nearly("elevation_encoder_harmonics", "elevation_scale", "wide", _WIDER),
    _nearly("subreflector_jump", "sag_sine", "wide", _ACROSS),
    _nearly("subreflector_jump", "elevation_scale", "wide", _ACROSS),
    _nearly("subreflector_jump", "elevation_encoder_harmonics", "wide", _ACROSS),
    _nearly("azimuth_zero", "collimation", "wide", _WIDER),
    _nearly("collimation", "skew", "wide", _WIDER),
    _nearly("azimuth_zero", "skew", "narrow", _WIDER, ("collimation",)),
    _nearly(
        "azimuth_turns",
        "azimuth_scale",
        "two turns",
        "observe along the whole of one turn: a wrong rate adds up within it, a step does not",
        ("azimuth_zero",),
    ),
    # The rail turns both axes; an encoder only one.
    Alike(
        ("azimuth_track", "azimuth_harmonics"),
        "always",
        "level the mount around the circle, or compare with elevation: a rail moves both axes",
    ),
    Alike(
        ("azimuth_track", "elevation_harmonics"),
        "always",
        "level the mount around the circle, or compare with azimuth: a rail moves both axes",
    ),
    # Time, weather and boxes.
    _nearly("epoch_offset", "drift", "two epochs", _IN_BETWEEN, USUAL),
    Alike(
        ("temperature", "epoch_offset"),
        "seasons",
        _WARM_AND_COLD,
        ("collimation", "elevation_zero"),
    ),
    _nearly(
        "temperature", "drift", "slow season", "observe at the same temperature in another season"
    ),
    Alike(
        ("epoch_offset", "receiver_offset"), "box swaps", _SWAP, ("collimation", "elevation_zero")
    ),
    Alike(("receiver_offset", "beam_squint"), "channels", _SWAP, ("collimation", "elevation_zero")),
    _nearly(
        "epoch_offset",
        "epoch_sag",
        "one year",
        "observe each session over all elevations: a zero is the same everywhere",
    ),
    Alike(("thermal_tilt", "tilt"), "one hour", _DAY_AND_NIGHT),
    Alike(("thermal_tilt", "epoch_tilt"), "own hours", _DAY_AND_NIGHT, ("tilt",)),
    Alike(("thermal_tilt", "wind_tilt"), "wind", "observe on a calm day and on a cloudy one"),
    # What turns the image.
    Alike(
        ("nasmyth", "sag_sine"),
        "always",
        "rotate the camera by half a turn, or change to the other platform: an offset from the "
        "axis changes its sign, sag does not",
        USUAL,
    ),
    Alike(
        ("rotator_circle", "nasmyth"), "rotator with elevation", "turn the rotator at one elevation"
    ),
    Alike(
        ("rotator_circle", "source_position"),
        "always",
        "rotate the camera by half a turn: what is off its axis changes its sign, an error of "
        "positions does not",
    ),
    # What a condition drives.
    Alike(("driven_term", "epoch_tilt"), "seasons", _WARM_AND_COLD, ("tilt",)),
    _nearly(
        "driven_term",
        "thermal_tilt",
        "one season",
        "observe in another season, when the Sun is elsewhere at the same hour",
    ),
    _nearly(
        "driven_term",
        "wind_tilt",
        "prevailing wind",
        "observe in a wind from another side",
        ("tilt",),
    ),
    _nearly(
        "driven_term",
        "drift",
        "one night",
        "observe in more nights: what goes with the hour comes back, a drift does not",
        ("collimation", "elevation_zero"),
    ),
)

_ONE_FOR_ALL = "compare telescopes: an error of the clock is one for all"
_OTHER_SIDE = "come to a source from the other side of it: play changes its sign, a zero does not"
_FIXED = f"{_AT_REST}, or {_INCLINOMETER}"
#: The same on mounts other than alt-azimuth ones, by their model; ids are those of an alt-azimuth
#: mount. The sky turns an equatorial mount about its first axis alone; it turns an X-Y mount as a
#: zero and a lean of that axis do.
ELSEWHERE: dict[str, tuple[Alike, ...]] = {
    "equatorial": (
        Alike(("clock", "azimuth_zero"), "always", _ONE_FOR_ALL),
        Alike(("site_longitude", "azimuth_zero"), "always", _ONE_FOR_ALL),
        Alike(("backlash_azimuth", "azimuth_zero"), "always", _OTHER_SIDE),
        Alike(
            ("servo_lag_azimuth", "azimuth_zero"),
            "always",
            "follow the sky at another rate, or stand still: a lag goes with the rate",
        ),
        Alike(
            ("fork_flexure", "tilt"),
            "elevation only",
            "measure azimuth where it was not: an axis that leans moves it, a fork does not",
        ),
    ),
    "xy": (
        Alike(("clock", "tilt"), "always", _FIXED, ("azimuth_zero",)),
        Alike(("site_longitude", "tilt"), "always", _FIXED, ("azimuth_zero",)),
        Alike(("site_latitude", "tilt"), "always", _FIXED, ("azimuth_zero",)),
        *(
            _nearly(
                "sag_cosine",
                other,
                "always",
                "hold the scale of elevation at what an inclinometer on the tube says",
                ("elevation_scale",),
            )
            for other in ("azimuth_scale", "azimuth_eccentricity")
        ),
    ),
}

#: The observation that distinguishes two effects, by their ids.
DECIDE_BY: dict[frozenset[str], str] = {frozenset(one.ids): one.decide for one in ALIKE}

#: Terms of a model that elevation alone distinguishes, and what would do it better.
BY_ELEVATION = {
    frozenset({"azimuth_zero", "collimation", "skew"}): (
        "only cos E, 1 and sin E distinguish them: observe from the horizon to the zenith"
    ),
    frozenset({"elevation_zero", "sag_cosine", "sag_sine", "elevation_scale", "refraction"}): (
        "all are smooth in elevation: observe from the horizon to the zenith"
    ),
}


def decisions(members: Collection[str]) -> list[str]:
    """Return the observations that distinguish the members of a class, each once.

    The members are ids on any one mount, in whose words it is said.
    """
    effects = [effect for name in members if (effect := known(name)) is not None]
    plain = {one.on_altaz for one in effects}
    mount = next((BY_MODEL[one.mounts[0]] for one in effects if one.of), ALTAZ)
    pairs = [(frozenset(one.ids), one.decide) for one in ELSEWHERE.get(mount.model, ())]
    found = [decide for pair, decide in (*pairs, *DECIDE_BY.items()) if pair <= plain]
    return list(dict.fromkeys(said(one, mount.words) for one in found))


def alike(effect: str, mount: Mount = ALTAZ) -> list[tuple[str, Alike]]:
    """Return what an effect may be taken for on a mount: the other's id and how they look alike.

    The ids are those of an alt-azimuth mount.
    """
    pairs = ALIKE if mount is ALTAZ else ELSEWHERE.get(mount.model, ())
    return [
        (other, one) for one in pairs if effect in one.ids for other in one.ids if other != effect
    ]
