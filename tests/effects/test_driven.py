"""What may drive a term of the mount, which terms, and at which price."""

import numpy as np
import pytest
from effects.sky import campaign, replaced, without

from pyport.diagnosis.candidates import design
from pyport.diagnosis.case import confounded
from pyport.diagnosis.preparing import prepare
from pyport.effects import CATALOGUE, MissingColumn
from pyport.effects.base import THE_HOUR
from pyport.effects.empirical.conditions import MOST_DRIVERS, drivers, untried
from pyport.effects.telescope.thermal import ways
from pyport.formats.models import load
from pyport.recordings.schema import Recordings, stack

AT = campaign(120)
RNG = np.random.default_rng(5)
NOISE = RNG.normal(size=(12, 120))


def bare(**columns):
    """Return a campaign with the time left out and some columns of its own."""
    at = AT
    for name in (
        *("time_utc", "temperature_c", "wind_speed_m_s", "humidity_pct", "pressure_hpa"),
        *("sun_el_deg", "rotator_deg"),
    ):
        at = without(at, name)
    return replaced(at, **columns)


def members(at):
    """Return what follows what."""
    return [one.variant for one in CATALOGUE["driven_term"].variants(at)]


def names(at):
    """Return the conditions that are tried."""
    return [one.name for one in drivers(at)]


def test_what_moves_telescopes_comes_first():
    """What the contract names and what is computed, then a few of the columns of any name."""
    first = ["temperature_c", "the time of day", "sun_el_deg", "wind_speed_m_s"]
    more = replaced(AT, **{f"sensor{n}": NOISE[n] for n in range(8)})

    for one in (AT, more):
        assert names(one)[:4] == first
        assert set(names(one)[4:6]) == {"humidity_pct", "pressure_hpa"}
    assert len(names(more)) == MOST_DRIVERS
    assert untried(AT) == []
    assert {*names(more)[6:], *untried(more)} == {f"sensor{n}" for n in range(8)}


def test_temperature_drives_here_what_it_does_not_drive_elsewhere():
    """Zeros and sag that do are `temperature`; the tilt and refraction are not."""
    warm = [name for name in members(AT) if "temperature" in name]

    assert warm[:2] == ["tilt follows temperature_c", "refraction follows temperature_c"]
    assert all(name.startswith("tilt follows temperature_c") for name in warm[2:])
    assert len(warm) - 1 == len(ways(AT)) == 7


def test_unknown_conditions_drive_the_tilt_only():
    """An offset that follows a column of which nothing is known stays without a name."""
    assert members(bare(hydraulic_bar=NOISE[0])) == ["tilt follows hydraulic_bar"]
    assert "collimation follows focus_mm" in members(bare(focus_mm=NOISE[0]))
    assert "elevation_zero follows yoke_temp_c" in members(bare(yoke_temp_c=NOISE[0]))


@pytest.mark.parametrize(
    "name",
    [
        *("obsnum", "scan_id", "fit_rms", "az_rate", "model_offset", "snr", "fwhm_x", "mjd"),
        *("d_focus", "weight", "scan_rate", "ra", "wind_az", "frequency_mhz", "tsys_k"),
    ],
)
def test_places_times_errors_and_details_drive_nothing(name):
    """What says where, when, how well or how a measurement was made is no condition."""
    with pytest.raises(MissingColumn, match="temperature_c or"):
        members(bare(**{name: NOISE[0]}))


def test_counters_drive_nothing():
    """A column that only grows, with the rows or with time, is a clock: that is a drift."""
    grows = np.cumsum(np.abs(NOISE[0]))
    mixed = RNG.permutation(len(AT))

    for values in (grows, -grows):
        with pytest.raises(MissingColumn):
            members(bare(strain=values))
    shuffled = replaced(AT, strain=grows).take(mixed)
    assert "strain" not in names(shuffled)
    assert "strain" in names(replaced(without(shuffled, "time_utc"), pressure_hpa=np.ones(120)))


def test_columns_that_the_direction_draws_drive_nothing():
    """A torque that goes as cos E is a name for the elevation; half noise, it is not."""
    torque = np.cos(AT.el)
    noisy = torque + NOISE[0] * torque.std()

    with pytest.raises(MissingColumn):
        members(bare(torque=torque))
    assert "tilt follows torque" in members(bare(torque=noisy))


def test_a_few_values_are_no_condition():
    """Four values are steps; five may be a line."""
    number = np.arange(120) * 7 % 5
    with pytest.raises(MissingColumn):
        members(bare(strain=np.minimum(number, 3).astype(float)))
    assert members(bare(strain=number.astype(float)))


def test_angles_that_go_round_are_left_to_the_rotator():
    """An angle of the whole circle has no middle; an inclinometer has one."""
    with pytest.raises(MissingColumn):
        members(bare(derotator_deg=60 * NOISE[0]))
    assert members(bare(inclinometer_arcsec=60 * NOISE[0]))


