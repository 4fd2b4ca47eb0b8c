"""A source's catalogue is blamed only for what comes back with the source in another night."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import pyport
from pyport.diagnosis.naming import guards
from pyport.diagnosis.naming.guards import comes_back
from pyport.diagnosis.naming.nights import night_numbers
from pyport.effects import CATALOGUE
from pyport.effects.base import Circumstances
from pyport.effects.circumstances import NIGHT_GAP_S
from pyport.recordings.sky import horizon

DAY_S = 86400.0


def scene(size_of_night, seed=0, per_night=12, sigma=1.0, session=None):
    """Return what guards look at: one source, with an offset of its own in each night [sigma]."""
    rng = np.random.default_rng(seed)
    nights = len(size_of_night)
    night = np.repeat(np.arange(nights), per_night)
    source = np.tile(np.array(["3C 84", "W3OH"]), len(night) // 2)
    mine = source == "3C 84"
    curve = np.where(mine, 5.0, 0.0)
    residual = curve * np.asarray(size_of_night)[night] + sigma * rng.normal(size=len(night))
    time = DAY_S * night + 600.0 * np.tile(np.arange(per_night), nights)
    at = Circumstances(np.zeros(len(night)), np.zeros(len(night)), None, {"time": time})
    problem = SimpleNamespace(
        residual=residual,
        session=np.zeros(len(night), int) if session is None else session,
        stack=SimpleNamespace(row=np.arange(len(night)), is_y=np.zeros(len(night), bool)),
        recordings=SimpleNamespace(at=at, label=lambda _: source),
        pointing=np.arange(len(night)),
    )
    return (
        SimpleNamespace(
            problem=problem,
            weighed=SimpleNamespace(used=np.ones(len(night), bool)),
            joint=SimpleNamespace(predicted=curve, solution=SimpleNamespace(rank=3)),
            neglected=0.0,
            floor=np.full(len(night), sigma),
        ),
        mine,
        curve,
    )


@pytest.mark.parametrize(
    ("sizes", "back"),
    [
        ((1.0,), False),
        ((1.0, 1.0), True),
        ((1.0, 1.1, 0.9), True),
        # One night alone shows it; the other one shows nothing, or the opposite.
        ((2.0, 0.0), False),
        ((2.0, -1.0), False),
        # Nights that each show another size are no error of one position.
        ((4.0, 0.5), False),
    ],
)
def test_the_same_offset_must_come_back(sizes, back):
    """In two nights at least, and of about the same size."""
    for seed in range(20):
        one, mine, curve = scene(sizes, seed)

        assert comes_back(one, mine, curve) == back


@pytest.mark.parametrize(("nights", "refused"), [(1, True), (2, False)])
def test_one_night_blames_no_catalogue(nights, refused):
    """The reason is said in so many words, and what to observe."""
    one, _, curve = scene((1.0,) * nights, per_night=40)
    why = guards.refusal(one, replace(CATALOGUE["source_position"], variant="3C 84"), curve)

    assert (why is not None) == refused
    if why is not None:
        assert "offset of one source on one night" in why.reason
        assert "second night" in why.decide_by


def test_what_is_the_telescopes_needs_no_label():
    """Only effects that belong to a label are asked to come back with it."""
    one, _, curve = scene((1.0,), per_night=40)

    assert guards.refusal(one, CATALOGUE["refraction"], curve) is None


@pytest.mark.parametrize(
    ("since", "said"),
    [
        (600.0 * 20, "shows when something moved and by how much, but not what it was"),
        (0.0, "cannot be tested in a single one"),
        (None, "cannot be tested in a single one"),
    ],
)
def test_a_step_within_the_only_night_is_seen_but_has_no_name(since, said):
    """It has recordings before and after it: what is not known is what it was."""
    one, _, curve = scene((1.0,), per_night=40)
    why = guards.refusal(one, CATALOGUE["epoch_offset"], curve, since)

    assert said in why.reason
    assert why.decide_by == "observe in a second session"


def test_a_long_session_has_its_nights():
    """Gaps part nights within a session, sessions part them where no time is known."""
    one, *_ = scene((1.0, 1.0, 1.0))
    assert len(np.unique(night_numbers(one))) == 3
    assert NIGHT_GAP_S < DAY_S

    sessions = np.repeat([0, 1], 12)
    two, *_ = scene((1.0, 1.0), session=sessions)
    at = two.problem.recordings.at
    two.problem.recordings.at = replace(at, columns={})
    assert np.array_equal(night_numbers(two), sessions)


def tracked(off_arcsec, seed=4):
    """Return a table of eight sources followed for three nights, each off in declination."""
    rng = np.random.default_rng(seed)
    latitude, night = np.radians(46.5), np.repeat(np.arange(3), 90)
    hours = np.tile(np.arange(90) / 9, 3)
    ra = np.radians(np.arange(8) * 45.0)
    dec = np.radians(np.array([72.0, -5.7, 5.1, 61.7, 33.0, 18.5, 47.2, 10.9]))
    hour_angle = np.radians(15.0 * hours[:, None]) - ra
    up = horizon(hour_angle, np.tile(dec, (270, 1)), latitude)[1] > np.radians(15.0)
    which = np.array([rng.choice(np.flatnonzero(one)) for one in up[::3]]).repeat(3)
    hour_angle, dec = hour_angle[np.arange(270), which], dec[which]
    az, el = horizon(hour_angle, dec, latitude)
    q = np.arctan2(
        np.sin(hour_angle) * np.cos(latitude),
        np.sin(latitude) * np.cos(dec) - np.cos(latitude) * np.sin(dec) * np.cos(hour_angle),
    )
    off = np.asarray(off_arcsec)[which]
    time = 86400 * night + 3600 * hours
    return {
        "time_utc": np.datetime64("2025-01-24T20:00:00") + time.astype("timedelta64[s]"),
        "session": np.char.add("night ", night.astype(str)),
        "source": np.char.add("J", which.astype(str)),
        "az_deg": np.degrees(az) % 360,
        "el_deg": np.degrees(el),
        "d_xel_arcsec": off * np.sin(q) + 1.6 * rng.normal(size=270),
        "d_el_arcsec": off * np.cos(q) + 1.6 * rng.normal(size=270),
    }


@pytest.mark.parametrize(
    ("off", "named"),
    [
        # One of eight is wrong by far: its catalogue is, and the others' are not.
        ([0.0, 0.0, 12.0, 0.0, 0.0, 0.0, 0.0, 0.0], ["J2"]),
        ([0.0, -9.0, 12.0, 0.0, 0.0, 0.0, 0.0, 0.0], ["J2", "J1"]),
        # All are off by about as much: that is what their places scatter by.
        ([3.0, -2.0, 4.0, -3.5, 2.5, -4.0, 3.5, -2.5], []),
    ],
)
def test_one_source_is_blamed_that_stands_out_of_the_others(off, named):
    """However far it is off: it must not pass for the scatter of sources that are right."""
    report = pyport.diagnose(tracked(off), "altaz", header={"latitude_deg": "46.5"}).report
    found = report["findings"]

    assert [one["variant"] for one in found] == named
    for one in found:
        assert one["effect"] == "source_position"
        sizes = {each["name"]: each["value"] for each in one["parameters"]}
        wrong = abs(off[int(one["variant"][1:])])
        assert abs(sizes[f"dec[{one['variant']}]"]) == pytest.approx(wrong, abs=1.5)
