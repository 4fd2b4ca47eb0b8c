"""Families with a choice: the members worth trying are read from the recordings."""

import dataclasses

import numpy as np
import pytest
from effects.sky import SITE, campaign, replaced, without
from hypothesis import given
from hypothesis import strategies as st

from pyport.angles import DEG
from pyport.effects import CATALOGUE, Circumstances, MissingColumn
from pyport.effects.empirical.oscillations import oscillation
from pyport.effects.telescope.receiver import band_of, bands
from pyport.mounts import KINDS

AT = campaign()
MOST = 41


def variants(effect, at=AT):
    """Return the names of the members worth trying."""
    return [one.variant for one in CATALOGUE[effect].variants(at)]


@pytest.mark.parametrize("effect", sorted(set(CATALOGUE) - {"parallax", "azimuth_turns"}))
def test_members_are_few_and_told_apart(effect):
    """No family has more members than a search can bear, and each has a name of its own."""
    names = variants(effect)

    assert 0 < len(names) <= MOST
    assert len(set(names)) == len(names)


def test_harmonics_need_much_of_the_circle():
    """Azimuths over less of it tell no harmonic from another curve, a bit more tell some."""
    more = AT.take((AT.az > 90 * DEG) & (AT.az < 249 * DEG))
    assert variants("azimuth_harmonics", more) == ["k = 2", "k = 3", "k = 4"]

    half = AT.take((AT.az > 90 * DEG) & (AT.az < 275 * DEG))
    assert variants("azimuth_harmonics", half) == [f"k = {k}" for k in range(2, 9)]

    at = AT.take((AT.az > 90 * DEG) & (AT.az < 235 * DEG))

    for effect in ("azimuth_harmonics", "elevation_harmonics", "azimuth_track"):
        with pytest.raises(MissingColumn, match="azimuths over 150 deg of the circle"):
            variants(effect, at)
    assert variants("azimuth_harmonics") == [f"k = {k}" for k in range(2, 9)]


@pytest.mark.parametrize(
    ("step_deg", "told"), [(10, list(range(2, 9))), (22.5, [2, 3, 4]), (30, [2, 3]), (45, [2])]
)
def test_a_grid_tells_harmonics_by_four_azimuths_to_a_wave(step_deg, told):
    """However many rows stand at each of them; from eighteen on all of them."""
    az, el = np.meshgrid(np.arange(0.0, 360.0, step_deg), np.arange(15.0, 80.0, 5.0))
    at = Circumstances(az.ravel() * DEG, el.ravel() * DEG)

    assert variants("azimuth_harmonics", at) == [f"k = {k}" for k in told]


@pytest.mark.parametrize("step_deg", [60, 90])
def test_a_coarser_grid_tells_none(step_deg):
    """Six azimuths draw any wave."""
    az, el = np.meshgrid(np.arange(0.0, 360.0, step_deg), np.arange(15.0, 80.0, 5.0))

    with pytest.raises(MissingColumn, match="azimuths over 150 deg of the circle"):
        variants("azimuth_track", Circumstances(az.ravel() * DEG, el.ravel() * DEG))


@given(st.sets(st.integers(0, 400), min_size=2, max_size=60))
def test_steps_fall_between_recordings(moments):
    """A step is tried between two recordings that follow each other, never at or outside them."""
    time = np.array(sorted(moments), float) * 3600
    at = Circumstances(np.zeros(len(time)), np.ones(len(time)), columns={"time": time})
    steps = CATALOGUE["epoch_offset"].variants(at)

    assert 0 < len(steps) <= MOST
    for step in steps:
        x, _ = step.columns(at)
        after = x[:, 0] == 1
        assert time[~after].max() < step.parameter < time[after].min()
        assert np.all(np.diff(after.astype(int)) >= 0)


def test_longest_gap_is_among_the_steps():
    """Things are moved while nobody observes: the longest gap in time is always tried."""
    time = np.concatenate([np.arange(500) * 60.0, 1e6 + np.arange(37) * 60.0])
    at = Circumstances(np.zeros(537), np.ones(537), columns={"time": time})
    since = [one.parameter for one in CATALOGUE["epoch_offset"].variants(at)]

    assert any(499 * 60 < moment < 1e6 for moment in since)