def test_air_alone_drives_refraction():
    """Its temperature and its pressure change its density."""
    driven = {one.driver for one in CATALOGUE["driven_term"].variants(AT) if "refr" in one.variant}

    assert driven == {"temperature_c", "pressure_hpa"} & set(AT.columns)
    assert "temperature_c" in driven


def test_units_are_those_of_the_column():
    """Coefficients are per unit of the condition, an unknown unit per one of the column."""
    at = bare(focus_mm=NOISE[0], yoke_temp_c=NOISE[1], strain=NOISE[2], tower_wind_m_s=NOISE[3])
    units = {one.driver: one.coefficients[0].unit for one in CATALOGUE["driven_term"].variants(at)}

    assert units == {
        "focus_mm": "arcsec/mm",
        "yoke_temp_c": "arcsec/K",
        "strain": "arcsec/strain",
        "tower_wind_m_s": "arcsec/(m/s)",
    }


def test_time_of_day_and_sun_go_with_the_hour():
    """What drives a member is known by its column, or as the hour."""
    follows = {one.variant: one.driver for one in CATALOGUE["driven_term"].variants(AT)}

    assert follows["tilt follows temperature_c"] == "temperature_c"
    assert follows["tilt follows wind_speed_m_s"] == "wind_speed_m_s"
    assert follows["tilt follows the time of day"] == THE_HOUR
    assert follows["tilt follows sun_el_deg"] == THE_HOUR


def settling(at):
    """Return what a session begins with and loses."""
    return [one for one in CATALOGUE["driven_term"].variants(at) if "beginning" in one.variant]


def test_what_a_session_begins_with_settles_in_several_times():
    """Of each term, in sessions or nights; where there is one only it is a drift."""
    found = settling(AT)
    names = AT.columns["session"]
    alone = AT.take(names == names[0])
    since = AT.columns["time"] - [AT.columns["time"][names == one].min() for one in names]

    assert {one.variant.split(" follows")[0] for one in found} == {
        *("tilt", "sag_cosine", "elevation_zero", "collimation"),
    }
    assert [one.member["settles_h"] for one in found] == 4 * [0.5] + 4 * [1.0] + 4 * [2.0]
    for one in found:
        if one.member["term"] == "elevation_zero":
            died = np.exp(-since / one.member["settles_h"] / 3600)
            np.testing.assert_allclose(one.columns(AT)[1][:, 0], died)
    assert settling(alone) == []
    assert [one.variant for one in settling(without(AT, "session"))] == [
        one.variant for one in found
    ]


def test_what_settles_comes_back_from_a_file():
    """With when the sessions began; a session that it does not know begins with its first row."""
    one = settling(AT)[0]
    late = AT.take(np.flatnonzero(AT.columns["session"] == AT.columns["session"][-1])[3:])
    again = one.make(**one.member)
    unknown = one.make(**{**one.member, "sessions": [], "spans_s": []})

    assert again.variant == one.variant
    assert one.looks_back
    np.testing.assert_array_equal(again.columns(late)[0], one.columns(late)[0])
    assert np.abs(unknown.columns(late)[1]).max() > np.abs(one.columns(late)[1]).max()


def test_sun_is_computed_where_it_was_not_recorded():
    """The Sun's height comes from the time and the site."""
    at = without(AT, "sun_el_deg")

    assert "sun_el_deg" in names(at)
    assert "sun_el_deg" not in names(without(at, "longitude_deg"))


def test_every_member_is_paid_for():
    """The price of the best member counts all that were tried; bookkeeping is not among them."""
    nothing = np.full(120, np.nan)
    given = Recordings(
        replaced(AT, sheet=NOISE[0]),
        *(np.zeros(120), np.zeros(120), nothing, nothing, np.arange(120), "a.csv"),
        meta={"bookkeeping": "sheet temperature_c"},
    )
    _, every, _ = design(given, stack(given))
    found = [one for one in every if one.effect.id == "driven_term"]
    tried = {one.effect.variant for one in found}

    assert {one.choices for one in found} == {len(found)}
    assert not any("sheet" in name or "temperature" in name for name in tried)


def test_noise_may_hold_what_begins_anew_with_each_session():
    """As it holds nights and drifts: of all that lasts, that alone is not kept out of it."""
    nothing = np.full(120, np.nan)
    given = Recordings(AT, *np.zeros((2, 120)), nothing, nothing, np.arange(120), "a.csv")
    problem = prepare(given, load("altaz"))
    lasting = [one for one in problem.candidates if not confounded(problem, one.effect)]
    anew = [one for one in lasting if one.effect.begins_anew]
    wide, own = (problem.shown_by(some)[1].shape[1] for some in (lasting, anew))

    assert {one.effect.member["follows"] for one in anew} == {"the beginning of the session"}
    assert problem.possible[1].shape[1] == wide - own
