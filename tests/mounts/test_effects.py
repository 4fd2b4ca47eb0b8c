"""What effects do on a mount, beside one built from rotations of vectors."""

import dataclasses

import numpy as np
import pytest
from mounts.steel import offsets, steel

from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances, MissingColumn, Site, catalogue, known
from pyport.models.model import Model, Term
from pyport.mounts import KINDS

LATITUDES = (53.1, -33.9)
BUILT = {"fork": "equatorial", "german": "equatorial", "horseshoe": "equatorial"}
SIZE = 20 * ARCSEC
ZEROS = ("azimuth_zero", "elevation_zero")


def pointings(mount, latitude_deg, n=100):
    """Return directions over the sky, on both sides of a pier, away from the first axis."""
    rng = np.random.default_rng(5)
    az, el = rng.uniform(-np.pi, np.pi, 4 * n), np.arcsin(rng.uniform(0.2, 0.99, 4 * n))
    site = Site(latitude_deg * DEG, 0.3)
    second = KINDS[mount].angles(az, el, site.latitude)[1]
    kept = np.flatnonzero(np.cos(second) > 0.2)[:n]
    side = np.where(rng.random(n) < 0.5, "west", "east")
    columns = {"pier_side": side} if KINDS[mount].turns_over else {}
    return Circumstances(az[kept], el[kept], site, columns, mount=KINDS[mount])


def waving(a, d):
    """Return harmonics of both encoders."""
    return SIZE * (np.sin(3 * a) - 0.5 * np.cos(3 * a)), SIZE * 0.7 * np.sin(2 * d)


#: What is wrong with the steel -> ids on an alt-azimuth mount, and their coefficients.
FLAWS = {
    "zeros": (
        {"read": lambda a, d: (SIZE + 0 * a, -0.5 * SIZE + 0 * d)},
        {"azimuth_zero": (1.0,), "elevation_zero": (-0.5,)},
    ),
    "collimation": ({"collimation": SIZE}, {"collimation": (1.0,)}),
    "skew": ({"skew": SIZE}, {"skew": (1.0,)}),
    "lean": ({"lean": (SIZE, -0.6 * SIZE)}, {"tilt": (1.0, -0.6)}),
    "droop": ({"droop": SIZE}, {"sag_cosine": (1.0,)}),
    "scales": (
        {"read": lambda a, d: (3e-5 * a, -5e-5 * d)},
        {"azimuth_scale": (3e-5 / SIZE,), "elevation_scale": (-5e-5 / SIZE,)},
    ),
    "harmonics": (
        {"read": waving},
        {
            "azimuth_harmonics k = 3": (1.0, -0.5),
            "elevation_encoder_harmonics k = 2": (0.7, 0.0),
        },
    ),
}
#: The same for equatorial mounts alone, which bend in ways of their own.
POLAR = {
    "fork": ("fork", lambda cosine: ({"fork": SIZE / cosine}, {"fork_flexure": (1.0,)})),
    "tube end": ("german", lambda _: ({"tube_end": SIZE}, {"declination_axis_flexure": (1.0,)})),
}
CASES = [
    (mount, latitude, name, *FLAWS[name])
    for mount in KINDS
    for latitude in LATITUDES
    for name in FLAWS
    # over a pole the reading of a first axis jumps by a turn, which a scale shows
    if not (name == "scales" and mount == "german")
] + [
    (mount, latitude, name, *make(np.cos(latitude * DEG)))
    for name, (mount, make) in POLAR.items()
    for latitude in LATITUDES
]


def member(identity, at):
    """Return the effect of an id, in the words of the mount, and of `id variant` its member."""
    name, _, variant = identity.partition(" ")
    found = next(one for one in catalogue(at.mount).values() if name in (one.of, one.id))
    if not variant:
        return found
    k = int(variant.rpartition(" ")[2])
    return found.make(k=k)


@pytest.mark.parametrize(
    ("mount", "latitude_deg", "name", "flaws", "amounts"),
    CASES,
    ids=[f"{one[0]} {one[1]} {one[2]}" for one in CASES],
)
def test_sign_and_size(mount, latitude_deg, name, flaws, amounts):
    """Every term is what the rotations make of its flaw, to first order, on both sides."""
    at = pointings(mount, latitude_deg)
    over = at.side == -1.0 if at.mount.turns_over else None
    axes = steel(BUILT.get(mount, mount), at.site.latitude)
    true = np.concatenate(offsets(axes, at.az, at.el, flaws, over))
    told = np.zeros_like(true)
    for identity, values in amounts.items():
        both = np.concatenate(member(identity, at).columns(at))
        told += SIZE * both @ np.array(values)

    assert np.abs(true).max() > 0.3 * SIZE
    assert np.abs(told - true).max() < 2e-3 * np.abs(true).max(), name