def test_name_of_a_step_is_its_time():
    """A step names its moment as ISO 8601, UTC."""
    at = Circumstances(np.zeros(2), np.ones(2), columns={"time": np.array([0.0, 7200.0])})

    assert variants("epoch_offset", at) == ["step, since 1970-01-01T01:00:00Z"]


def test_one_moment_has_no_epochs():
    """Recordings of one session at one moment cannot show that something was moved."""
    at = Circumstances(np.zeros(3), np.ones(3), columns={"time": np.zeros(3)})

    for effect in ("epoch_offset", "epoch_azimuth_zero"):
        with pytest.raises(MissingColumn, match="a second moment"):
            variants(effect, at)
    for effect in ("epoch_tilt", "epoch_sag", "epoch_clock"):
        with pytest.raises(MissingColumn, match="a second session"):
            variants(effect, replaced(AT, session=np.full(len(AT), "one")))


@given(st.lists(st.sampled_from("abcdef"), min_size=2, max_size=40))
def test_tilt_sag_and_clock_may_set_in_with_a_session(labels):
    """A step of tilt, sag or clock is tried where a session begins, and nowhere else."""
    session, time = np.array(labels), np.arange(len(labels)) * 3600.0
    first = {labels.index(name) for name in labels} - {0}
    at = Circumstances(
        np.ones(len(time)),
        np.ones(len(time)),
        SITE,
        columns={"time": time, "session": session},
    )

    for effect in ("epoch_tilt", "epoch_sag", "epoch_clock"):
        if not first:
            assert CATALOGUE[effect].missing(at) == "a second session"
            continue
        steps = [one for one in CATALOGUE[effect].variants(at) if one.parameter is not None]
        begin = {int(np.argmax(np.any(step.columns(at), axis=(0, 2)))) for step in steps}
        assert begin == first


def test_many_sessions_are_not_all_tried():
    """With more sessions than a search can bear, steps are tried at some of their beginnings."""
    time = np.arange(90) * 3600.0
    columns = {"time": time, "session": np.arange(90).astype(str)}
    at = Circumstances(np.ones(90), np.ones(90), columns=columns)

    assert len(variants("epoch_sag", at)) == 41


def test_one_change_of_session_is_one_step():
    """Two sessions one after the other are told by when the second began; mixed ones by name."""
    time = np.arange(6) * 3600.0
    at = Circumstances(np.ones(6), np.ones(6), columns={"time": time})
    apart, mixed = (replaced(at, session=np.array(list(names))) for names in ("aaabbb", "ababab"))

    assert variants("epoch_tilt", apart) == ["step, since 1970-01-01T03:00:00Z"]
    assert "constant per session" not in variants("epoch_offset", apart)
    assert "constant per session" in variants("epoch_tilt", mixed)
    assert "constant per session" in variants("epoch_offset", mixed)
    assert variants("epoch_tilt", without(apart, "time_utc")) == ["constant per session"]


def test_sources_must_move_over_the_sky():
    """A source takes part when it was seen at three hour angles, and no source can alone."""
    source = np.where(np.arange(len(AT)) < 2, "rare", AT.columns["source"])
    one = AT.columns["source"] == "S3"

    assert "rare" not in variants("source_position", replaced(AT, source=source))
    assert variants("source_position")[0] == "every source"
    with pytest.raises(MissingColumn, match="a second source"):
        variants("source_position", AT.take(one))
    with pytest.raises(MissingColumn, match="a source at three hour angles"):
        variants("source_position", AT.take(np.array([0, 1, 2])))


def test_many_sources_are_tried_one_by_one():
    """With more sources than can be fitted at once, those observed most are tried alone."""
    source = np.char.add("Q", (np.arange(len(AT)) % 60).astype(str))
    names = variants("source_position", replaced(AT, source=source))

    assert "every source" not in names
    assert len(names) == 20


def test_parallax_is_of_the_solar_system():
    """Named stars have no parallax; the Moon has; where no target is named all may have."""
    moon = replaced(AT, source=np.where(np.arange(len(AT)) % 2, "MOON", "3C84"))
    effect = CATALOGUE["parallax"]

    with pytest.raises(MissingColumn, match="a solar-system target"):
        effect.columns(AT)
    np.testing.assert_array_equal(effect.columns(moon)[1][::2], 0)
    assert np.all(effect.columns(moon)[1][1::2] < 0)
    assert np.all(effect.columns(without(AT, "source"))[1] < 0)


