"""An array made for the tests: antennas displaced on the Earth, seen through ERFA's rotations."""

from pathlib import Path

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, wrap
from pyport.diagnosis.joint import Joint
from pyport.diagnosis.preparing import prepare
from pyport.effects import Circumstances, Site
from pyport.formats.models import load
from pyport.recordings import sky
from pyport.recordings.schema import Recordings

LATITUDE = 34 * DEG
#: Metres on a parallel for a radian of longitude, to a part in a thousand.
EARTH_M = 6.385e6
RATE = 20 * ARCMIN / 60


def names(count):
    """Return antenna names."""
    return [f"A{n:02d}" for n in range(count)]


def array(
    east_m,
    *,
    sessions=3,
    scans=24,
    lean=0.0,
    play=1.0,
    tags=(5.0, 1.0, -4.0),
    noise=0.4,
    seed=0,
    both_axes=False,
    decs_deg=(40.0,),
):
    """Return recordings of antennas that stand `east_m` further east than they were computed for.

    Mounts lean by `lean` and have play of `play` arcmin (rms), scans a time tag [s] per session.
    """
    rng = np.random.default_rng(seed)
    count = len(east_m)
    own_lean = lean * rng.normal(size=(count, 2))
    own_play = play * rng.normal(size=count)
    own_sag = 4 * rng.normal(size=count)
    parts = []
    for session in range(sessions):
        hours = np.sort(rng.uniform(-4, 3, scans))
        dec = np.resize(decs_deg, scans) * DEG
        way = np.where(np.arange(scans) % 2 == 0, 1.0, -1.0)
        for n in range(count):
            az, el = sky.horizon(hours * HOUR, dec, LATITUDE)
            on = east_m[n] / EARTH_M / np.cos(LATITUDE)
            az_there, el_there = sky.horizon(hours * HOUR + on, dec, LATITUDE)
            x, y = wrap(az_there - az) * np.cos(el), el_there - el
            north, east = own_lean[n] * ARCMIN
            x = x + (north * np.sin(az) - east * np.cos(az)) * np.sin(el)
            y = y + north * np.cos(az) + east * np.sin(az)
            y = y + own_sag[n] * ARCMIN * np.cos(el)
            y = y + way * (own_play[n] * ARCMIN + tags[session] * RATE)
            x = x + rng.normal(0, 10) * ARCMIN * np.cos(el)
            y = y + rng.normal(0, 10) * ARCMIN
            x, y = (one + noise * ARCMIN * rng.normal(size=scans) for one in (x, y))
            time = 1.2e9 + 86400 * session + hours * 3600
            parts.append((n, session, az, el, x, y, way, time, hours * HOUR))
    repeated = [np.repeat([p[k] for p in parts], scans) for k in (0, 1)]
    az, el, x, y, way, time, hour_angle = (
        np.concatenate([p[k] for p in parts]) for k in range(2, 9)
    )
    columns = {
        "antenna": np.array(names(count))[repeated[0]],
        "session": np.char.add("day ", (repeated[1] + 1).astype(str)),
        "scan_direction": way,
        "scan_axis": np.full(len(az), "el"),
        "scan_rate": np.full(len(az), RATE),
        "time": time,
        "hour_angle": hour_angle,
    }
    nothing = np.full(len(az), np.nan)
    recordings = Recordings(
        Circumstances(az, el, Site(LATITUDE), columns),
        x if both_axes else nothing,
        y,
        nothing,
        nothing,
        np.arange(len(az)) + 2,
        Path("made.csv"),
    )
    return recordings, own_play, own_lean


def case(recordings, model="altaz"):
    """Return the case of recordings and a fit in which nothing was found."""
    problem = prepare(recordings, load(model))
    nothing = np.zeros(0)
    return problem, Joint(problem.base, None, nothing, nothing)
