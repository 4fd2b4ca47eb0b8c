"""A model is asked for offsets, for where to drive, and back, in every form of a direction."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from astropy import units as u
from astropy.coordinates import AltAz, EarthLocation, SkyCoord
from astropy.table import QTable
from astropy.time import Time
from astropy.utils import iers
from diagnosis.made import recordings

import pyport
from pyport.angles import ARCSEC, DEG
from pyport.correction.kernel import kernel
from pyport.correction.use import PointingModel
from pyport.effects import CATALOGUE, Circumstances, Site
from pyport.effects.empirical.epochs import epoch_step
from pyport.effects.empirical.fields import field
from pyport.effects.telescope.structure import FreeEdge, curved_jump, jump_above
from pyport.effects.telescope.track import azimuth_track
from pyport.errors import BadInput
from pyport.files import sha256
from pyport.formats.models import load
from pyport.models.conditions import Completed
from pyport.models.model import Model, Term
from pyport.pointing import exact_offsets, printed
from pyport.pointing.one import exact_one

PLACE = EarthLocation.from_geodetic(18.56 * u.deg, 53.1 * u.deg, 130 * u.m)
WHEN = Time("2026-03-01T12:00:00")
BUMPS = field(
    {"kind": "elevation", "width_rad": 0.1, "centres_rad": [0.5, 0.6, 0.7]},
    [0, 0, 1, 1],
    [0, 1, 1, 2],
    [[1.0, 0.5], [0.3, -1.0], [0.2, 0.0], [0.0, 2.0]],
    "a smooth curve",
    "both axes: follows el_deg",
)
WARM = CATALOGUE["temperature"].make("the same everywhere", 5.0)


@pytest.fixture(autouse=True)
def _no_download(monkeypatch):
    """Keep astropy from asking the network for the Earth's orientation."""
    monkeypatch.setattr(iers.conf, "auto_download", False)


def model(*terms, base=None):
    """Return the classical terms with coefficients, and some more."""
    rng = np.random.default_rng(7)
    known = (load("altaz") if base is None else load(base)).terms
    own = [
        replace(term, values=tuple(rng.normal(0, 40 * ARCSEC, len(term.effect.coefficients))))
        for term in known
    ]
    more = [Term(effect, values=tuple(v * ARCSEC for v in values)) for effect, values in terms]
    whole = load("altaz" if base is None else base)
    return PointingModel(replace(whole, terms=(*own, *more)))


MODELS = {
    "classical": model(),
    "track": model((azimuth_track(3), (9, -4, 3, 2, 1, 5))),
    "jump": model((curved_jump((0.9, 0.1, 0.05, 0.0, 0.02)), (25,))),
    "free edge": model((jump_above(FreeEdge((-3.0, 0.0, 3.0), (0.5, 0.9, 0.6))), (25,))),
    "refraction": model((CATALOGUE["refraction"], (60,))),
    "rt32": model(base="rt32-exact"),
    "rt32, approximate": model(base="rt32-approximate"),
    "of one axis": model((jump_above(FreeEdge((0.1, 3.0), (0.4, 0.9)), axis="first"), (20,))),
    "wave of one axis": model((curved_jump((0.9, 0.1, 0.05, 0.0, 0.02), "first"), (20,))),
    "temperature": model((WARM, (0.3, 1.5))),
    "field": model((BUMPS, (9, -4))),
}


@pytest.mark.parametrize("name", MODELS)
def test_one_many_and_the_model_itself_agree(name):
    """The waves of a kernel are the terms they stand for, to the last digits of a double."""
    asked = MODELS[name]
    rng = np.random.default_rng(3)
    az, el = rng.uniform(-4, 4, 400), rng.uniform(-0.1, 1.7, 400)
    columns = {"temperature_c": np.full(400, 11.0)}
    truth = asked.model.offsets(Circumstances(az, el, None, columns))
    many = asked.at(Circumstances(az, el, None, columns))
    one = np.array(
        [asked.offsets_rad(a, e, temperature_c=11.0) for a, e in zip(az, el, strict=True)]
    )

    np.testing.assert_allclose(many, truth, rtol=0, atol=1e-15)
    np.testing.assert_allclose(one.T, truth, rtol=0, atol=1e-15)


def test_what_depends_on_directions_alone_is_waves():
    """Classical terms and a rail's need no array; a step or refraction is computed as it is."""
    assert not kernel(MODELS["track"].model, {}, None).rest
    assert len(kernel(MODELS["classical"].model, {}, None).waves) == 5
    assert len(kernel(MODELS["rt32"].model, {}, None).rest) == 1