@given(
    st.lists(
        st.sampled_from([1.4e3, 1.42e3, 1.67e3, 5e3, 6.7e3, 2.2e4, np.nan]), min_size=1
    ).filter(lambda all_: np.isfinite(all_).any())
)
def test_bands_hold_neighbours_together(frequencies):
    """Frequencies within a quarter of each other share a band; an octave never does."""
    frequency = np.array(frequencies)
    name = band_of(frequency, bands(frequency))

    assert np.all((name == "") == np.isnan(frequency))
    for one, a in zip(name, frequency, strict=True):
        for other, b in zip(name, frequency, strict=True):
            if a <= b <= 1.25 * a:
                assert one == other
            if b > 2 * a:
                assert one != other


def test_receivers_that_are_bands_are_tried_once():
    """A split that receivers and frequencies draw alike is one member, not two."""
    frequency = np.where(AT.columns["receiver"] == "C", 5000.0, 1420.0)

    assert variants("receiver_offset", replaced(AT, frequency_mhz=frequency)) == ["by receiver"]
    assert variants("receiver_offset") == ["by receiver", "by frequency band"]


def test_bands_stay_where_the_recordings_put_them():
    """A part of the recordings is split at the frequencies that the whole was split at."""
    by_band = CATALOGUE["receiver_offset"].variants(AT)[1]
    high = AT.columns["frequency_mhz"] > 1500
    whole, part = by_band.columns(AT), by_band.columns(AT.take(high))

    np.testing.assert_array_equal(part, [axis[high] for axis in whole])


def test_a_single_receiver_or_channel_shows_nothing():
    """One receiver, one band, one polarisation: nothing to compare."""
    rows = len(AT)
    same = replaced(AT, receiver=np.full(rows, "C"), frequency_mhz=np.full(rows, 5000.0))
    with pytest.raises(MissingColumn, match="a second receiver"):
        variants("receiver_offset", same)
    with pytest.raises(MissingColumn, match="a second polarisation"):
        variants(
            "beam_squint", without(replaced(AT, polarisation=np.full(rows, "left")), "channel")
        )


def test_squint_cancels_over_the_beams():
    """The offsets of all beams of a label add up to nothing."""
    for member in CATALOGUE["beam_squint"].variants(AT):
        label = AT.columns[member.variant.removeprefix("by ")]
        x, _ = member.columns(AT)
        each = [x[label == value][0] for value in np.unique(label)]

        np.testing.assert_array_equal(np.sum(each, axis=0), 0)


def test_azimuth_is_cut_only_where_it_was_wrapped():
    """Azimuth recorded from 0 to 360 deg may be cut elsewhere; where no cut shows none is tried."""
    half = AT.take((AT.az > 0.1) & (AT.az < 3.0))

    assert variants("azimuth_scale") == ["azimuth as recorded", "azimuth cut in the south"]
    assert variants("azimuth_scale", half) == ["azimuth as recorded"]


def test_sun_is_tried_late_only_where_it_can_be_computed():
    """Earlier places of the Sun need the time and the site; its elevation tells day from night."""
    azimuth_only = without(without(AT, "time_utc"), "sun_el_deg")
    polar_day = replaced(AT, sun_el=np.full(len(AT), 0.5))

    assert variants("thermal_tilt", azimuth_only) == ["day and night"]
    assert variants("thermal_tilt", without(AT, "time_utc")) == [
        "day and night",
        "while the Sun is up",
        "as the Sun is high",
    ]
    assert "while the Sun is up" not in variants("thermal_tilt", polar_day)
    assert variants("thermal_tilt")[-1] == "while the Sun is up, 3 h late"


def test_a_clock_is_tried_as_set_each_session_and_as_set_once():
    """In one session both are the same."""
    names = AT.columns["session"]
    alone = AT.take(names == names[0])
    assert variants("clock_rate") == ["set each session", "set once"]
    assert variants("clock_rate", alone) == ["set each session"]
    assert variants("clock_rate", without(AT, "session")) == ["set each session", "set once"]


