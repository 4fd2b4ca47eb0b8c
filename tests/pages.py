"""Recordings and pages for the tests of the page."""

from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC
from pyport.effects import Circumstances, Site
from pyport.recordings.schema import Recordings, SetAside

HOSTILE = "<script>document.title='hacked'</script>"


def recordings(n=240, seed=1, antenna="W06", **columns):
    """Return n pointings in two sessions with refraction that nobody corrected, 58 arcsec cot E."""
    rng = np.random.default_rng(seed)
    az, el = rng.uniform(0, 2 * np.pi, n), np.arcsin(rng.uniform(0.15, 0.98, n))
    session = np.arange(n) * 2 // n
    known = {
        "time": 1.2e9 + session * 86400 * 9 + 120.0 * np.arange(n),
        "session": np.char.add("s", session.astype(str)),
        "antenna": np.full(n, antenna),
        "source": np.char.add("source ", (np.arange(n) % 7).astype(str)),
        "temperature_c": rng.normal(8, 5, n),
        **columns,
    }
    x, y = rng.normal(0, 5, (2, n)) * ARCSEC
    nothing = np.full(n, np.nan)
    return Recordings(
        Circumstances(az, el, Site(0.9), known),
        x,
        y + 58 * ARCSEC / np.tan(el),
        nothing,
        nothing,
        np.arange(n) + 2,
        Path("made.csv"),
        {"telescope": "made"},
        (SetAside(n + 2, "no offset on either axis"),),
    )