def test_one_direction_of_the_exact_form():
    """The RT32's form by the C library's functions is that of arrays, plunge and horizon too."""
    rng = np.random.default_rng(1)
    az, alt = rng.uniform(-4.7, 4.7, 2000), rng.uniform(-0.1, 1.75, 2000)
    one = exact_one(printed())
    mine = np.array([one(a, h) for a, h in zip(az, alt, strict=True)]).T
    clear = np.abs(alt - np.pi / 2) > 1e-3

    np.testing.assert_allclose(
        mine[:, clear], np.array(exact_offsets(az, alt, printed()))[:, clear], rtol=0, atol=1e-12
    )


def test_forms_of_a_direction_give_one_answer():
    """Degrees, Quantities of any unit, AltAz, tables of three kinds: the same offsets."""
    asked = MODELS["temperature"]
    az, el, warm = np.array([10.0, 200.0]), np.array([30.0, 70.0]), np.array([5.0, 9.0])
    told = asked.offsets(az, el, temperature=warm)
    table = {"az_deg": az, "el_deg": el, "temperature_c": warm}
    frame = AltAz(az=az * u.deg, alt=el * u.deg, obstime=WHEN, location=PLACE)
    others = [
        asked.offsets(az * 60 * u.arcmin, np.radians(el) * u.rad, temperature_c=warm),
        asked.offsets(az * u.deg, el * u.deg, temperature=(warm + 273.15) * u.K),
        asked.offsets(frame, temperature=warm * u.deg_C),
        asked.offsets(SkyCoord(frame), temperature=warm),
        asked.offsets(table),
        asked.offsets(pd.DataFrame(table)),
        asked.offsets(QTable({"az": az * u.deg, "el": el * u.deg, "temperature_c": warm})),
        asked.offsets({"az_deg": az, "el_deg": el}, temperature=warm),
    ]

    assert told.d_xel.unit == u.arcsec
    for one in others:
        np.testing.assert_allclose(
            one.d_xel.to_value("rad"), told.d_xel.to_value("rad"), atol=1e-14
        )
        np.testing.assert_allclose(one.d_el.to_value("rad"), told.d_el.to_value("rad"), atol=1e-14)


def test_shapes_and_scalars():
    """Arrays broadcast, a scalar stays one."""
    asked = MODELS["classical"]

    assert asked.offsets(10.0, 45.0).d_el.shape == ()
    assert asked.offsets(np.zeros((3, 1)), np.full(4, 45.0)).d_el.shape == (3, 4)
    assert asked.correct(10.0, [45.0, 50.0])[0].shape == (2,)


def test_correct_drives_there_and_inverse_comes_back():
    """Where to drive is the direction plus the offsets; the mount's reading leads back."""
    asked = MODELS["temperature"]
    frame = AltAz(az=[10, 350] * u.deg, alt=[45, 88] * u.deg, obstime=WHEN, location=PLACE)
    driven = asked.correct(frame, temperature=3)
    x, y = asked.offsets(frame, temperature=3)

    assert isinstance(driven, AltAz)
    turn = ((driven.az - frame.az) * np.cos(frame.alt)).to_value("arcsec")
    np.testing.assert_allclose(turn, x.to_value("arcsec"), atol=1e-6)
    np.testing.assert_allclose((driven.alt - frame.alt).to_value("arcsec"), y.value, atol=1e-6)
    back = asked.inverse(driven, temperature=3)
    assert back.separation(frame).to_value("arcsec").max() < 1e-5


def test_a_sky_position_needs_time_and_place():
    """From ICRS by way of astropy; what was not given is named."""
    asked = MODELS["classical"]
    star = SkyCoord(120 * u.deg, 70 * u.deg)
    driven = asked.correct(star, time=WHEN, location=PLACE)
    plain = star.transform_to(AltAz(obstime=WHEN, location=PLACE))
    y = asked.offsets(plain).d_el

    assert (driven.alt - plain.alt).to_value("arcsec") == pytest.approx(y.value, abs=1e-3)
    at_home = PointingModel(replace(asked.model, site=Site(53.1 * DEG, 18.56 * DEG, 130.0)))
    assert at_home.correct(star, time=WHEN).separation(driven).to_value("arcsec") < 1e-3
    with pytest.raises(BadInput, match="need a time"):
        asked.correct(star)
    with pytest.raises(BadInput, match="give location=EarthLocation"):
        asked.correct(star, time=WHEN)


