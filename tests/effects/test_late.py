"""Steel that comes after the air, and turns of the cable: when they are tried, from what."""

from dataclasses import replace

import numpy as np
import pytest
from effects.sky import campaign, replaced, two_turns, without

from pyport.effects import CATALOGUE, Circumstances, MissingColumn
from pyport.effects.circumstances import NIGHT_GAP_S
from pyport.effects.telescope.encoders import ON_A_TURN
from pyport.effects.telescope.thermal import BETWEEN, STEEL, STEEL_H, steel_c, ways

HOUR_S = 3600.0


def warmed(hours, air, **columns):
    """Return rows at some hours, with the air's temperature."""
    rows = len(hours)
    known = {"time": 1.6e9 + HOUR_S * np.asarray(hours), "temperature_c": np.asarray(air)}
    return Circumstances(np.zeros(rows), np.full(rows, 0.8), None, known | columns)


def test_steel_goes_to_a_step_of_the_air_as_an_exponential():
    """After a jump of 8 K what is lacking falls to 1 / e in a time constant."""
    hours = np.array([0, 1, 1, 2.5, 4, 7])
    steel = steel_c(warmed(hours, [2.0, 2, 10, 10, 10, 10]), 3)

    lacks = 10 - steel[2:]
    np.testing.assert_allclose(lacks, lacks[0] * np.exp(-(hours[2:] - 1) / 3), rtol=1e-9)


@pytest.mark.parametrize("constant_h", [1, 4])
@pytest.mark.parametrize("from_h", [0, 8])
def test_a_night_starts_as_the_days_before_it_went(constant_h, from_h):
    """Of a daily wave six nights of nine hours tell most of what steel was at their start."""
    day = 2 * np.pi / 24 * np.arange(0, 24 * 9, 0.25)
    hours, air = day * 24 / (2 * np.pi), 10 + 5 * np.cos(day - 3.9)
    always = steel_c(warmed(hours, air), constant_h)
    seen = ((hours - from_h) % 24 < 9) & (hours > 48)
    nights = steel_c(warmed(hours[seen], air[seen]), constant_h)

    first = np.diff(hours[seen], prepend=0) > 1
    left = np.abs(nights - always[seen])[first]
    assert np.all(left < 0.3 * np.abs(air - always)[seen].max())


def test_steel_comes_behind_air_that_warms_evenly_by_its_time_constant():
    """Air that warms by 2 K an hour is 6 K above steel of three hours, as long as that goes on."""
    hours = np.arange(0, 60, 0.5)
    steel = steel_c(warmed(hours, 2 * hours), 3)

    assert abs(2 * hours[-1] - steel[-1] - 6) < 1e-6


def test_a_night_forgets_the_one_before_and_no_break_within_it_does():
    """A gap as long as that between nights forgets; a shorter one does not."""
    for gap, forgets in ((NIGHT_GAP_S / HOUR_S + 0.1, True), (NIGHT_GAP_S / HOUR_S - 0.1, False)):
        steel = steel_c(warmed([0, 1e-3, 1e-3 + gap], [0.0, 10, 10]), 3)

        assert (abs(steel[2] - 10) < 0.1) == forgets


def test_antennas_and_the_order_of_rows_are_kept_apart():
    """Each antenna has its steel; rows may stand in any order, and blank ones say nothing."""
    hours, air = np.arange(8) / 2, np.array([1.0, 4, 2, 8, 5, 7, 1, 3])
    alone = steel_c(warmed(hours, air), 1)
    mixed = np.random.default_rng(0).permutation(16)
    both = warmed(
        np.tile(hours, 2)[mixed],
        np.concatenate([air, -air])[mixed],
        antenna=np.repeat(["A", "B"], 8)[mixed],
    )
    np.testing.assert_allclose(steel_c(both, 1), np.concatenate([alone, -alone])[mixed])

    blank = np.where(np.arange(8) == 3, np.nan, air)
    found = steel_c(warmed(hours, blank), 1)
    assert np.flatnonzero(np.isnan(found)).tolist() == [3]
    known = np.isfinite(blank)
    np.testing.assert_allclose(found[known], steel_c(warmed(hours[known], air[known]), 1))


def test_the_past_is_missing_without_times_and_at_one_moment():
    """No time, or one moment, tells no past: steel is not tried, and refused where it is asked."""
    at = campaign(60)
    late = [one for one in CATALOGUE["temperature"].variants(at) if one.looks_back]

    assert len(late) == 3 * 2 * len(STEEL_H)
    for one in late:
        assert one.missing(without(at, "time_utc")) is None
        with pytest.raises(MissingColumn, match="time_utc"):
            one.columns(without(at, "time_utc"))
        with pytest.raises(MissingColumn, match="temperature_c of the hours before"):
            one.columns(at.take(slice(0, 1)))
    assert len(ways(without(at, "time_utc"))) == 1
    assert len(ways(replaced(at, time=np.zeros(60)))) == 1
    assert (
        len(ways(replaced(at, time=np.where(np.arange(60) == 7, np.nan, at.column("time"))))) == 1
    )


