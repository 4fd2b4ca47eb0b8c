"""A watch from the outside: what it raises, names, confirms and withdraws."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_nights import world

import pyport
from pyport.errors import BadInput
from pyport.recordings.from_table import from_table
from pyport.watch import alarms, state


@pytest.fixture(scope="module")
def drawn():
    """Return nights in which a tilt of three sigmas comes."""
    return world()


@pytest.fixture(scope="module")
def seen(drawn):
    """Return a watch that went through a night with a tilt, and what it saw."""
    watch = pyport.Watch(drawn.past, header=drawn.header)
    return watch, list(watch.replay(drawn.watched))


@pytest.mark.slow
def test_a_tilt_is_raised_named_dated_and_measured(drawn, seen):
    """Three sigmas are seen within five pointings, and called by their name."""
    watch, rows = seen
    (alarm,) = watch.standing
    first = next(one.row for one in rows if one.events)

    assert 0 < first - drawn.step.first <= 5
    assert alarm.effect == "tilt"
    assert alarm.named
    assert abs(alarm.since_row - 1 - drawn.step.first) <= 1
    for one, true in zip(alarm.parameters, drawn.step.truth.values(), strict=True):
        assert abs(one["value"] - true) < 4 * one["sigma"]
    assert "the azimuth axis leans" in alarm.sentence


def test_events_come_in_order_without_gaps(seen):
    """Raised comes first, confirmed later, each event has its number."""
    watch, _ = seen
    names = [one.event for one in watch.events]

    assert [one.number for one in watch.events] == list(range(1, len(names) + 1))
    assert names[0] == "raised"
    assert names[-1] == "confirmed"


@pytest.mark.slow
@pytest.mark.parametrize("count", [8, 15])
def test_what_went_back_while_it_was_named_is_over_and_was_no_other_cause(count):
    """Since and until when: nothing that follows the Sun or a direction, nor a second change."""
    drawn, first = world(step=False), 20
    rows = np.arange(len(drawn.watched["az_deg"]))
    off = 5 * drawn.sigma * ((rows >= first) & (rows < first + count))
    watch = pyport.Watch(drawn.past, header=drawn.header)
    list(watch.replay(drawn.watched | {"d_el_arcsec": drawn.watched["d_el_arcsec"] + off}))
    (alarm,) = watch.alarms.values()
    when = np.array(drawn.watched["time_utc"], "datetime64[s]").astype(float)

    assert watch.standing == []
    assert [one.event for one in watch.events] == ["raised", "over"]
    assert "went back" in alarm.sentence
    last = watch.events[-1]
    assert f"to {last.alarm['back']}: " in state.words(last)
    ended = replace(last, alarm=last.alarm | {"back": None})
    assert f"from {last.alarm['since']} to {last.alarm['ended']}: " in state.words(ended)
    assert abs(alarm.since_row - 1 - first) <= 1
    assert abs(np.searchsorted(when, alarm.back) - first - count) <= 1
    assert {"sag_cosine", "elevation_zero"} & {one for alike, _ in alarm.members for one in alike}


@pytest.mark.slow
def test_what_goes_back_after_it_was_confirmed_is_over():
    """The second alarm holds the sum, which is nothing."""
    drawn = world(step=False)
    rows = np.arange(len(drawn.watched["az_deg"]))
    off = 5 * drawn.sigma * ((rows >= 20) & (rows < 90))
    watch = pyport.Watch(drawn.past, header=drawn.header)
    list(watch.replay(drawn.watched | {"d_el_arcsec": drawn.watched["d_el_arcsec"] + off}))

    assert watch.standing == []
    assert [one.state for one in watch.alarms.values()] == ["over", "withdrawn"]


def test_rows_one_by_one_are_the_same_as_together(drawn, seen):
    """`update` gives what `replay` gives."""
    watch = pyport.Watch(drawn.past, header=drawn.header)
    table = drawn.watched
    for n in range(25):
        one = watch.update({name: cells[n] for name, cells in table.items()})
        assert one.evidence == seen[1][n].evidence
        assert [e.event for e in one.events] == [e.event for e in seen[1][n].events]


def test_nights_go_on_after_a_row_of_a_wrong_year(drawn):
    """A clock that was wrong once does not make one night of all that follow."""
    watch = pyport.Watch(drawn.past, header=drawn.header)
    row = {name: cells[0] for name, cells in drawn.watched.items() if name != "session"}
    first = np.datetime64(drawn.watched["time_utc"][0], "s")
    nights = []
    for days in (0, 1, 2000, 1, 2, 3):
        watch.update({**row, "time_utc": str(first + np.timedelta64(24 * days, "h"))})
        nights.append(watch.session)

    assert nights[1] == nights[3]
    assert len(set(nights)) == 5


def test_a_session_for_each_row_is_none(drawn):
    """The rows of a night belong together, whatever is written beside each; as in the past."""
    labelled = [
        {**table, "session": np.char.add("scan ", np.arange(len(table["az_deg"])).astype(str))}
        for table in (drawn.past, drawn.watched)
    ]
    plain = [{name: one for name, one in table.items() if name != "session"} for table in labelled]
    evidence = []
    for past, watched in (plain, labelled):
        watch = pyport.Watch(past, header=drawn.header)
        evidence.append([one.evidence for one in watch.replay(watched)])

    assert evidence[0] == evidence[1]


@pytest.mark.slow
def test_a_step_back_is_the_same_alarm_over(drawn):
    """What comes back ends both: the telescope is as it was."""
    watch = pyport.Watch(drawn.past, header=drawn.header)
    recordings = from_table(drawn.watched, drawn.header)
    back = np.arange(len(recordings)) >= drawn.step.first + 60
    arcsec = np.pi / 648000
    recordings = replace(
        recordings,
        x=recordings.x - back * drawn.step.offset[:, 0] * arcsec,
        y=recordings.y - back * drawn.step.offset[:, 1] * arcsec,
    )
    list(watch.replay(recordings))

    assert watch.raised == 2
    assert watch.standing == []


@pytest.mark.slow
def test_an_alarm_that_the_data_withdraw_is_withdrawn():
    """Four outlying pointings alike raise an alarm; thirty good ones take it back."""
    drawn = world(step=False)
    recordings = from_table(drawn.watched, drawn.header)
    arcsec = np.pi / 648000
    odd = (np.arange(len(recordings)) >= 10) & (np.arange(len(recordings)) < 14)
    recordings = replace(recordings, y=recordings.y + odd * 4 * drawn.sigma * arcsec)
    watch = pyport.Watch(drawn.past, header=drawn.header)
    rows = list(watch.replay(recordings))
    events = [event.event for one in rows for event in one.events]

    assert events[0] == "raised"
    assert events[-1] == "withdrawn"
    assert watch.standing == []


@pytest.mark.slow
def test_a_night_without_change_raises_nothing():
    """Ten nights of white noise pass in silence."""
    drawn = world(step=False)
    watch = pyport.Watch(drawn.past, header=drawn.header)
    list(watch.replay(drawn.watched))

    assert watch.raised == 0


@pytest.mark.slow
def test_what_the_past_did_not_show_is_no_change():
    """Elevation follows a temperature that hardly moved in the past: said as if it always had."""
    quiet = world(step=False)
    rng = np.random.default_rng(3)
    past, watched = dict(quiet.past), dict(quiet.watched)
    n = len(watched["az_deg"])
    past["temperature_c"] = np.round(5 + 0.2 * rng.standard_normal(len(past["az_deg"])), 1)
    warm = np.round(5 + 12 * np.sin(np.linspace(0, 12, n)) ** 2, 1)
    for table in (past, watched):
        warmth = table.setdefault("temperature_c", warm) - 5
        table["d_el_arcsec"] = table["d_el_arcsec"] + 0.5 * quiet.sigma * warmth
    watch = pyport.Watch(past, header=quiet.header)
    list(watch.replay(watched))

    assert watch.raised >= 1
    assert [one for one in watch.alarms.values() if not one.stood] == []
    (alarm,) = watch.standing
    assert "temperature" in str(alarm.members)
    assert "as if it had always been so: the past did not show it" in alarm.sentence
    assert alarm.as_json(timed=True)["stood"] is True


@pytest.mark.slow
def test_more_scatter_is_an_alarm_of_scatter():
    """Readings that scatter three times as far are called that."""
    quiet = world(step=False)
    recordings = from_table(quiet.watched, quiet.header)
    rng = np.random.default_rng(1)
    later = np.arange(len(recordings)) >= 20
    more = 2.8 * quiet.sigma * np.pi / 648000 * rng.standard_normal(len(recordings))
    watch = pyport.Watch(quiet.past, header=quiet.header)
    list(watch.replay(replace(recordings, y=recordings.y + later * more)))

    (alarm,) = watch.standing
    assert alarm.effect == "scatter_el"
    assert 2 < alarm.parameters[0]["value"] < 4.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "column", "sigmas", "shape"),
    [
        ("refraction", "d_el_arcsec", 20, lambda el: 1 / np.tan(el)),
        ("elevation_zero", "d_el_arcsec", 40, np.ones_like),
        ("collimation", "d_xel_arcsec", 40, np.ones_like),
    ],
)
def test_a_large_change_has_its_own_name(effect, column, sigmas, shape):
    """Refraction switched off was scatter 28 times as large, an encoder's slip both zeros."""
    quiet = world(36, step=False)
    el = np.radians(quiet.watched["el_deg"])
    off = sigmas * quiet.sigma * shape(el) * (np.arange(len(el)) >= 20)
    watch = pyport.Watch(quiet.past, header=quiet.header)
    list(watch.replay(quiet.watched | {column: quiet.watched[column] + off}))

    (alarm,) = watch.standing
    (size,) = alarm.parameters
    assert (alarm.effect, alarm.named) == (effect, True)
    assert abs(size["value"] - sigmas * quiet.sigma) < 4 * size["sigma"]
    what = "--add refraction" if effect == "refraction" else f"fit {effect.replace('_', ' ')} anew"
    assert alarm.next.endswith(what)


