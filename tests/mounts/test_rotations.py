"""Sky to axes and back: exact, against ERFA and astropy, and defined where an angle is not."""

import erfa
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import AltAz, Angle, EarthLocation, HADec, SkyCoord
from mounts.steel import angles, steel

from pyport.angles import DEG, wrap
from pyport.mounts import ALTAZ, KINDS
from pyport.mounts.instrument import k_mirror, k_mirror_still, nasmyth

LATITUDES = (53.1, -33.9, 0.0, 90.0, -90.0)
TURNED = [one for one in KINDS.values() if one is not ALTAZ]
EQUATORIAL = KINDS["equatorial"]


def sky(n=2000, seed=3):
    """Return directions all over the sphere."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-np.pi, np.pi, n), np.arcsin(rng.uniform(-1, 1, n))


@pytest.mark.parametrize("latitude_deg", LATITUDES)
@pytest.mark.parametrize("mount", TURNED, ids=lambda one: one.id)
def test_there_and_back(mount, latitude_deg):
    """From the sky to the axes and back: 1e-12, whichever way the mount has turned over."""
    az, el = sky()
    over = np.arange(len(az)) % 2 == 0
    there = mount.angles(az, el, latitude_deg * DEG, over)
    back = mount.sky(*there, latitude_deg * DEG)

    assert np.abs(wrap(back[0] - az) * np.cos(el)).max() < 1e-12
    assert np.abs(back[1] - el).max() < 1e-12
    assert (np.abs(there[1]) > np.pi / 2)[over].all()


@pytest.mark.parametrize("latitude_deg", LATITUDES)
def test_equatorial_is_erfas(latitude_deg):
    """Hour angle and declination are those of ERFA."""
    az, el = sky()
    ours = EQUATORIAL.angles(az, el, latitude_deg * DEG)
    hour_angle, dec = erfa.ae2hd(az, el, latitude_deg * DEG)

    assert np.abs(wrap(ours[0] - hour_angle) * np.cos(dec)).max() < 1e-12
    assert np.abs(ours[1] - dec).max() < 1e-12


def test_equatorial_is_astropys():
    """Hour angle and declination are those of astropy's frame, about the true pole."""
    az, el = sky(200)
    place = EarthLocation.from_geodetic(18.5 * u.deg, 53.1 * u.deg)
    frame = {"obstime": "2024-03-01T20:00:00", "location": place}
    seen = SkyCoord(AltAz(az=az * u.rad, alt=el * u.rad, **frame)).transform_to(HADec(**frame))
    ours = EQUATORIAL.angles(az, el, 53.1 * DEG)

    assert np.abs(wrap(ours[0] - seen.ha.rad) * np.cos(seen.dec.rad)).max() < 1e-12
    assert np.abs(ours[1] - seen.dec.rad).max() < 1e-12
    assert Angle(ours[1], u.rad).is_within_bounds(-90 * u.deg, 90 * u.deg)


@pytest.mark.parametrize("mount", ["equatorial", "xy-ns", "xy-ew"])
@pytest.mark.parametrize("latitude_deg", [53.1, -33.9])
def test_axes_are_those_of_steel(mount, latitude_deg):
    """Angles and the turn of the offsets are those of a mount built from rotations of vectors."""
    az, el = sky()
    axes = steel(mount, latitude_deg * DEG)
    vector = np.stack([np.cos(el) * np.sin(az), np.cos(el) * np.cos(az), np.sin(el)], axis=1)
    first, second = KINDS[mount].angles(az, el, latitude_deg * DEG)
    true = angles(axes, vector)

    assert np.abs(wrap(first - true[0]) * np.cos(second)).max() < 1e-12
    assert np.abs(np.sin(second) - np.sin(true[1])).max() < 1e-12

    turn = KINDS[mount].turn(az, el, latitude_deg * DEG)
    step = 1e-7
    for n, (d_az, d_el) in enumerate(((step / np.cos(el), 0), (0, step))):
        moved = KINDS[mount].angles(az + d_az, el + d_el, latitude_deg * DEG)
        across = wrap(moved[0] - first) * np.cos(second) / step
        well_off = (np.cos(second) > 0.01) & (np.cos(el) > 0.01)
        assert np.abs(across - turn[0, n])[well_off].max() < 1e-4
        assert np.abs((moved[1] - second) / step - turn[1, n])[well_off].max() < 1e-4
    unit = np.einsum("abn,cbn->nac", turn, turn)
    assert np.abs(unit - np.eye(2)).max() < 1e-12


@pytest.mark.parametrize(
    ("mount", "az_deg", "el_deg"),
    [
        ("equatorial", 0.0, 53.1),  # the pole
        ("xy-ns", 0.0, 0.0),  # the keyholes
        ("xy-ns", 180.0, 0.0),
        ("xy-ew", 90.0, 0.0),
        ("xy-ew", -90.0, 0.0),
    ],
)
def test_on_the_first_axis(mount, az_deg, el_deg):
    """Where any first angle would do it is zero, the turn still one, and the way back exact."""
    az, el = np.array([az_deg * DEG]), np.array([el_deg * DEG])
    first, second = KINDS[mount].angles(az, el, 53.1 * DEG)
    turn = KINDS[mount].turn(az, el, 53.1 * DEG)[:, :, 0]

    assert first[0] == 0.0
    assert abs(abs(second[0]) - np.pi / 2) < 1e-12
    assert np.abs(turn @ turn.T - np.eye(2)).max() < 1e-12
    assert (
        np.abs(
            np.array(KINDS[mount].sky(first, second, 53.1 * DEG)).ravel() % np.pi
            - np.array([az[0], el[0]]) % np.pi
        ).max()
        < 1e-12
    )
    assert not KINDS[mount].reaches(first, second)[0]


@pytest.mark.parametrize("mount", TURNED, ids=lambda one: one.id)
def test_the_zenith_is_no_singularity(mount):
    """At the zenith azimuth means nothing: the axes point the same way for any."""
    az = np.radians(np.arange(0, 360, 30.0))
    first, second = mount.angles(az, np.full(len(az), np.pi / 2), 53.1 * DEG)

    assert np.ptp(first) < 1e-12
    assert np.ptp(second) < 1e-12


def test_a_german_mount_turns_over():
    """Beyond the pole the first axis is half a turn on, within one turn, and the second beyond."""
    az, el = sky()
    mount = KINDS["german"]
    first, second = mount.angles(az, el, 0.9)
    over = np.ones(len(az), bool)
    other, beyond = mount.angles(az, el, 0.9, over)

    assert np.abs(np.abs(other - first) - np.pi).max() < 1e-12
    assert np.abs(other).max() <= np.pi
    assert np.array_equal(beyond, np.pi - second)


def test_a_platform_and_a_k_mirror_hold_the_field_still():
    """Where the K-mirror is told to stand the field stands; opposite platforms differ by 2 E."""
    field, el = np.linspace(-3, 3, 13), np.linspace(0.2, 1.4, 13)

    assert np.abs(k_mirror(field, k_mirror_still(field))).max() < 1e-15
    assert np.allclose(nasmyth(field, el, 1) - nasmyth(field, el, -1), 2 * el)
