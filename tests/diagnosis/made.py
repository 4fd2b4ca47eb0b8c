"""Recordings made for the tests of the diagnosis, by rotation-free formulae of the textbook."""

from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC
from pyport.effects import Circumstances, Site
from pyport.recordings.schema import Recordings

LATITUDE = 0.9


def recordings(n, seed, noise_arcsec=5.0, x=None, y=None, **columns):
    """Return n pointings over the sky in four sessions; `x`, `y` add offsets [arcsec]."""
    rng = np.random.default_rng(seed)
    az, el = rng.uniform(0, 2 * np.pi, n), np.arcsin(rng.uniform(0.2, 0.98, n))
    session = np.sort(rng.integers(0, 4, n))
    time = 1.2e9 + session * 86400 * 9 + 1e-3 * np.arange(n) * 86400 / n * 400
    known = {
        "time": time,
        "session": np.char.add("s", session.astype(str)),
        "temperature_c": rng.normal(8, 5, n),
        "humidity_pct": rng.uniform(30, 90, n),
        "weight_of_the_cat_kg": rng.uniform(3, 6, n),
    }
    known |= columns
    at = Circumstances(az, el, Site(LATITUDE), known)
    offsets = [noise_arcsec * rng.normal(size=n) for _ in range(2)]
    for axis, add in enumerate((x, y)):
        if add is not None:
            offsets[axis] = offsets[axis] + add(at)
    # What the base model absorbs is there as well: a diagnosis must look past it.
    offsets[0] = offsets[0] + 40 * np.cos(el) - 25 + 30 * np.sin(el)
    offsets[1] = offsets[1] + 60 * np.cos(el) - 15 + 9 * np.cos(az)
    offsets[0] = offsets[0] + 9 * np.sin(el) * np.sin(az)
    nothing = np.full(n, np.nan)
    return Recordings(
        at,
        offsets[0] * ARCSEC,
        offsets[1] * ARCSEC,
        nothing,
        nothing,
        np.arange(n) + 2,
        Path("made.csv"),
    )
