"""Of a model that differs between labels, a file of another program holds one label's."""

import numpy as np
import pytest
from click.testing import CliRunner
from samples import OF_RECEIVERS

import pyport
from pyport.cli import pyport as program
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


FOLLOWING = """
[[term]]
effect = "driven_term"
per = []
variant = "{term} follows temperature_c"
member = {{ term = "{term}", follows = "temperature_c", centre = 10.0 }}
coefficients = [{coefficients}]
"""


@pytest.fixture
def following(tmp_path):
    """Return a model of receivers, whose zero, tilt and refraction follow the temperature."""
    path = tmp_path / "following.toml"
    said = 'schema = "pyport.model/1"\nname = "altaz"\n' + OF_RECEIVERS
    for term, names in (
        ("elevation_zero", ["elevation_zero"]),
        ("tilt", ["tilt_north", "tilt_east"]),
        ("refraction", ["refraction"]),
    ):
        each = (f'{{ name = "{one}_per_K", value = 3.0, unit = "arcsec/K" }}' for one in names)
        said += FOLLOWING.format(term=term, coefficients=", ".join(each))
    path.write_text(said)
    return path


def run(*arguments):
    """Return what `convert` prints."""
    done = CliRunner().invoke(program, ["convert", *map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.parametrize("beside", ["--leave-out", "--rest-as"])
@pytest.mark.parametrize("suffix", ["mod", "ctl", "txt"])
def test_what_is_an_exact_sum_is_written_whatever_becomes_of_the_rest(
    following, tmp_path, suffix, beside
):
    """Receiver, zero and tilt are in the file; the refraction that is left is on the grid."""
    target, grid = tmp_path / f"new.{suffix}", tmp_path / "grid.csv"
    ways = {"--leave-out": [beside], "--rest-as": [beside, grid]}[beside]

    said = run(following, target, "--set", "receiver=X", "--set", "temperature_c=8", *ways)

    at = np.array([10.0, 130.0, 250.0]), np.array([20.0, 44.0, 80.0])
    written = pyport.load_model(target).offsets(*at)
    whole = pyport.load_model(following).offsets(*at, receiver="X", temperature_c=8)
    np.testing.assert_allclose(written.d_xel.value, whole.d_xel.value, atol=1e-3)
    bent = 6 / np.tan(np.radians(at[1]))
    np.testing.assert_allclose(written.d_el.value - bent, whole.d_el.value, atol=0.1)
    assert "has no place: refraction (refraction follows temperature_c) (" in said
    if beside == "--rest-as":
        rows = np.genfromtxt(grid, delimiter=",", names=True, skip_header=4)
        assert np.abs(rows["d_xel_arcsec"]).max() < 1e-3


def test_only_what_remains_is_refused(following, tmp_path):
    """What the file would hold is not among the names."""
    with pytest.raises(BadInput, match=r"has no name for refraction \([a-z_ ]*\): keep"):
        converted(following, tmp_path / "new.mod", receiver="X", temperature_c="8")


def test_what_is_left_out_is_not_known_where_a_condition_is_open(following, tmp_path):
    """The conditions are named; what does not depend on them is in the file."""
    said = run(following, tmp_path / "new.mod", "--set", "receiver=X", "--leave-out")
    assert "(arcsec rms not known without --set temperature_c)" in said
    assert {"-30.0000", "-60.0000"} <= set((tmp_path / "new.mod").read_text().split())

    said = run(following, tmp_path / "new.mod", "--leave-out")
    assert "not known without --set receiver and --set temperature_c)" in said


def test_a_grid_that_nothing_is_left_for(model, tmp_path):
    """It is not written, and that is said."""
    grid = tmp_path / "grid.csv"
    labels = "--set", "antenna=b", "--set", "receiver=X"

    said = run(model, tmp_path / "new.mod", *labels, "--rest-as", grid)

    assert "grid.csv: not written, for tpoint-mod has a place for every term" in said
    assert not grid.exists()
