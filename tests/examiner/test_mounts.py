"""Sessions of other mounts: drawn by the examiner's rotations, judged by what the program says."""

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.examiner.mounts import examine, worlds
from pyport.examiner.mounts.twins import FRAME, Flaws, axes_of, offsets
from pyport.examiner.mounts.worlds import EMPTY, ONE, TWO, UNKNOWN, Case
from pyport.examiner.worlds.mount import Mount

PHI = 0.8


@pytest.mark.parametrize("kind", FRAME)
def test_a_faultless_mount_reads_what_is_true(kind):
    """No flaw, no offset, on either side of a pier; zeros read as they are."""
    rng = np.random.default_rng(2)
    az, el = rng.uniform(0, 2 * np.pi, 200), rng.uniform(0.2, 1.4, 200)
    kept = np.cos(axes_of(kind, PHI, az, el)[1]) > 0.2
    at = az[kept], el[kept]
    side = np.where(rng.random(kept.sum()) < 0.5, -1.0, 1.0)
    zeros = Flaws(Mount(azimuth_zero=40 * ARCSEC, elevation_zero=30 * ARCSEC))

    assert np.abs(offsets(kind, PHI, at, side, Flaws())).max() < 1e-13
    shown = offsets(kind, PHI, at, side, zeros)
    cosine = np.cos(axes_of(kind, PHI, *at)[1])
    assert np.allclose(shown[:, 0] / ARCSEC, 40 * cosine)
    assert np.allclose(shown[:, 1] / ARCSEC, 30 * side)


@pytest.mark.parametrize("mount", examine.MOUNTS)
def test_a_case_is_the_same_every_time_and_another_is_not(mount):
    """Drawn from its number; what is hidden is called as the program calls it on this mount."""
    first, again, other = (worlds.draw(Case(mount, ONE, number, 1)) for number in (0, 0, 1))
    along = next(name for name in first.table if name in ("d_dec_arcsec", "d_y_arcsec"))

    assert np.array_equal(first.table[along], again.table[along])
    assert first.hidden == again.hidden
    assert len(first.hidden) == 1
    assert not np.array_equal(first.table[along][:50], other.table[along][:50])
    assert worlds.draw(Case(mount, EMPTY, 0, 1)).hidden == ()
    assert len(worlds.draw(Case(mount, TWO, 0, 1)).hidden) == 2
    assert worlds.draw(Case(mount, UNKNOWN, 0, 1)).hidden == (UNKNOWN,)


def outcome(part, hidden, *found):
    """Return what came out of a case: effect, verdict and class of each finding."""
    told = [{"effect": e, "variant": "", "verdict": v, "class": c} for e, v, c in found]
    known = {"mount": "german", "part": part, "hidden": list(hidden), "findings": told}
    return known | {"twins": {"polar_axis": ["epoch_tilt"]}}


def test_what_is_right():
    """Silence, the name, or a class of few that has it; no name where nobody knows one."""
    polar = ("polar_axis", "named", ["polar_axis"])
    wide = ("sag_cosine", "ambiguous", ["sag_cosine", "polar_axis", *"abcde"])
    few = ("epoch_tilt", "ambiguous", ["epoch_tilt", "polar_axis"])

    assert examine.right(outcome(EMPTY, ()))
    assert not examine.right(outcome(EMPTY, (), polar))
    assert examine.right(outcome(ONE, ["polar_axis"], polar))
    assert examine.right(outcome(ONE, ["polar_axis"], few))
    assert not examine.right(outcome(ONE, ["polar_axis"], wide))
    assert not examine.right(outcome(TWO, ["polar_axis", "pier_flip"], polar))
    assert examine.right(outcome(UNKNOWN, [UNKNOWN], ("unknown", "unknown", ["unknown"])))
    assert not examine.right(outcome(UNKNOWN, [UNKNOWN], polar))
    assert not examine.right(outcome(EMPTY, ()) | {"refused": "no"})
    assert "german, polar_axis: found sag_cosine" in examine.text(
        [outcome(ONE, ["polar_axis"], wide)]
    )


def test_what_is_one_name():
    """The name alone, or with what nobody could tell from it; no other name beside it."""
    for members, alone, twins in (
        (["polar_axis"], True, True),
        (["epoch_tilt", "polar_axis"], False, True),
        (["polar_axis", "sag_cosine"], False, False),
        (["epoch_tilt"], False, False),
    ):
        one = outcome(ONE, ["polar_axis"], (members[0], "", members))
        assert examine.sharp(one, twins=False) == alone
        assert examine.sharp(one) == twins


@pytest.mark.parametrize(
    ("mount", "number", "hidden", "twins"),
    [
        ("xy-ns", 1, "sag_cosine", {"x_scale", "x_eccentricity"}),
        ("german", 1, "sag_cosine", set()),
    ],
)
def test_twins_are_what_rotations_leave_alike(mount, number, hidden, twins):
    """On an X-Y mount a tube that hangs is the scale of X beside that of Y; elsewhere it is not."""
    world = worlds.draw(Case(mount, ONE, number, 1))

    assert world.hidden == (hidden,)
    assert set(world.twins[hidden]) == twins


@pytest.mark.slow
def test_a_case_is_put_to_the_program():
    """An empty German session stays silent, a pier flip is called by its name."""
    silent = examine.examine(Case("german", EMPTY, 0, 1))
    flip = examine.examine(Case("german", ONE, 2, 1))

    assert examine.right(silent)
    assert flip["hidden"] == ["pier_flip"]
    assert examine.right(flip)