def test_a_name_is_said_until_it_is_excluded():
    """Two that are equally likely were renamed back and forth with every other row."""
    one, other, third = (((name,), (name,)) for name in ("tilt", "sag_cosine", "refraction"))
    alarm = alarms.Alarm(1, "", 0.0, 1)
    said = []
    for chances in ([0.6, 0.4, 0], [0.4, 0.6, 0], [0.6, 0.4, 0], [0, 0.4, 0.6], [0, 0.01, 0.99]):
        names = (one, other, third)
        found = alarms.members(names, np.array(chances))
        alarms.listed(alarm, found, names[int(np.argmax(chances))])
        said.append(alarm.news())

    assert said == [True, False, False, True, True]
    assert alarm.named


def test_what_follows_one_thing_is_another_cause_than_what_follows_another():
    """All that follow something were one effect, and confirmed as the likeliest of them."""
    hour, temperature = (
        (("driven_term",), (f"tilt follows {what}",)) for what in ("the time of day", "temperature")
    )
    alarm = alarms.Alarm(1, "", 0.0, 1)
    found = alarms.members((hour, temperature), np.array([0.4, 0.6]))
    alarms.listed(alarm, found, temperature)

    assert alarm.called == ["tilt follows temperature", "tilt follows the time of day"]
    assert not alarm.named
    assert [one["called"] for one in alarm.as_json(timed=False)["members"]] == alarm.called


