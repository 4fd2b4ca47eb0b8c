"""Cases of what is wrong with the mount, by rotations."""

from dataclasses import replace

import numpy as np
from effects.cases import AT, Case
from effects.mount import encoders, from_platform, turned
from effects.sky import two_turns

from pyport.angles import ARCSEC, DEG
from pyport.effects import CATALOGUE


def mounted(effect, amounts, make, **more):
    """Return a case of a mount whose flaws are `make(amplitude)`."""
    return Case(effect, amounts, lambda size: encoders(AT.az, AT.el, **make(size)), **more)


def wave(size, k, sine, cosine):
    """Return angle -> a harmonic of an amplitude in arcseconds."""
    return lambda angle: size * ARCSEC * (sine * np.sin(k * angle) + cosine * np.cos(k * angle))


def decentred(size):
    """Return how much more a circle of radius one reads when its centre is 30", -20" off."""

    def excess(angle):
        mark = np.exp(1j * angle) - size * ARCSEC * (-20 + 30j)
        return np.angle(mark * np.exp(-1j * angle))

    return excess


def leaning(size, toward):
    """Return a lean of `size` toward an azimuth, row by row."""
    return {"lean": (size * np.cos(toward), size * np.sin(toward))}


MOUNT = [
    mounted("azimuth_zero", (40.0,), lambda s: {"read_az": lambda _: s * 40 * ARCSEC}),
    mounted("elevation_zero", (40.0,), lambda s: {"read_el": lambda _: s * 40 * ARCSEC}),
    mounted("collimation", (40.0,), lambda s: {"beam_left": s * 40 * ARCSEC}),
    mounted("skew", (40.0,), lambda s: {"right_end_up": s * 40 * ARCSEC}),
    mounted("tilt", (30.0, -20.0), lambda s: {"lean": (s * 30 * ARCSEC, -s * 20 * ARCSEC)}),
    mounted("sag_cosine", (60.0,), lambda s: {"droop": lambda el: s * 60 * ARCSEC * np.cos(el)}),
    mounted("sag_sine", (60.0,), lambda s: {"droop": lambda el: s * 60 * ARCSEC * np.sin(el)}),
    mounted("azimuth_eccentricity", (-20.0, -30.0), lambda s: {"read_az": decentred(s)}),
    mounted(
        "azimuth_harmonics",
        (30.0, -20.0),
        lambda s: {"read_az": wave(s, 3, 30, -20)},
        variant="k = 3",
    ),
    mounted(
        "elevation_harmonics",
        (30.0, -20.0),
        lambda s: {"pitch": wave(s, 4, 30, -20)},
        variant="k = 4",
    ),
    mounted(
        "elevation_encoder_harmonics",
        (30.0, -20.0),
        lambda s: {"read_el": wave(s, 5, 30, -20)},
        variant="k = 5",
    ),
    mounted(
        "azimuth_track",
        (10.0, 20.0, -30.0, 10.0, 25.0, -15.0),
        lambda s: {
            "twist": wave(s, 3, 10, 20),
            "roll": wave(s, 3, -30, 10),
            "pitch": wave(s, 3, 25, -15),
        },
        variant="k = 3",
    ),
    mounted("azimuth_scale", (0.5,), lambda s: {"read_az": lambda a: s * 0.5 * ARCSEC / DEG * a}),
    mounted("elevation_scale", (0.5,), lambda s: {"read_el": lambda e: s * 0.5 * ARCSEC / DEG * e}),
]

#: The campaign in azimuths over two turns, and the turn of each, counted from north.
FURTHER = replace(AT, az=two_turns(AT.az))
TURN = np.floor_divide(np.degrees(FURTHER.az), 360)
MOUNT += [
    mounted(
        "azimuth_turns",
        (-20.0,),
        lambda s: {"read_az": lambda _: -s * 20 * ARCSEC * TURN},
        at=FURTHER,
    ),
    # From south every other row is on the second turn; the first is the one before 180 deg.
    mounted(
        "azimuth_turns",
        (-20.0,),
        lambda s: {"read_az": lambda _: -s * 20 * ARCSEC * (np.arange(len(AT)) % 2 - 1)},
        at=FURTHER,
        variant="turns counted from south",
    ),
]

