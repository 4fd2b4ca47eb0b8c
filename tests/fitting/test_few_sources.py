"""Places of few sources that err go into the terms of a fit; that is said."""

import erfa
import numpy as np
import pytest

import pyport

LATITUDE_DEG = 53.0
DECS_DEG = (10, 35, 60, -5, 25, 75, 50)


def night(sources, rows=24, names=None, seed=1, places_arcsec=20.0, moving_deg=0.0):
    """Return a table of sources that were tracked, whose places err, by noise of 2 arcsec.

    Four fifths of the rows of each are within `moving_deg` of declination.
    """
    rng = np.random.default_rng(seed)
    which = np.repeat(np.arange(sources), rows)
    hour_angle = np.tile(np.linspace(-1.2, 1.2, rows), sources)
    moved = np.tile(np.linspace(-0.5, 0.5, rows) * moving_deg / 0.8, sources)
    dec = np.radians(np.array(DECS_DEG)[which] + moved)
    az, el = erfa.hd2ae(hour_angle, dec, np.radians(LATITUDE_DEG))
    off = rng.normal(0, places_arcsec, (2, sources))[:, which] + rng.normal(0, 2, (2, len(az)))
    labels = [f"S{n}" for n in range(sources)] if names is None else names
    return {
        "az_deg": np.degrees(az),
        "el_deg": np.degrees(el),
        "d_xel_arcsec": off[0],
        "d_el_arcsec": off[1],
        "source": np.array(labels)[which],
    }


def said(table, model="altaz", header=None):
    """Return what a fit says of few sources."""
    told = pyport.fit(table, model, header=header).report["warnings"]
    return [one for one in told if "sources for" in one]


HEADER = {"latitude_deg": LATITUDE_DEG}


@pytest.mark.parametrize("header", [None, HEADER])
@pytest.mark.parametrize(("sources", "warned"), [(2, True), (3, True), (4, False), (7, False)])
def test_as_long_as_two_numbers_a_place_are_no_more_than_the_terms(sources, warned, header):
    """Seven terms, with a latitude or without."""
    told = said(night(sources), header=header)

    assert bool(told) == warned
    assert all(one.startswith(f"only {sources} sources for 7 coefficients: what") for one in told)


def test_the_errors_are_then_too_small():
    """Of three sources the terms are off by several of their sigmas."""
    off = []
    for seed in range(12):
        done = pyport.fit(night(3, seed=seed), header=HEADER)
        values = [one for one in done.coefficients.values() if one.sigma]
        off += [abs(float(one.value / one.sigma)) for one in values]

    assert np.sqrt(np.mean(np.square(off))) > 3


def test_nothing_where_no_sources_are_named():
    """None, one name for all rows, names in some rows alone."""
    table = night(3)
    assert said({key: one for key, one in table.items() if key != "source"}) == []
    assert said(night(3, names=["", "", ""])) == []
    assert said(night(3, names=["RT32", "RT32", "RT32"])) == []
    assert said(night(5, names=["S1", "S2", "", "", ""])) == []
    assert said(night(3), "none") == []


def test_names_of_something_else_than_sources():
    """They stand at all declinations, which is known where the latitude is."""
    table = night(7)
    table["source"] = np.array(["optical", "radio"])[np.arange(len(table["source"])) % 2]

    assert said(table, header=HEADER) == []


@pytest.mark.parametrize(("moving_deg", "warned"), [(8.0, True), (12.0, False)])
def test_a_source_stays_within_ten_degrees_of_declination(moving_deg, warned):
    """What moves further under one name is no place that a catalogue has."""
    assert bool(said(night(3, moving_deg=moving_deg), header=HEADER)) == warned


def test_of_an_array_each_antenna_has_its_own_terms():
    """Thirty of two terms each are no sixty terms for three places."""
    table = night(3)
    several = {key: np.concatenate([one] * 5) for key, one in table.items()}
    several["antenna"] = np.repeat([f"A{n}" for n in range(5)], len(table["source"]))

    assert said(several) == [one.replace("21", "7") for one in said(table)]