def test_a_clock_that_was_set_once_goes_on_for_ever():
    """From the first reading, whatever its session: a tilt and a zero of azimuth that change."""
    _, once = CATALOGUE["clock_rate"].variants(AT)
    late = AT.take(np.flatnonzero(AT.columns["time"] > np.median(AT.columns["time"])))
    since = late.columns["time"] - AT.columns["time"].min()
    turned = CATALOGUE["clock"].columns(late)

    for own, of_constant in zip(once.columns(late), turned, strict=True):
        np.testing.assert_allclose(own[:, 0], of_constant[:, 0] * since)
    assert (once.consists_of, once.changes_with) == (("epoch_tilt", "epoch_azimuth_zero"), "time")


def test_a_clock_goes_on_in_its_session_and_starts_anew_in_another():
    """Applied to later rows of its session it counts from its start; another from its own."""
    names = AT.columns["session"]
    alone = AT.take(names == names[0])
    later = np.flatnonzero(AT.columns["time"] > np.median(alone.columns["time"]))
    late = AT.take(later)
    known = late.columns["session"] == names[0]
    kept = CATALOGUE["clock_rate"].variants(alone)[0].columns(late)
    own, whole = (CATALOGUE["clock_rate"].columns(at) for at in (late, AT))

    assert 0 < known.sum() < len(known)
    for axis in (0, 1):
        np.testing.assert_array_equal(kept[axis][~known], own[axis][~known])
        np.testing.assert_array_equal(kept[axis][known], whole[axis][later][known])
        assert not np.array_equal(kept[axis][known], own[axis][known])


@pytest.mark.parametrize(("gap_h", "same"), [(5.9, True), (6.1, False), (80000, False)])
def test_a_session_of_the_same_name_in_another_night_starts_anew(gap_h, same):
    """After a night's gap it is another night."""
    names = AT.columns["session"]
    alone = AT.take(names == names[0])
    time = alone.columns["time"]
    later = replaced(alone, time=time - time.min() + time.max() + gap_h * 3600)
    kept, anew = (one.columns(later) for one in (clock(alone), clock(later)))

    assert np.array_equal(kept[1], anew[1]) != same


def clock(at):
    """Return the clock that was set each session of some recordings."""
    return CATALOGUE["clock_rate"].variants(at)[0]


def test_clock_tries_ut1_only_where_it_changed():
    """Over one year UT1-UTC is like a constant; over three it is not."""
    assert variants("clock") == ["constant"]
    assert variants("clock", campaign(nights=36)) == ["constant", "UT1-UTC left out"]
    assert variants("clock", without(AT, "time_utc")) == ["constant"]


def test_scans_of_elevation_alone_have_one_timing():
    """Where azimuth was never scanned the two meanings of a scan's rate are one."""
    elevation = replaced(AT, scan_axis=np.full(len(AT), "el"))

    assert variants("scan_timing", elevation) == ["rate of the axis"]
    assert len(variants("scan_timing")) == 2


def test_edges_lie_inside_the_sky_that_was_observed():
    """Each edge of a jump has recordings on both sides."""
    for member in CATALOGUE["subreflector_jump"].variants(AT):
        _, y = member.columns(AT)

        assert 0 < y.sum() < len(AT)
    one = dataclasses.replace(AT, az=np.ones(len(AT)), el=np.ones(len(AT)))
    with pytest.raises(MissingColumn, match="a second direction"):
        variants("subreflector_jump", one)


@pytest.mark.parametrize("mount", ["xy-ns", "german", "fork"])
def test_edges_of_a_mount_lie_in_the_angles_of_its_axes(mount):
    """Either axis steps at curves in both, at those in azimuth and elevation both may."""
    side = np.where(np.arange(len(AT)) % 2 == 0, "east", "west")
    at = dataclasses.replace(replaced(AT, pier_side=side), mount=KINDS[mount])
    members = CATALOGUE["subreflector_jump"].variants(at)
    of_axes = [one for one in members if "axis" in one.member]

    first, second = (
        {one.variant for one in of_axes if one.member["axis"] == axis}
        for axis in ("first", "second")
    )
    assert not first & second
    assert len(of_axes) > len(members) / 2
    for one in of_axes:
        across = one.member["axis"] == "first"
        moved, still = one.columns(at) if across else one.columns(at)[::-1]
        size = at.side * (np.cos(at.axes.el) if across else 1.0)
        beyond = at.axes.az >= one.member.get("beyond_az_rad", -np.inf)
        beyond &= at.axes.el >= one.edge(at.axes.az)

        np.testing.assert_allclose(moved[:, 0], size * beyond)
        assert not still.any()
        assert 0 < beyond.sum() < len(at)
    straight = {one.member.get("beyond_az_rad") for one in of_axes}
    assert 0.0 in straight


