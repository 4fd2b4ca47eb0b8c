"""Residuals over the sky are drawn as they stand there, whatever axes they were measured along."""

import numpy as np

import pyport
from pyport.angles import ARCSEC, DEG
from pyport.mounts import KINDS
from pyport.page import of_fit
from pyport.page.payload import payload


def picture():
    """Return the picture of a fit to offsets that refraction alone makes on an equatorial mount."""
    rng = np.random.default_rng(3)
    az, el = rng.uniform(0, 360, 80), rng.uniform(20, 80, 80)
    lift = 60 / np.tan(el * DEG)
    table = {"az_deg": az, "el_deg": el, "d_xel_arcsec": 0 * az, "d_el_arcsec": lift}
    header = {"latitude_deg": "50", "mount": "equatorial"}
    return of_fit(pyport.fit(table, "none", header=header).result)[0], lift * ARCSEC


def test_vectors_point_along_the_sky():
    """Refraction points up on the sky, though both axes of the mount show it."""
    drawn, lift = picture()
    across, along = drawn.on_sky("after")

    assert drawn.axes == KINDS["equatorial"].names
    assert np.abs(drawn.x.after).max() > 10 * ARCSEC
    assert np.abs(across).max() < 1e-12
    assert np.abs(along - lift).max() < 1e-12


def test_the_page_gets_the_same_turn():
    """What the page's script is given has the turn; on an alt-azimuth mount there is none."""
    drawn, _ = picture()
    table = {"az_deg": [1.0, 90, 200], "el_deg": [30.0, 40, 50], "d_el_arcsec": [1.0, 2, 4]}
    flat, _ = of_fit(pyport.fit(table, "none").result)

    assert len(payload(drawn)["turn"]) == 4
    assert payload(flat)["turn"] is None
