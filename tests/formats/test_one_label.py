"""Of a model that differs between labels, a file of another program holds one label's."""

import numpy as np
import pytest
from samples import OF_RECEIVERS

import pyport
from pyport.errors import BadInput
from pyport.formats.convert import convert
from pyport.recordings.raw import FileOptions


@pytest.fixture
def model(tmp_path):
    """Return a fitted model of two antennas, with receivers that look in other directions."""
    rng, n = np.random.default_rng(2), 300
    antenna = np.array(["a", "b"])[np.arange(n) % 2]
    table = {
        "az_deg": rng.uniform(0, 360, n),
        "el_deg": rng.uniform(15, 85, n),
        "d_xel_arcsec": rng.normal(0, 3, n),
        "d_el_arcsec": 40 * (antenna == "b") + rng.normal(0, 3, n),
        "antenna": antenna,
    }
    path = tmp_path / "model.toml"
    pyport.fit(table).save(path)
    fitted = path.read_text().partition("[covariance]")[0]
    path.write_text(fitted + OF_RECEIVERS)
    return path


def converted(model, target, **labels):
    """Return the model that another program's file holds."""
    convert(str(model), target, given=FileOptions(labels))
    return pyport.load_model(target)


@pytest.mark.parametrize("antenna", ["a", "b"])
@pytest.mark.parametrize("receiver", ["K", "X"])
def test_the_coefficients_of_labels_that_are_given(model, tmp_path, antenna, receiver):
    """Terms that other programs know have that antenna's values, the receiver's is in the zeros."""
    there = np.array([10.0, 130.0, 250.0]), np.array([20.0, 45.0, 80.0])
    told = {"antenna": antenna, "receiver": receiver}

    written = converted(model, tmp_path / "new.mod", **told)

    np.testing.assert_allclose(
        [one.value for one in written.offsets(*there)],
        [one.value for one in pyport.load_model(model).offsets(*there, **told)],
        atol=1e-3,
    )


def test_a_label_that_the_model_does_not_have(model, tmp_path):
    """It is named, with those that it has."""
    with pytest.raises(BadInput, match="no coefficients for antenna 'c', expected one of a, b"):
        converted(model, tmp_path / "new.mod", antenna="c", receiver="K")
    with pytest.raises(BadInput, match="no coefficients for receiver 'Z', expected one of K, X"):
        converted(model, tmp_path / "new.mod", antenna="a", receiver="Z")


def test_labels_that_are_not_given_are_refused_as_before(model, tmp_path):
    """No value is chosen for the user."""
    with pytest.raises(BadInput, match="has coefficients for each antenna"):
        converted(model, tmp_path / "new.mod", receiver="K")
    with pytest.raises(BadInput, match="has no name for offset_xel"):
        converted(model, tmp_path / "new.mod", antenna="a")
