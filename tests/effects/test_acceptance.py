"""What every effect of the catalogue must pass: sign, size, first order, units, missing columns."""

import re

import numpy as np
import pytest
from effects import heavens, mechanics
from effects.cases import AT
from effects.sky import INSIDE, without

from pyport.angles import ARCSEC
from pyport.effects import CATALOGUE, Circumstances, MissingColumn

CASES = [*mechanics.CASES, *heavens.CASES]
IDS = [str(case) for case in CASES]
#: What sixteen digits leave of an offset between two directions [rad].
ROUNDING = 1e-13
PHYSICAL = {name: effect for name, effect in CATALOGUE.items() if effect.physical}


def member(case):
    """Return the member of the family that a case is about."""
    variants = CATALOGUE[case.effect].variants(case.at)
    return next(one for one in variants if case.variant in ("", one.variant))


def place(effect):
    """Return circumstances in which an effect can be seen: those of its case."""
    return next((case.at for case in CASES if case.effect == effect.id), AT)


def predicted(case, size):
    """Return the offsets that the catalogue gives for a case's amounts, in reported units."""
    effect = member(case)
    values = [a * c.scale for a, c in zip(case.amounts, effect.coefficients, strict=True)]
    x, y = effect.columns(case.at)
    return size * np.concatenate([x @ values, y @ values])


def missed(case, size):
    """Return by how much the catalogue misses the truth at some amplitude [rad], both axes."""
    wrong = predicted(case, size) - np.concatenate(case.offsets(size))
    if case.effect == "drift":  # what does not change is no drift but a zero
        wrong -= np.repeat([wrong[: len(AT)].mean(), wrong[len(AT) :].mean()], len(AT))
    return wrong


def first_order(case):
    """Return what of the miss is linear in the amplitude; all of it where nature fixes that."""
    return 4 * missed(case, 0.5) - missed(case, 1.0) if case.scales else missed(case, 1.0)


def largest(values):
    """Return the size of the largest offset [rad]."""
    return np.abs(values).max()


@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_sign_and_size(case):
    """Coefficients in reported units give the offsets of an independent calculation."""
    true = largest(np.concatenate(case.offsets(1.0)))

    assert true > 0.01 * ARCSEC
    assert largest(first_order(case)) <= case.tolerance * true


@pytest.mark.parametrize("case", [case for case in CASES if case.scales], ids=str)
def test_first_order(case):
    """What is not linear is small, and falls with the square of the amplitude."""
    linear = first_order(case)
    half, whole = (largest(missed(case, size) - size * linear) for size in (0.5, 1.0))

    assert whole <= 0.05 * largest(np.concatenate(case.offsets(1.0)))
    assert half <= 0.26 * whole + ROUNDING


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.id)
def test_rows_stand_alone(effect):
    """A member that was made for some recordings says the same of a part of them.

    What looks back to earlier rows is excepted, and no other.
    """
    at = place(effect)
    later = np.arange(len(at)) > 0.6 * len(at)
    some = later & (at.el > np.median(at.el))

    for one in [each for each in effect.variants(at) if not each.looks_back]:
        whole, part = one.columns(at), one.columns(at.take(some))
        for axis in (0, 1):
            np.testing.assert_allclose(part[axis], whole[axis][some], rtol=0, atol=1e-9)


def test_every_physical_effect_has_a_case():
    """No effect of the catalogue goes without an independent calculation."""
    assert {case.effect for case in CASES} == set(PHYSICAL)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.id)
def test_shape_of_the_basis(effect):
    """Every member gives a finite column in both axes for each coefficient."""
    at = place(effect)
    for one in effect.variants(at):
        x, y = one.columns(at)

        assert x.shape == y.shape == (len(at), len(one.coefficients))
        assert np.isfinite(x).all()
        assert np.isfinite(y).all()
        assert one.id == effect.id


def alternatives(need):
    """Return the columns of a need, those that can stand for each other apart."""
    return [re.findall(r"\b[a-z][a-z_0-9]*\b", one) for one in need.split(" or ")]


NEEDS = [(effect, need) for effect in CATALOGUE.values() for need in effect.needs]


@pytest.mark.parametrize(("effect", "need"), NEEDS, ids=lambda one: getattr(one, "id", one))
def test_missing_column_is_named(effect, need):
    """Without what it needs an effect is not testable, and says which column is missing."""
    at = place(effect)
    wanted = alternatives(need)
    for one in wanted:
        at = without(at, one[0])

    with pytest.raises(MissingColumn) as lack:
        [one.columns(at) for one in effect.variants(at)]

    assert lack.value.column in need
    assert effect.missing(at) == lack.value.column


def test_nothing_is_missing_from_a_full_campaign():
    """With every column of the contract only planets, and a second turn, may be missing."""
    lacking = {name for name, effect in CATALOGUE.items() if effect.missing(AT)}

    assert lacking == {"parallax", "azimuth_turns"}


def test_needs_are_complete():
    """An effect needs no column beside those that it says it needs."""
    for effect in CATALOGUE.values():
        needed = {
            INSIDE.get(name, name)
            for need in effect.needs
            for one in alternatives(need)
            for name in one
        }
        at = place(effect)
        for name in set(at.columns) - needed:
            if name == "source" and effect.id == "parallax":
                continue
            at = without(at, name)

        assert effect.missing(at) is None, effect.id


def test_the_sun_heats_by_its_height_and_never_from_below():
    """A lean away from a Sun in the north, at azimuth zero: by what it heats, in elevation."""
    sun_el = np.array([0.5, -0.5])
    at = Circumstances(
        np.zeros(2), np.full(2, 0.7), None, {"sun_az": np.zeros(2), "sun_el": sun_el}
    )
    family = CATALOGUE["thermal_tilt"].variants(at)
    (effect,) = [one for one in family if one.variant == "as the Sun is high"]

    np.testing.assert_allclose(np.abs(effect.columns(at)[1][:, 0]), [np.sin(0.5), 0.0])