def test_time_of_every_kind():
    """A step in time is there after its moment; a bare number is refused."""
    step = epoch_step(1.0e9, CATALOGUE["epoch_offset"])
    asked = model((step, (0, 30)))
    later = [
        "2001-09-09T02:00:00Z",
        np.datetime64("2001-09-09T02:00"),
        Time(1.0e9 + 900, format="unix"),
    ]
    before = asked.offsets(10, 45, time="2001-09-09T01:00:00Z").d_el

    for one in later:
        jumped = asked.offsets(10, 45, time=one).d_el - before
        assert jumped.to_value("arcsec") == pytest.approx(30)
    with pytest.raises(BadInput, match="time is 5"):
        asked.offsets(10, 45, time=5.0)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({}, "needs temperature_c: give it by name"),
        ({"temperatur": 3}, "did you mean 'temperature'"),
        ({"temperature": 3 * u.m}, "temperature is in m, expected deg_C"),
        ({"temperature": "warm"}, "expected a number"),
        ({"temperature": [1, 2, 3], "pressure": [1, 2]}, "shapes that do not fit"),
    ],
)
def test_what_is_missing_or_wrong_is_named(told, said):
    """One line that says which condition, and what was expected."""
    with pytest.raises(BadInput, match=said):
        MODELS["temperature"].offsets(10, 45, **told)


def test_everything_that_is_missing_is_named_at_once():
    """Wind has a speed and a direction, and the step a time."""
    asked = model((CATALOGUE["wind_tilt"], (5,)), (epoch_step(1.0e9), (1, 1)))

    assert asked.needs() == ["wind_speed_m_s", "wind_az_deg", "time_utc"]
    with pytest.raises(BadInput, match="wind_speed_m_s, wind_az_deg, time_utc"):
        asked.offsets(10, 45)
    assert asked.offsets(10, 45, wind_speed=5 * u.km / u.h, wind_az=90, time=WHEN)


def test_each_antenna_has_its_coefficients():
    """By label, one or many; an antenna that the model does not know is refused."""
    antenna = np.array(["a", "b"])[np.arange(300) % 2]
    measured = recordings(
        300, 3, antenna=antenna, y=lambda at: 40.0 * (at.column("antenna") == "b")
    )
    asked = pyport.fit(measured).model
    one, other = (asked.offsets(10, 45, antenna=name).d_el.value for name in "ab")
    both = asked.offsets([10, 10], [45, 45], antenna=["a", "b"]).d_el.value

    assert other - one == pytest.approx(40, abs=3)
    np.testing.assert_allclose(both, [one, other])
    assert asked.needs() == ["antenna"]
    with pytest.raises(BadInput, match="no coefficients for antenna 'c'"):
        asked.offsets(10, 45, antenna="c")


def test_a_model_without_coefficients_is_refused():
    """`altaz` has terms and no numbers."""
    with pytest.raises(BadInput, match="no coefficients: fit it first"):
        pyport.load_model("altaz")
    assert pyport.load_model("rt32-3model").offsets(10, 45).d_el.value != 0
    assert PointingModel(Model("none", ())).offsets(10, 45).d_el.value == 0


def test_what_changed_at_a_row_changed_in_its_own_file_alone(tmp_path):
    """In any other file it is as it was after the last row, whatever the order of that one's."""
    own, other = tmp_path / "own.csv", tmp_path / "other.csv"
    own.write_text("az_deg,el_deg\n")
    other.write_text("az_deg, el_deg\n")
    step = epoch_step(9.5, of_order=True)
    made = {"sha256": sha256(own), "rows": 20}
    known = Completed(made, (), np.zeros((0, 0)))
    values = np.array([0.0, 30 * ARCSEC])
    model = PointingModel(Model("step", (Term(step, values=tuple(values)),), completed=known))
    level = np.full(20, 0.7)
    at = Circumstances(level, level, columns={"order": np.arange(20.0)})
    after = np.arange(20) > 9.5

    _, y = model.at(model.met(at, own))
    np.testing.assert_allclose(y, values[1] * after)
    _, y = model.at(model.met(at, other))
    np.testing.assert_allclose(y, values[1])
    _, y = model.at(model.met(at, tmp_path / "gone.csv"))
    np.testing.assert_allclose(y, values[1])