def test_late_steel_needs_a_second_night():
    """In one night what is late is a slow curve; what is between thin and thick is tried."""
    one_night = warmed(np.linspace(0, 9, 60), np.linspace(8, 2, 60))

    assert {way for way, _ in ways(one_night)} == {"air", BETWEEN}
    late = [(way, hours) for way in (BETWEEN, STEEL) for hours in STEEL_H]
    assert ways(campaign(60)) == [("air", 0), *late]
    # So does it a second day, where none of the gaps is as long as that between two nights.
    assert {way for way, _ in ways(warmed(np.linspace(0, 23, 60), np.zeros(60)))} == {
        "air",
        BETWEEN,
    }
    assert ways(warmed(np.linspace(0, 30, 60), np.zeros(60))) == [("air", 0), *late]
    evening = np.concatenate([np.linspace(0, 2, 30), np.linspace(9, 11, 30)])
    assert ways(warmed(evening, np.zeros(60))) == [("air", 0), *late]


def test_members_come_back_from_what_a_file_holds():
    """Way and hours are part of the member; the air alone is written as it ever was."""
    at = campaign(200)
    for effect in ("temperature", "driven_term"):
        for one in CATALOGUE[effect].variants(at):
            again = one.make(**one.member)

            assert (again.variant, again.looks_back) == (one.variant, one.looks_back)
            np.testing.assert_array_equal(again.columns(at), one.columns(at))
            assert bool({"lag_h", "settles_h"} & {*one.member}) == one.looks_back


def turns(az):
    """Return how the turns of some azimuths are counted."""
    at = Circumstances(az, np.full(len(az), 0.8))
    return [one.variant for one in CATALOGUE["azimuth_turns"].variants(at)]


def test_turns_need_directions_that_two_of_them_reach():
    """One turn has none, however it is cut; nor have two that share no direction, or few rows."""
    az = np.random.default_rng(0).uniform(0, 2 * np.pi, 400)
    assert turns(two_turns(az)) == ["turns counted from north", "turns counted from south"]
    third = np.radians(np.tile(np.linspace(181, 299, ON_A_TURN), 2))
    both = third + 2 * np.pi * np.repeat([0, 1], ON_A_TURN)
    assert len(turns(both)) == 2

    apart = np.where(az < np.pi, az, az + 2 * np.pi)
    for one in (az, az - np.pi, apart, both[1:]):
        with pytest.raises(MissingColumn, match="azimuths over more than a turn"):
            turns(one)


def test_a_turn_is_the_difference_of_two_scales():
    """What two opposite scales draw, one as recorded and one about a cut, is one zero per turn."""
    at = campaign(300)
    at = replace(at, az=two_turns(at.az))
    (turn, _), scales = (CATALOGUE[one].variants(at) for one in ("azimuth_turns", "azimuth_scale"))
    recorded, north = scales[0], scales[-1]

    drawn = (recorded.columns(at)[0] - north.columns(at)[0]) / (2 * np.pi)
    np.testing.assert_allclose(drawn, turn.columns(at)[0], atol=1e-12)


def test_air_that_does_not_change_bends_nothing_by_a_difference():
    """Thin parts and thick ones are as warm then, however far from where others are counted."""
    at = warmed([0, 1, 2], [15.0, 15, 15])
    told = {"way": BETWEEN, "lag_h": 3}
    for one in (
        CATALOGUE["temperature"].make("as cos E", reference_c=5.0, **told),
        CATALOGUE["driven_term"].make("tilt", "temperature_c", centre=5.0, **told),
    ):
        assert not np.any(one.columns(at))


def weather():
    """Return hours, and air that wanders within days and within hours beside its daily wave."""
    rng = np.random.default_rng(4)
    hours = np.arange(0, 48, 1 / 12)
    air = 4 * np.cos(2 * np.pi * (hours - 15) / 24)
    for kelvin, memory_h in ((3, 48), (1, 3)):
        kept, now = np.exp(-1 / 12 / memory_h), 0.0
        for n in range(1, len(hours)):
            now = kept * now + kelvin * np.sqrt(1 - kept**2) * rng.normal()
            air[n] += now
    return hours, air


def cosine(one, other):
    """Return how far two curves are the same but for a constant."""
    return np.corrcoef(one, other)[0, 1]


@pytest.mark.parametrize("hours", [0.75, 1, 1.5, 2, 3, 4, 5, 6])
def test_some_time_constants_stand_for_all_between(hours):
    """What steel of another draws, one of them draws nearly; and what it lacks to the air."""
    at = warmed(*weather())
    night = slice(300, 420)
    true = steel_c(at, hours)[night]
    tried = [steel_c(at, one)[night] for one in STEEL_H]
    air = at.columns["temperature_c"][night]

    assert max(cosine(true, one) for one in tried) > 0.96
    assert max(cosine(air - true, air - one) for one in tried) > 0.96