WIND = AT.columns["wind_speed_m_s"]
ABOVE_MEAN_K = AT.columns["temperature_c"] - AT.columns["temperature_c"].mean()


def warmed(size):
    """Return an azimuth zero of 2" and a sag of -3" for each kelvin above the mean."""
    kelvin = size * ARCSEC * ABOVE_MEAN_K
    return {"read_az": lambda _: 2 * kelvin, "droop": lambda el: -3 * kelvin * np.cos(el)}


def daily_wave(air, time, night):
    """Return the daily wave of the air as a function of time [s], beside a mean of each night.

    Nights say a tenth of the weather's variance against it, all of them together.
    """
    nights = night[:, None] == np.unique(night)
    doubt = np.sqrt(len(air) * 0.1 / nights.shape[1])

    def wave(moment):
        angle = 2 * np.pi * np.asarray(moment) / 86400
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    rows = np.block([[wave(time), nights], [doubt * np.eye(2), np.zeros((2, nights.shape[1]))]])
    found = np.linalg.lstsq(rows, np.append(air, [0, 0]), rcond=None)[0][:2]
    return lambda moment: wave(moment) @ found


def cooled(hours, steel_now, air_of, begin, end, step_s=20.0):
    """Return steel some time later, in air that is a function of the time, by small steps."""
    steps = max(1, int((end - begin) / step_s))
    step = (end - begin) / steps
    for middle in begin + (np.arange(steps) + 0.5) * step:
        steel_now += (air_of(middle) - steel_now) / (hours * 3600 + step / 2) * step
    return steel_now


def steel(hours):
    """Return the temperature of steel that gives its heat to the air, from one row to the next.

    A night begins as after days of the daily wave.
    """
    air, time = AT.columns["temperature_c"], AT.columns["time"]
    apart = np.diff(time, prepend=-np.inf)
    wave = daily_wave(air, time, np.cumsum(apart > 6 * 3600))
    found = []
    for n, gap in enumerate(apart):
        if gap > 6 * 3600:
            before = time[n] - 3 * 86400
            found.append(
                air[n] - wave(time[n]) + cooled(hours, wave(before), wave, before, time[n])
            )
        else:
            rows = [n - 1, n]
            found.append(
                cooled(
                    hours,
                    found[-1],
                    lambda moment, rows=rows: np.interp(moment, time[rows], air[rows]),
                    *time[rows],
                )
            )
    return np.array(found)


THICK = steel(4)
COMES_LATE = THICK - AT.columns["temperature_c"].mean()
WEATHER = [
    mounted(
        "temperature",
        (2.0, -3.0),
        lambda s: {
            "beam_left": s * 2 * ARCSEC * COMES_LATE,
            "droop": lambda _: -s * 3 * ARCSEC * COMES_LATE,
        },
        variant="the same everywhere, 4 h late",
    ),
    mounted(
        "temperature",
        (2.0, -3.0),
        lambda s: {
            "read_az": lambda _: 2 * s * ARCSEC * (AT.columns["temperature_c"] - THICK),
            "droop": lambda el: (
                -3 * s * ARCSEC * (AT.columns["temperature_c"] - THICK) * np.cos(el)
            ),
        },
        variant="as cos E, thin parts against thick ones 4 h late",
    ),
    mounted(
        "thermal_tilt",
        (25.0,),
        lambda s: leaning(s * 25 * ARCSEC, AT.columns["sun_az"] + np.pi),
    ),
    mounted(
        "thermal_tilt",
        (25.0,),
        lambda s: leaning(
            s * 25 * ARCSEC * (AT.columns["sun_el"] > 0), AT.columns["sun_az"] - np.pi
        ),
        variant="while the Sun is up",
    ),
    mounted(
        "wind_tilt",
        (12.0,),
        lambda s: leaning(s * 12 * ARCSEC * (WIND / 10) ** 2, AT.columns["wind_az"] + np.pi),
    ),
    mounted("temperature", (2.0, -3.0), warmed, variant="as cos E"),
    mounted(
        "temperature",
        (2.0, -3.0),
        lambda s: {
            "beam_left": s * 2 * ARCSEC * ABOVE_MEAN_K,
            "droop": lambda _: -s * 3 * ARCSEC * ABOVE_MEAN_K,
        },
    ),
]


