"""Sessions of other mounts: drawn by the examiner's rotations, judged by what the program says."""

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.examiner.mounts import examine
from pyport.examiner.mounts.examine import EMPTY, ONE, TWO, UNKNOWN, Case
from pyport.examiner.worlds.kinds import STANDS, make_case
from pyport.examiner.worlds.mount import FRAMES, Mount, Stand

PHI = 0.8


@pytest.mark.parametrize("kind", FRAMES)
def test_a_faultless_mount_reads_what_is_true(kind):
    """No flaw, no offset, on either side of a pier; zeros read as they are."""
    rng = np.random.default_rng(2)
    az, el = rng.uniform(0, 2 * np.pi, 200), rng.uniform(0.2, 1.4, 200)
    kept = np.cos(Stand(kind, PHI).angles(az, el)[1]) > 0.2
    az, el = az[kept], el[kept]
    stand = Stand(kind, PHI, np.where(rng.random(len(az)) < 0.5, -1.0, 1.0))
    zeros = Mount(azimuth_zero=40 * ARCSEC, elevation_zero=30 * ARCSEC)

    assert np.abs(stand.shown(Mount(), az, el)).max() < 1e-13
    x, y = stand.shown(zeros, az, el)
    assert np.allclose(x / ARCSEC, 40 * np.cos(stand.angles(az, el)[1]))
    assert np.allclose(y / ARCSEC, 30 * stand.side)


@pytest.mark.parametrize("kind", FRAMES)
def test_a_tube_hangs_down_on_every_mount(kind):
    """The offset on the sky is the droop at that elevation, along the vertical."""
    az, el = np.array([0.3, 1.9, 4.0]), np.array([0.5, 0.7, 0.6])
    x, y = Stand(kind, PHI).shown(Mount(sag_cosine=20 * ARCSEC), az, el)

    assert np.allclose(np.hypot(x, y) / ARCSEC, 20 * np.cos(el), atol=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("mount", examine.MOUNTS)
def test_a_case_is_the_same_every_time_and_another_is_not(mount):
    """Drawn from its number; what is hidden is called as the program calls it on this mount."""
    first, again, other = (Case(mount, ONE, n, 1).spec().make(4) for n in (0, 0, 1))
    along = next(name for name in first.columns if name in ("d_dec_deg", "d_y_deg"))

    assert np.array_equal(first.columns[along], again.columns[along], equal_nan=True)
    assert first.truth["effects"] == again.truth["effects"]
    assert first.truth["effects"] != other.truth["effects"]
    for part, count in ((EMPTY, 0), (ONE, 1), (TWO, 2), (UNKNOWN, 1)):
        made = Case(mount, part, 0, 1).spec().make(4)
        assert len(made.truth["effects"]) == count


@pytest.mark.parametrize(("mount", "effect"), [(m, e) for m, some in STANDS.items() for e in some])
def test_every_cause_of_a_mount_has_its_size_and_name(mount, effect):
    """Half of the noise beside the classical terms; no name of azimuth on another axis."""
    case = make_case("one", 3, effect=effect, mount=mount, rows=120, noise="white")
    (cause,) = case.truth["effects"]

    assert max(cause["rho_xel"], cause["rho_el"]) == pytest.approx(0.5, rel=0.02)
    assert "azimuth" not in cause["effect"]
    assert case.header["mount"] == mount


def outcome(part, hidden=(), found=(), wrong=(), *, claimed=True):
    """Return what came out of a case."""
    told = [{"effect": one[0], "variant": "", "verdict": "named", "class": one} for one in found]
    known = {"mount": "german", "part": part, "hidden": list(hidden), "findings": told}
    right = tuple(any(name in one for one in found) for name in hidden)
    return known | {"claimed": claimed, "found": right, "wrong": wrong}


def test_what_is_right():
    """Silence, the name, or a class of few that has it; no name where nobody knows one."""
    polar = ["polar_axis"]

    assert examine.right(outcome(EMPTY, claimed=False))
    assert not examine.right(outcome(EMPTY, wrong=("polar_axis",)))
    assert examine.right(outcome(ONE, polar, [polar]))
    assert examine.right(outcome(ONE, polar, [["epoch_tilt", "polar_axis"]]))
    assert not examine.right(outcome(TWO, ["polar_axis", "pier_flip"], [polar]))
    assert examine.right(outcome(UNKNOWN, [UNKNOWN], [[UNKNOWN]]))
    assert not examine.right(outcome(UNKNOWN, [UNKNOWN], [polar], ("polar_axis",)))
    assert not examine.right(outcome(EMPTY, claimed=False) | {"refused": "no"})
    missed = examine.text([outcome(ONE, polar, [["sag_cosine"]])])
    assert "german, polar_axis: found sag_cosine" in missed


def test_what_is_one_name():
    """The name alone; no other beside it."""
    assert examine.sharp(outcome(ONE, ["polar_axis"], [["polar_axis"]]))
    assert not examine.sharp(outcome(ONE, ["polar_axis"], [["epoch_tilt", "polar_axis"]]))


@pytest.mark.slow
def test_a_case_is_put_to_the_program():
    """An empty German session stays silent, a pier flip is called by its name."""
    silent = examine.examine(Case("german", EMPTY, 0, 1))
    flip = examine.examine(Case("german", ONE, 7, 1))

    assert examine.right(silent)
    assert flip["hidden"] == ["pier_flip"]
    assert examine.right(flip)