def test_another_past_s_state_is_refused(drawn, seen, tmp_path):
    """A state belongs to the past and the model it was made with."""
    state.save(seen[0], tmp_path / "state.npz")
    other = pyport.Watch(drawn.past, header=drawn.header, pointings_per_false_alarm=100)

    with pytest.raises(BadInput, match="another past, model or program"):
        state.load(other, tmp_path / "state.npz")


def test_too_short_a_past_is_refused(drawn):
    """Twenty pointings are no past."""
    short = {name: cells[:20] for name, cells in drawn.past.items()}

    with pytest.raises(BadInput, match="past pointings, expected 30 or more"):
        pyport.Watch(short, header=drawn.header)


def test_a_row_without_offset_leaves_the_watch_as_it_was(drawn):
    """Bad input is refused and changes nothing."""
    watch = pyport.Watch(drawn.past, header=drawn.header)
    with pytest.raises(BadInput, match="no offset"):
        watch.update({"time_utc": "2024-03-28T12:00:00", "az_deg": 10.0, "el_deg": 50.0})

    assert watch.row == 0


def test_a_row_of_an_unknown_antenna_leaves_the_night_as_it_was(drawn):
    """Dated years ahead, it would end the detection of nights."""
    watch = pyport.Watch(drawn.past, header=drawn.header)
    before = watch.last, watch.session
    row = {name: cells[0] for name, cells in drawn.watched.items()}
    with pytest.raises(BadInput, match="no past recordings"):
        watch.update(row | {"antenna": "other", "time_utc": "2030-01-01T00:00:00"})

    assert (watch.last, watch.session) == before
