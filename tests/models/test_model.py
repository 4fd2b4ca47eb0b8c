"""Models by name and from files."""

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.formats import models


def test_the_classical_model_has_seven_coefficients():
    """`altaz` is the classical seven terms, each antenna with its own."""
    model = models.load("altaz")

    assert sum(len(term.effect.coefficients) for term in model.terms) == 7
    assert {term.per for term in model.terms} == {("antenna",)}


def test_a_toml_model_gives_its_offsets(tmp_path):
    """Values of a file hold before anything is fitted."""
    path = tmp_path / "mine.toml"
    path.write_text(
        '[[term]]\neffect = "elevation_zero"\nvalue_arcsec = 30\n'
        '[[term]]\neffect = "tilt"\nvalue_arcsec = [5, 0]\n'
    )
    at = Circumstances(np.array([0.0, np.pi]), np.array([0.5, 0.5]))

    _, y = models.load(str(path)).offsets(at)

    np.testing.assert_allclose(y / ARCSEC, [35, 25])


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("name = 1", r"no \[\[term\]\] table"),
        ('[[term]]\neffect = "sagg"', "no effect is called 'sagg'"),
        ('[[term]]\neffect = "tilt"\nvalue_arcsec = 5', "2 number"),
        ('[[term]]\neffect = "tilt"\nvalue_parsec = [5, 5]', "units"),
        ("[[term", "not a TOML file"),
    ],
)
def test_a_bad_model_file_is_named_with_what_is_wrong(tmp_path, text, wrong):
    """One clear line that names the file."""
    path = tmp_path / "bad.toml"
    path.write_text(text)

    with pytest.raises(BadInput, match=wrong) as caught:
        models.load(str(path))
    assert str(path) in str(caught.value)


def test_an_unknown_model_lists_the_known_ones():
    """A mistyped name is answered with what there is."""
    with pytest.raises(BadInput, match="altaz, equatorial, gmrt-paper, none, rt32-3model"):
        models.load("altazz")


def test_the_rt32_terms_are_the_derivative_of_its_model():
    """A small change of any parameter moves the exact model as its term says, to first order."""
    from pyport.pointing import Rt32Model, printed

    rng = np.random.default_rng(0)
    at = Circumstances(rng.uniform(-1, 7, 50), rng.uniform(0.2, 1.2, 50))
    step = 1e-6
    for n, term in enumerate(models.load("rt32-exact").terms):
        changed = printed()
        changed[n] += step
        moved = np.subtract(Rt32Model(changed).offsets(at), Rt32Model(printed()).offsets(at))
        said = np.array(term.effect.columns(at))[:, :, 0]

        np.testing.assert_allclose(moved / step, said, atol=5e-3)