@pytest.mark.parametrize("latitude_deg", LATITUDES)
@pytest.mark.parametrize("mount", [one for one in KINDS if one != "altaz"])
def test_the_sky_comes_through_the_mount(mount, latitude_deg):
    """Refraction, sag, the clock: along the axes they are what a moved direction makes of them."""
    at = pointings(mount, latitude_deg)
    flat = dataclasses.replace(at, mount=KINDS["altaz"])
    axes = steel(BUILT.get(mount, mount), at.site.latitude)
    for identity in ("refraction", "sag_cosine", "sag_sine", "clock", "diurnal_aberration"):
        effect = known(identity)
        x, y = (SIZE * one[:, 0] for one in effect.columns(flat))
        there = offsets(axes, at.az + x / np.cos(at.el), at.el + y, {})
        assert np.abs(np.concatenate(there)).max() < 1e-9
        moved = KINDS[mount].angles(at.az + x / np.cos(at.el), at.el + y, at.site.latitude)
        still = KINDS[mount].angles(at.az, at.el, at.site.latitude)
        turn = (moved[0] - still[0] + np.pi) % (2 * np.pi) - np.pi
        true = np.concatenate([turn * np.cos(still[1]), moved[1] - still[1]])
        told = SIZE * np.concatenate(effect.columns(at))[:, 0]

        assert np.abs(told - true).max() < 2e-3 * np.abs(true).max(), identity


def test_pier_flip_is_what_the_encoders_say():
    """Zeros that change as the mount turns over: opposite in H, one in D, as it is turned back."""
    at = pointings("german", 53.1)
    side = np.where(at.columns["pier_side"] == "west", -1.0, 1.0)
    jump = {"read": lambda a, d: (SIZE * side + 0 * a, 0.5 * SIZE * side + 0 * d)}
    axes = steel("equatorial", at.site.latitude)
    true = np.concatenate(offsets(axes, at.az, at.el, jump, side < 0))
    told = SIZE * np.concatenate(known("pier_flip").columns(at)) @ [1.0, 0.5]

    assert np.abs(told - true).max() < 1e-9


def test_a_flip_is_fitted_from_both_sides_and_applied_on_either():
    """On one side alone it is the zeros: it is not looked for there."""
    at = pointings("german", 53.1)
    east = at.take(at.columns["pier_side"] == "east")
    flip = catalogue(at.mount)["pier_flip"]

    np.testing.assert_array_equal(
        flip.columns(east)[0], flip.columns(at)[0][at.columns["pier_side"] == "east"]
    )
    assert [one.id for one in flip.variants(at)] == ["pier_flip"]
    with pytest.raises(MissingColumn, match="both sides of the pier"):
        flip.variants(east)


@pytest.mark.parametrize("mount", ["fork", "german", "xy-ns"])
def test_offsets_along_the_axes_are_offsets_on_the_sky(mount):
    """What moves both axes moves where the mount points to, in azimuth and elevation."""
    at = pointings(mount, -33.9)
    zeros = [one for one in catalogue(at.mount).values() if one.on_altaz in ZEROS]
    model = Model("zeros", tuple(Term(one, values=(SIZE,)) for one in zeros))
    x, y = model.offsets(at)
    across, along = model.offsets_on_sky(at)
    over = np.equal(at.side, -1.0)
    moved = at.mount.angles(at.az + across / np.cos(at.el), at.el + along, at.site.latitude, over)

    assert np.abs(np.hypot(x, y) - np.hypot(across, along)).max() < 1e-12
    turn = (moved[0] - at.axes.az + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(turn * at.onto_sky - x).max() < 1e-3 * SIZE
    assert np.abs((moved[1] - at.axes.el) * at.side - y).max() < 1e-3 * SIZE


def test_an_equatorial_drive_follows_with_one_axis():
    """The sky moves the hour angle, steadily, and no declination."""
    at = pointings("german", 53.1)
    effects = catalogue(at.mount)
    lag_x, lag_y = (
        np.concatenate(effects[f"servo_lag_{one}"].columns(at))
        for one in ("hour_angle", "declination")
    )
    second = at.mount.angles(at.az, at.el, at.site.latitude)[1]

    assert np.allclose(lag_x[: len(at), 0] / np.cos(second), lag_x[0, 0] / np.cos(second[0]))
    assert not lag_x[len(at) :].any()
    assert not lag_y.any()
