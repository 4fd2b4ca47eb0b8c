"""The table of effects that look alike is held to the curves that they draw."""

from dataclasses import replace

import numpy as np
import pytest
from effects.sky import SITE, START_S, campaign, replaced, two_turns, without

from pyport.angles import DEG
from pyport.effects import CATALOGUE
from pyport.effects.degeneracies import ALIKE, DECIDE_BY, WHERE, alike, decisions

#: Cosine from which two curves are one, and from which they are nearly.
SAME, NEARLY = 1 - 1e-6, 0.9


def between(low, high):
    """Return a campaign between two elevations [deg]."""
    at = campaign(800)
    return at.take((at.el > low * DEG) & (at.el < high * DEG))


def by_session(*values):
    """Return a campaign and values that each session has one of."""
    at = campaign(500)
    number = np.unique(at.columns["session"], return_inverse=True)[1]
    return at, np.array(values)[number % len(values)]


def swapped():
    """Return a campaign in which every session has a receiver of its own."""
    at, _ = by_session(0)
    return replaced(at, receiver=at.columns["session"])


def hourly():
    """Return a campaign in which every session has the Sun in one place."""
    at, azimuth = by_session(*np.linspace(1, 4, 12))
    return replaced(at, sun_az=azimuth, sun_el=np.full(len(at), 0.5))


def seasonal():
    """Return a campaign in which every session has its temperature."""
    at, warmth = by_session(*np.linspace(-10, 20, 12) ** 2)
    return replaced(at, temperature_c=warmth)


def two_epochs():
    """Return two campaigns of a month that are ten years apart."""
    at = campaign(400)
    time = START_S + np.linspace(0, 30 * 86400, 400) + np.where(np.arange(400) < 200, 0, 3.2e8)
    return replaced(at, time=time)


def campaigns():
    """Return recordings under each of the circumstances of the table."""
    wide, at = between(10, 84), campaign(500)
    rows = len(at)
    labels = np.where(at.columns["receiver"] == "C", "1", "2")
    one_season = without(without(campaign(400, nights=1), "sun_az_deg"), "sun_el_deg")
    one_hour = {"sun_az": np.full(rows, 2.0), "sun_el": np.full(rows, 0.5)}
    return {
        "always": at,
        "wide": wide,
        "narrow": between(30, 60),
        # In October 2001 nutation in obliquity passed through zero.
        "one night": campaign(400, start_s=START_S - 685 * 86400, nights=1),
        "one year": at,
        "azimuth only": at,
        "elevation only": at,
        "south": at.take(at.columns["dec"] < SITE.latitude - 1 * DEG),
        "steady air": replaced(
            at, humidity_pct=np.full(rows, 60.0), temperature_c=np.full(rows, 9.0)
        ),
        "one frequency": replaced(at, frequency_mhz=np.full(rows, 1420.0)),
        "one rate": replaced(at, scan_rate=np.full(rows, 1e-5)),
        "near targets": replaced(at, source=np.full(rows, "Moon")),
        "seasons": seasonal(),
        "slow season": replaced(at, temperature_c=(at.columns["time"] - START_S) / 1e6),
        "box swaps": swapped(),
        "channels": replaced(at, channel=labels, polarisation=np.full(rows, "left")),
        "one hour": replaced(at, **one_hour),
        "own hours": hourly(),
        "wind": replaced(at, wind_az=at.columns["sun_az"], wind_speed_m_s=np.full(rows, 7.0)),
        "two epochs": two_epochs(),
        "one season": one_season,
        "prevailing wind": replaced(at, wind_az=np.full(rows, 4.0)),
        "two turns": replace(at, az=two_turns(at.az)),
        "rotator with elevation": replaced(at, rotator_deg=at.el / DEG),
    }


CAMPAIGNS = campaigns()
MEASURED = {"azimuth only": "x", "elevation only": "y"}


def curves(effect, at, axes):
    """Return the columns of an effect in the axes that were measured."""
    x, y = effect.columns(at)
    return np.concatenate([one for one, axis in ((x, "x"), (y, "y")) if axis in axes])


def directions(columns, base):
    """Return orthonormal directions of columns after a base took its share."""
    length = np.linalg.norm(columns, axis=0)
    left = columns - base @ (base.T @ columns)
    left = left[:, np.linalg.norm(left, axis=0) > 1e-7 * length]
    vectors, sizes, _ = np.linalg.svd(left / np.linalg.norm(left, axis=0), full_matrices=False)
    return vectors[:, sizes > 1e-7]


def cosine(pair):
    """Return how far the closest members of two families draw the same curves; one is the same."""
    at, axes = CAMPAIGNS[pair.where], MEASURED.get(pair.where, "xy")
    base = np.zeros((len(at) * len(axes), 0))
    for beside in pair.beside:
        one = directions(curves(CATALOGUE[beside], at, axes), base)
        base = np.concatenate([base, one], axis=1)
    families = [
        [directions(curves(member, at, axes), base) for member in CATALOGUE[one].variants(at)]
        for one in pair.ids
    ]
    return max(
        np.linalg.svd(one.T @ other, compute_uv=False).min()
        for one in families[0]
        for other in families[1]
        if one.shape[1] and other.shape[1]
    )


@pytest.mark.parametrize("pair", ALIKE, ids=lambda pair: " = ".join(pair.ids))
def test_pair_is_as_alike_as_the_table_says(pair):
    """Exact pairs span the same curves; the others nearly, and no more than nearly."""
    found = cosine(pair)

    assert found > (SAME if pair.exact else NEARLY)


def test_every_entry_knows_its_circumstances():
    """Every circumstance has words and recordings, and is used."""
    assert {pair.where for pair in ALIKE} == set(WHERE) == set(CAMPAIGNS)


def test_decisions_are_found_by_pair():
    """No pair stands twice in the table, and each has an observation that decides."""
    assert len(DECIDE_BY) == len(ALIKE)
    assert all(DECIDE_BY.values())


def test_a_class_is_told_each_observation_once():
    """A class of several effects gets what decides between any two of them, nothing twice."""
    assert decisions(["tilt"]) == []
    assert decisions(["clock", "skew", "tilt"]) == [DECIDE_BY[frozenset({"clock", "tilt"})]]
    assert len(decisions(["annual_aberration", "nutation", "precession", "source_position"])) == 1


def test_ids_are_effects():
    """The table speaks of effects of the catalogue only."""
    assert {one for pair in ALIKE for one in (*pair.ids, *pair.beside)} <= set(CATALOGUE)


def test_alike_lists_the_other_one():
    """What an effect may be taken for is found from either side."""
    assert ("tilt", ALIKE[0]) in alike("site_latitude")
    assert ("site_latitude", ALIKE[0]) in alike("tilt")