def per_value(column, amounts):
    """Return for each row the amount [rad] that its label has; none where it is not listed."""
    labels = AT.columns[column]
    return sum(np.where(labels == name, amount, 0.0) for name, amount in amounts.items()) * ARCSEC


def rare(column):
    """Return the label that stands in the fewest rows."""
    values, count = np.unique(AT.columns[column], return_counts=True)
    return values[np.argmin(count)]


SESSIONS = sorted(set(AT.columns["session"]))[1:]
NORTH, EAST = np.random.default_rng(3).normal(0, 20, (2, len(SESSIONS)))
NORTHWARD, EASTWARD = (
    per_value("session", dict(zip(SESSIONS, amount, strict=True))) for amount in (NORTH, EAST)
)
PAIRS = tuple(np.stack([NORTH, EAST], axis=1).ravel())

#: The moment of one of the steps that are tried, and the edge of one of the jumps.
STEP = CATALOGUE["epoch_offset"].variants(AT)[7]
SINCE = AT.columns["time"] > STEP.parameter
EDGES = CATALOGUE["subreflector_jump"].variants(AT)
LOW = EDGES[2]
EASTERN = [one for one in EDGES if one.variant.startswith("beyond azimuth")][-2]
#: A circle that stands ten degrees higher in the west than on average.
LEANING = EDGES[-1]


def stepped(where):
    """Return amplitude -> a beam that is off by 15" across and -25" along in some rows."""
    return lambda s: {
        "beam_left": s * 15 * ARCSEC * where,
        "droop": lambda _: -s * 25 * ARCSEC * where,
    }


def drifted(size):
    """Return a zero that runs away as a parabola between the first and the last recording."""
    time = AT.columns["time"]
    phase = (time - time[0]) / (time[-1] - time[0])
    return {
        "beam_left": size * 30 * ARCSEC * phase**2,
        "read_el": lambda _: -size * 12 * ARCSEC * phase,
    }


def swung(size):
    """Return zeros that a hand turning once in three hours moves, from where it stood in 1970."""
    turned_by = np.exp(2j * np.pi * (AT.columns["time"] % 10800.0) / 10800.0)
    return {
        "beam_left": size * ARCSEC * ((12 - 5j) * turned_by).imag,
        "read_el": lambda _: size * ARCSEC * ((-7 + 20j) * turned_by).imag,
    }


LABELLED = [
    mounted("receiver_offset", (15.0, -25.0), stepped(AT.columns["receiver"] == rare("receiver"))),
    mounted(
        "beam_squint",
        (15.0, -25.0),
        stepped(np.where(AT.columns["polarisation"] == "left", 1.0, -1.0)),
    ),
    mounted("epoch_offset", (15.0, -25.0), stepped(SINCE), variant=STEP.variant),
    mounted(
        "epoch_offset",
        PAIRS,
        lambda s: {"beam_left": s * NORTHWARD, "droop": lambda _: s * EASTWARD},
    ),
    mounted(
        "epoch_azimuth_zero",
        (40.0,),
        lambda s: {"read_az": lambda _: s * 40 * ARCSEC * SINCE},
        variant=STEP.variant,
    ),
    mounted("epoch_tilt", PAIRS, lambda s: {"lean": (s * NORTHWARD, s * EASTWARD)}),
    mounted("epoch_sag", tuple(NORTH), lambda s: {"droop": lambda el: s * NORTHWARD * np.cos(el)}),
    # A parabola in a phase from 0 to 1 is 1/3, 1/2, 1/6 of Legendre's, whose constant is a zero.
    mounted("drift", (15.0, 5.0, -6.0, 0.0), drifted, variant="order 2"),
    mounted("oscillation", (12.0, -5.0, -7.0, 20.0), swung, variant="period 180 min"),
    mounted(
        "subreflector_jump",
        (-25.0,),
        lambda s: {"droop": lambda _: -s * 25 * ARCSEC * (AT.el > LOW.parameter)},
        variant=LOW.variant,
    ),
    mounted(
        "subreflector_jump",
        (-25.0,),
        lambda s: {"droop": lambda _: -s * 25 * ARCSEC * (AT.az > EASTERN.parameter)},
        variant=EASTERN.variant,
    ),
    mounted(
        "subreflector_jump",
        (-25.0,),
        lambda s: {
            "droop": lambda _: (
                -s * 25 * ARCSEC * (AT.el > LEANING.parameter - 10 * DEG * np.sin(AT.az))
            )
        },
        variant=LEANING.variant,
    ),
]


