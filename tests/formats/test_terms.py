"""Words of other programs: names, shapes and signs."""

import itertools
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.angles import ARCSEC
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.formats.model_file import NAMES, WORDS, Entry, ModelFile, in_unit, translated
from pyport.models.terms import field_system, tpoint
from pyport.models.terms.shapes import Wave

AT = Circumstances(np.linspace(-3, 4, 60), 0.1 + np.linspace(0, 1.3, 60))

waves = st.builds(
    lambda f, of, k: f"{f}{of}{k if k > 1 else ''}",
    *map(st.sampled_from, ("SC", "AE", range(1, 10))),
)
harmonics = st.builds(
    lambda result, one, other: f"H{result}{one}{other}",
    st.sampled_from("AES"),
    waves,
    st.one_of(st.just(""), waves),
)
tpoint_names = st.one_of(st.sampled_from([*tpoint.NAMED, "TX10"]), harmonics)
arcsec = st.decimals(-5000, 5000, places=4)


@given(tpoint_names)
def test_a_shape_has_a_name_that_means_it(name):
    """What TPOINT calls a term's shape moves the telescope as the term does."""
    word = tpoint.word(name)
    ((shape, sign),) = word.parts
    other, other_sign = tpoint.name_of(shape)

    np.testing.assert_allclose(
        np.array(tpoint.word(other).columns(AT)) * sign * other_sign, word.columns(AT), atol=1e-14
    )


@pytest.mark.parametrize("name", [f"P{n}" for n in range(1, 24) if n not in {2, 10}])
def test_each_parameter_is_the_name_of_its_shape(name):
    """P1..P23 come back as themselves (P2 does nothing here, P10 is P8)."""
    ((shape, sign),) = field_system.word(name).parts

    assert field_system.name_of(shape) == (name, sign)


@pytest.mark.parametrize("name", sorted(set(field_system.UNITS) - field_system.UNPUBLISHED))
def test_ska_mid_has_the_signs_of_tpoint(name):
    """The names follow TPOINT's convention."""
    assert field_system.ska_mid_word(name) == tpoint.word(name)
    ((shape, sign),) = field_system.ska_mid_word(name).parts
    assert field_system.ska_mid_name_of(shape) == (name, sign)


@pytest.mark.parametrize(
    "name", ["", "P", "P0", "P01", "P31", "PX", "H", "HX", "HASA0", "ia", "HA"]
)
def test_other_names_are_no_words(name):
    """Nothing is guessed from a name that is none."""
    assert field_system.word(name) is None
    assert tpoint.word(name) is None


@given(st.dictionaries(tpoint_names, arcsec, min_size=1, max_size=6))
def test_tpoint_in_another_vocabulary_points_the_same(terms):
    """Through the Field System or katpoint and back, the offsets are what they were."""
    file = ModelFile("tpoint", tuple(Entry(n, v, "arcsec") for n, v in terms.items()))
    for vocabulary in ("field-system", "katpoint"):
        try:
            there = translated(file, vocabulary)
        except BadInput:
            continue
        back = translated(there, "tpoint")
        for other in (there, back):
            np.testing.assert_allclose(
                other.model("other").offsets(AT), file.model("own").offsets(AT), atol=1e-6 * ARCSEC
            )


@given(st.lists(st.tuples(st.integers(1, 23), st.decimals(-1, 1, places=10)), max_size=8))
def test_ten_decimals_of_a_degree_survive_tpoint(terms):
    """Degrees as the Field System prints them come back from arcseconds digit for digit."""
    named = {f"P{n}": value for n, value in terms if n not in {2, 9, 10, 12}}
    file = ModelFile("field-system", tuple(Entry(n, v, "deg") for n, v in named.items()))

    back = translated(translated(file, "tpoint"), "field-system")

    assert {e.name: e.value for e in back.entries} == named


@given(arcsec)
def test_arcseconds_survive_degrees(value):
    """Four decimals of an arcsecond, and more, come back from degrees."""
    assert in_unit(in_unit(value, "arcsec", "deg"), "deg", "arcsec") == value


def test_terms_that_mean_the_same_add_up():
    """TF and ECEC are one term of opposite signs; the sum has no sigma."""
    file = ModelFile(
        "tpoint",
        (
            Entry("TF", Decimal(36), "arcsec", Decimal(1)),
            Entry("ECEC", Decimal(-36), "arcsec", Decimal(1)),
        ),
    )

    (entry,) = translated(file, "field-system").entries

    assert (entry.name, entry.value, entry.sigma) == ("P8", Decimal("0.02"), None)


def test_a_term_without_counterpart_is_refused_by_name():
    """Nothing is lost in silence."""
    file = ModelFile("tpoint", tuple(Entry(n, Decimal(1), "arcsec") for n in ("IA", "HSCE3")))

    with pytest.raises(BadInput, match="no counterpart of HSCE3"):
        translated(file, "field-system")
    left = translated(file, "field-system", leave_out=True)
    assert [entry.name for entry in left.entries] == ["P1"]


def test_a_term_without_formula_may_only_be_zero():
    """SKA-Mid's own four, and the parameters that the Field System reserves."""
    zero, some = (ModelFile("ska-mid", (Entry("ABA", Decimal(v), "arcsec"),)) for v in (0, 1))

    assert zero.model("zero").terms == ()
    with pytest.raises(BadInput, match="ABA has no published formula"):
        some.model("some")


def test_every_vocabulary_names_what_it_knows():
    """The name of a shape is a word of that vocabulary, with this shape and sign."""
    everything = [*tpoint.NAMED, *(f"P{n}" for n in range(1, 31)), *field_system.UNITS]
    for vocabulary, name in itertools.product(WORDS, everything):
        word = WORDS[vocabulary](name)
        for shape, _ in word.parts if word else ():
            called, sign = NAMES[vocabulary](shape)
            assert WORDS[vocabulary](called).parts == ((shape, sign),)


def test_a_wave_of_azimuth_turns_with_its_zero():
    """180 deg - A instead of A, whatever the multiple."""
    turned = Circumstances(np.pi - AT.az, AT.el)
    for function, k in itertools.product("SC", range(1, 10)):
        wave = Wave(function, "A", k)
        np.testing.assert_allclose(wave(turned), tpoint.turned(wave) * wave(AT), atol=1e-12)