def test_an_axis_that_never_turns_twice_is_nowhere_cut_open():
    """Cut in the north an X from -90 to 90 deg would step by a turn at the zenith."""
    at = dataclasses.replace(AT, mount=KINDS["xy-ns"])

    assert variants("azimuth_scale", at) == ["azimuth as recorded"]


def test_an_oscillation_is_of_one_antenna():
    """The antennas of an array have a servo each: no period is tried for all of them."""
    antennas = np.array(["C00", "C01"])[np.arange(len(AT)) % 2]

    with pytest.raises(MissingColumn, match="a single antenna"):
        variants("oscillation", replaced(AT, antenna=antennas))


def test_a_phase_that_wanders_is_free_in_each_stretch():
    """Every stretch has two waves in each axis; outside of the stretches nothing swings."""
    time = np.arange(40) * 60.0
    at = Circumstances(np.zeros(40), np.ones(40), columns={"time": time})
    x, y = oscillation(600.0, 0.0, [(0.0, 600.0), (1200.0, 1800.0)]).columns(at)
    inside = np.stack([time <= 600, (time >= 1200) & (time <= 1800)], axis=1)

    assert x.shape == y.shape == (40, 8)
    for wave in (0, 1):
        np.testing.assert_array_equal(x[:, wave:4:2] != 0, y[:, 4 + wave :: 2] != 0)
        np.testing.assert_array_equal(x[~inside[:, 0], wave], 0)
        np.testing.assert_array_equal(x[~inside[:, 1], 2 + wave], 0)
    assert not x[:, 4:].any()
    np.testing.assert_allclose(x[:, 0] ** 2 + x[:, 1] ** 2, inside[:, 0])


def test_what_swings_along_a_line_has_one_amplitude_for_both_axes():
    """Three in x for four in y, of half as many coefficients."""
    at = Circumstances(np.zeros(40), np.ones(40), columns={"time": np.arange(40) * 60.0})
    line = oscillation(600.0, 0.0, [(0.0, 600.0), (1200.0, 1800.0)], direction_deg=53.130102354)
    x, y = line.columns(at)

    assert [one.name for one in line.coefficients] == [
        "sine[1]", "cosine[1]", "sine[2]", "cosine[2]"
    ]  # fmt: skip
    np.testing.assert_allclose(4 * x, 3 * y, atol=1e-9)
    np.testing.assert_allclose(np.hypot(x, y)[:11].max(axis=0) > 0.9, [True, True, False, False])
    assert line.make(**line.member).coefficients == line.coefficients


@pytest.mark.parametrize("member", [{"period_s": 0.5}, {"period_s": float("nan")}])
def test_an_oscillation_has_a_period(member):
    """A file cannot ask for a period of no length."""
    with pytest.raises(ValueError, match="period above a second"):
        oscillation(**member)


@pytest.mark.parametrize("mount", ["xy-ns", "fork"])
def test_a_warm_tube_sags_along_elevation_on_any_mount(mount):
    """On an alt-azimuth mount that is a member of two coefficients, "as cos E", and no other."""
    at = dataclasses.replace(AT, mount=KINDS[mount])
    family = {one.variant: one for one in CATALOGUE["temperature"].variants(at)}
    excess = AT.columns["temperature_c"] - AT.columns["temperature_c"].mean()

    assert "as the tube sags" not in variants("temperature")
    found = family["as the tube sags"].columns(at)
    wanted = at.along_axes(np.zeros((len(at), 1)), (excess * np.cos(AT.el))[:, None])
    np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_a_drift_stays_as_it_was_at_the_ends_of_its_recordings():
    """What crept for a night is not known to go on: a month later it is where the night ended."""
    time = np.array([-30 * 86400.0, 0.0, 4e4, 8e4, 30 * 86400.0])
    drift = CATALOGUE["drift"].make(order=2, span_s=(0.0, 8e4))
    at = Circumstances(np.ones(5), np.ones(5), columns={"time": time})

    for axis in drift.columns(at):
        np.testing.assert_array_equal(axis[0], axis[1])
        np.testing.assert_array_equal(axis[-1], axis[-2])
        assert not np.array_equal(axis[1], axis[2])