def scanned(ahead_az, ahead_el):
    """Return amplitude -> offsets of encoders that are ahead of the dish in scans along an axis."""
    along_az = AT.columns["scan_axis"] == "az"

    def offsets(size):
        ahead = size * AT.columns["scan_direction"]
        return ahead * ahead_az * along_az, ahead * ahead_el * ~along_az

    return offsets


RATE = AT.columns["scan_rate"]
SCANS = [
    Case("scan_direction", (20.0, 30.0), scanned(20 * ARCSEC, 30 * ARCSEC)),
    # A tag that is late by 0.4 s finds the source where the axes stand 0.4 s after the peak.
    Case("scan_timing", (0.4,), scanned(0.4 * RATE * np.cos(AT.el), 0.4 * RATE)),
    Case("scan_timing", (0.4,), scanned(0.4 * RATE, 0.4 * RATE), variant="rate on the sky"),
]


def on_circle(angle):
    """Return amplitude -> a beam that is 15" left and 20" low of the axis before it is turned."""

    def flaws(size):
        # What the encoders must make up for is opposite to where the beam went.
        right, up = turned(angle, -size * 15 * ARCSEC, -size * 20 * ARCSEC)
        return {"beam_left": -right, "droop": lambda _: -up}

    return flaws


ROTATOR = np.radians(AT.columns["rotator_deg"])
TURNING = [
    # A ray traced by way of the tertiary mirror: the receiver leans by 15" forward and 20" up.
    mounted("nasmyth", (15.0, -20.0), lambda s: {"beam": platform(1, s)}),
    mounted(
        "nasmyth",
        (-15.0, -20.0),
        lambda s: {"beam": platform(-1, s)},
        variant="platform on the left",
    ),
    *(
        mounted("rotator_circle", (15.0, 20.0), on_circle(times * ROTATOR), variant=f"phi = {name}")
        for times, name in (
            (1, "rotator_deg"),
            (-1, "-rotator_deg"),
            (2, "2 rotator_deg"),
            (-2, "-2 rotator_deg"),
        )
    ),
]


def platform(side, size):
    """Return the beam of that receiver, at an amplitude."""
    return from_platform(side, size * 15 * ARCSEC, size * 20 * ARCSEC)


def above_middle(column):
    """Return how much a condition is above its median."""
    return AT.columns[column] - np.median(AT.columns[column])


COLD, CALM = above_middle("temperature_c"), above_middle("wind_speed_m_s")
HOUR_OF_DAY = 2 * np.pi * (AT.columns["time"] % 86400) / 86400
LATE = THICK - np.median(AT.columns["temperature_c"])
DRIVEN = [
    mounted(
        "driven_term",
        (1.5, -2.0),
        lambda s: {"lean": (s * 1.5 * ARCSEC * LATE, -s * 2.0 * ARCSEC * LATE)},
        variant="tilt follows temperature_c, 4 h late",
    ),
    mounted(
        "driven_term",
        (1.5, -2.0),
        lambda s: {"lean": (s * 1.5 * ARCSEC * COLD, -s * 2.0 * ARCSEC * COLD)},
        variant="tilt follows temperature_c",
    ),
    mounted(
        "driven_term",
        (3.0,),
        lambda s: {"droop": lambda el: s * 3 * ARCSEC * CALM * np.cos(el)},
        variant="sag_cosine follows wind_speed_m_s",
    ),
    mounted(
        "driven_term",
        (3.0, -2.0),
        lambda s: {"beam_left": s * ARCSEC * (3 * np.cos(HOUR_OF_DAY) - 2 * np.sin(HOUR_OF_DAY))},
        variant="collimation follows the time of day",
    ),
    mounted(
        "driven_term",
        (0.5,),
        lambda s: {"read_el": lambda _: s * 0.5 * ARCSEC * np.degrees(above_middle("sun_el"))},
        variant="elevation_zero follows sun_el_deg",
    ),
]

CASES = [*MOUNT, *WEATHER, *LABELLED, *SCANS, *TURNING, *DRIVEN]
