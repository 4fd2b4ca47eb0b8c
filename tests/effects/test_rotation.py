"""What turns an image: which columns may, how far they must turn, and what is tried."""

import numpy as np
import pytest
from effects.sky import campaign, replaced, without

from pyport.angles import DEG
from pyport.effects import CATALOGUE, Circumstances, MissingColumn
from pyport.effects.telescope.rotation import LEAST_ARC, MOST_COLUMNS, angle_columns, arc

AT = campaign(60)
WAY_ROUND = np.linspace(-170, 170, 60)


def tried(at):
    """Return the names of the circles that are tried, less those of the parallactic angle."""
    names = (one.variant.removeprefix("phi = ") for one in CATALOGUE["rotator_circle"].variants(at))
    return [name for name in names if "parallactic" not in name]


@pytest.mark.parametrize("name", ["rotator_deg", "kmirror_angle_deg", "derot_rad", "pa_arcmin"])
def test_angles_of_any_unit_may_turn_the_image(name):
    """A column that nobody knows is a rotation when its unit is an angle."""
    assert name in angle_columns(replaced(AT, **{name: WAY_ROUND}))


@pytest.mark.parametrize(
    "name",
    [
        *("commanded_az_deg", "model_offset_arcsec", "sigma_fit_deg", "wind_dir_deg", "dome_deg"),
        *("beam_width_arcmin", "gal_lat_deg", "lst_h", "hour_angle", "temperature_c", "deg"),
    ],
)
def test_places_offsets_and_sizes_turn_nothing(name):
    """A direction, an offset, an error or a size in degrees is no rotation of the image."""
    assert name not in angle_columns(replaced(AT, **{name: WAY_ROUND}))


def test_text_and_blank_columns_turn_nothing():
    """Words are no angle, and half of the rows must have one."""
    words = replaced(AT, rotator_deg=np.full(60, "left"))
    blank = replaced(AT, rotator_deg=np.where(np.arange(60) % 3, np.nan, WAY_ROUND))

    assert angle_columns(words) == angle_columns(blank) == {}


def test_arc_is_counted_through_north():
    """From 350 to 20 deg an angle turned by 30; not at all where it stood still."""
    assert arc(np.radians([350.0, 5.0, 20.0])) == pytest.approx(30 * DEG)
    assert arc(np.radians([40.0, 40.0, np.nan])) == 0
    assert arc(np.radians(np.arange(0.0, 360, 10))) == pytest.approx(350 * DEG)


def test_image_must_turn_by_sixty_degrees():
    """A column of 61 deg shows a circle, one of 31 only one at twice its rate, of 29 none."""
    swings = {61: 4, 31: 2, 29: 0}
    for degrees, members in swings.items():
        at = replaced(AT, rotator_deg=np.linspace(0, degrees, 60))
        assert len(tried(at)) == members, degrees
    assert all("2 rotator_deg" in name for name in tried(replaced(AT, rotator_deg=WAY_ROUND / 11)))
    assert LEAST_ARC == 60 * DEG


def test_what_is_lacking_is_said():
    """Without an angle and a latitude there is nothing to turn; with a still one, no arc."""
    nowhere = without(without(AT, "rotator_deg"), "latitude_deg")
    still = replaced(nowhere, rotator_deg=np.full(60, 10.0))

    with pytest.raises(MissingColumn, match="rotator_deg or latitude_deg"):
        tried(nowhere)
    with pytest.raises(MissingColumn, match="60 deg of rotation"):
        tried(still)


def test_recorded_parallactic_angle_is_not_tried_twice():
    """A column that is the parallactic angle, whatever its zero and sign, stands for it."""
    hour_angle, dec = AT.columns["hour_angle"], AT.columns["dec"]
    lat = AT.site.latitude
    angle = np.arctan2(
        np.sin(hour_angle), np.tan(lat) * np.cos(dec) - np.sin(dec) * np.cos(hour_angle)
    )
    for recorded in (angle, np.pi / 2 - angle):
        members = CATALOGUE["rotator_circle"].variants(replaced(AT, position_rad=recorded))
        assert not any("parallactic" in one.variant for one in members)
        assert any("position_rad" in one.variant for one in members)


def test_columns_that_turn_furthest_are_tried():
    """Of many angles five are tried, so that the family stays within what a search can bear."""
    many = {f"angle{n}_deg": np.linspace(0, 60 + 30 * n, 60) for n in range(8)}
    names = tried(replaced(without(AT, "rotator_deg"), **many))

    assert {name.removeprefix("-").removeprefix("2 ") for name in names} == {
        f"angle{n}_deg" for n in range(8 - MOST_COLUMNS, 8)
    }


def test_both_platforms_are_tried_and_differ():
    """At the horizon both throw the beam alike; at the zenith to opposite sides."""
    right, left = CATALOGUE["nasmyth"].variants(AT)
    places = Circumstances(np.zeros(2), np.array([0.0, np.pi / 2]))
    one, other = (np.stack(member.columns(places)) for member in (right, left))

    np.testing.assert_allclose(one[:, 0], other[:, 0], atol=1e-15)
    np.testing.assert_allclose(one[:, 1], -other[:, 1], atol=1e-15)
