"""What the README claims of captions, directions and signs, held to the data."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.angles import ARCMIN, HOUR
from pyport.recordings import read
from pyport.studies.gmrt.published import CRAB, CYG_A, SESSIONS, SHIFTED, table_18
from pyport.studies.gmrt.recovery import checks, printed
from pyport.studies.gmrt.recovery.cells import scans

MARCH, MAY, *JUNE = SESSIONS


def halves(sessions):
    """Return the half-differences of each session."""
    return [checks.half_differences(read(f"gmrt-{one.date}"), one) for one in sessions]


@pytest.mark.parametrize("session", [MAY, *JUNE], ids=lambda session: session.date)
def test_declination_decides_the_source(session):
    """The printed elevations are those of the session's source, degrees off the other's."""
    other = MAY if session.source is CYG_A else JUNE[0]
    assert {MAY.source, JUNE[0].source} == {CRAB, CYG_A}

    assert checks.elevation_misfit_deg(session.table, session) < 2
    assert checks.elevation_misfit_deg(session.table, other) > 8


@pytest.mark.parametrize("session", [MAY, *JUNE], ids=lambda session: session.date)
def test_table_18_decides_the_day(session):
    """Of all days' published curves a session's own run nearest to its offsets."""
    misfits = checks.caption_misfits(read(f"gmrt-{session.date}"))

    assert min(misfits, key=misfits.__getitem__) == session.date


@pytest.mark.slow
def test_directions_add_up():
    """Antenna plus day explains forward minus reverse with the directions as derived, no others."""
    misfits = checks.adding_up(halves(JUNE))

    as_derived = misfits.pop((1, 1, 1))
    assert as_derived < 0.4
    assert min(misfits.values()) > 2 * as_derived


@pytest.mark.slow
def test_directions_are_tied_to_the_labels_of_march():
    """With the day whose scans are labelled in print the same choice comes out best."""
    misfits = checks.adding_up(halves([MARCH, *JUNE]))

    assert min(misfits, key=misfits.__getitem__) == (1, 1, 1, 1)


@pytest.mark.parametrize(("session", "gap_h"), [(JUNE[2], -3.6), (MAY, -1.2), (MAY, 0.2)])
def test_directions_hold_across_a_gap(session, gap_h):
    """Each antenna's half-difference is the same before and after a long gap, not its opposite."""
    recordings = read(f"gmrt-{session.date}")
    later = recordings.at.column("hour_angle") > gap_h * HOUR

    before, after = (
        checks.half_differences(recordings.take(part), session) for part in (~later, later)
    )
    known = np.isfinite(before) & np.isfinite(after)

    assert known.sum() >= 10
    same, opposite = (np.median(np.abs(before - sign * after)[known]) for sign in (1, -1))
    assert same < 0.5 * opposite


def test_scans_take_turns():
    """The first scan of a day is forward, each next the other way."""
    for session in JUNE:
        assert [scan.direction for scan in scans(session.table)][:4] == [1, -1, 1, -1]


def test_table_13_says_its_directions():
    """The columns of Table 13 are labelled p and m, in pairs of rising elevation."""
    assert printed.scans_across() == [
        *((1, 23), (-1, 23), (1, 40), (-1, 40), (1, 50), (-1, 52)),
        *((1, 60), (-1, 62), (1, 70), (-1, 73), (1, 80), (-1, 82)),
    ]


def test_minima_move_with_the_arms():
    """The published curves have their minima later for the east arm, earlier for the west arm.

    An antenna further east sees the source further on: higher while it rises.
    So the offsets are where the source was found minus where it was computed.
    """
    minimum_h = {
        arm: np.median(
            [
                (np.pi * (wave.b > 0) - wave.d) / HOUR
                for wave in table_18()
                if wave.antenna in arm and wave.session.startswith("2003-06")
            ]
        )
        for arm in (("E03", "E04", "E05", "E06"), ("W04", "W05", "W06"))
    }

    east, west = minimum_h.values()
    assert east > 1
    assert west < -1


def test_table_18_is_complete():
    """Table 18 gives 133 curves, of 30 antennas on up to five days, with positive sigmas."""
    curves = table_18()

    assert len(curves) == 133
    assert len({(curve.antenna, curve.session) for curve in curves}) == 133
    assert len({curve.antenna for curve in curves}) == 30
    assert min(min(c.sigma_a, c.sigma_b, c.sigma_d) for c in curves) > 0
    first = curves[0]
    assert (first.antenna, first.session) == ("C00", "2003-03-31")
    assert (first.a / ARCMIN, first.sigma_b / ARCMIN) == pytest.approx((11.17, 1.2))
    assert np.degrees(first.d) == pytest.approx(29.5)


@pytest.mark.slow
@pytest.mark.parametrize(("antenna", "begin"), [("C12", 27), ("S02", 18), ("S04", 27)])
def test_shifted_curves_belong_to_their_day(antenna, begin):
    """A curve printed aside of its day runs through that day's offsets (C12's last follows one)."""
    session = SHIFTED[antenna, begin]
    curve = next(c for c in table_18() if (c.antenna, c.session) == (antenna, session))

    apart = {}
    for day in (MAY, *JUNE):
        recordings = read(f"gmrt-{day.date}")
        own = recordings.at.column("antenna") == antenna
        if own.sum() >= 8:
            hour_angle = recordings.at.column("hour_angle")[own]
            apart[day.date] = np.median(np.abs(recordings.y[own] - curve(hour_angle))) / ARCMIN

    assert min(apart, key=apart.__getitem__) == session
