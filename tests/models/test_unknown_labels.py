"""A receiver, a band or an antenna that a model does not know is refused, or said; never zero."""

import json

import numpy as np
import pytest
from click.testing import CliRunner, Result
from samples import OF_RECEIVERS

import pyport
from pyport.cli import pyport as program
from pyport.errors import BadInput
from pyport.formats.models import load
from pyport.steering.tabulate import Conditions, tabulate

MODEL = f"""
schema = "pyport.model/1"
name = "two receivers"
{OF_RECEIVERS}"""
BANDS = (
    MODEL.replace('"by receiver"', '"by frequency band"')
    .replace('by = "receiver", values = ["K", "X"]', 'by = "frequency_mhz", values = ["L", "X"]')
    .replace('"L", "X"', '"from 1400 MHz", "from 8000 MHz"')
    .replace("starts_mhz = []", "starts_mhz = [1400.0, 8000.0]")
    .replace("[X]", "[from 8000 MHz]")
)
TARGETS = "az_deg,el_deg,receiver\n10,40,K\n20,50,X\n"
REFUSED = "no coefficients for receiver 'Z': it has them for K, X"


@pytest.fixture
def model(tmp_path):
    """Return the file of a model of two receivers."""
    path = tmp_path / "model.toml"
    path.write_text(MODEL)
    return path


def applied(*arguments: object) -> Result:
    """Apply a model by the program; return what it says."""
    words = ["apply", *map(str, arguments)]
    return CliRunner().invoke(program, words, catch_exceptions=False, standalone_mode=False)


def night(rows, seed, receivers):
    """Return a table of noise that some receivers recorded in turn."""
    rng = np.random.default_rng(seed)
    return {
        "az_deg": rng.uniform(0, 360, rows),
        "el_deg": rng.uniform(20, 80, rows),
        "d_xel_arcsec": rng.normal(0, 3, rows),
        "d_el_arcsec": rng.normal(0, 3, rows),
        "receiver": np.array(receivers)[np.arange(rows) % len(receivers)],
    }


def test_in_python(model):
    """Alone, among others, in numbers, and as a table; a blank one says nothing."""
    known = pyport.load_model(model)
    assert known.offsets(10.0, 40.0, receiver="X").d_el.value == pytest.approx(30)
    assert known.offsets(10.0, 40.0, receiver="").d_el.value == 0
    for told in ("Z", np.array(["K", "Z"])):
        with pytest.raises(BadInput, match=REFUSED):
            known.offsets(np.array([10.0, 20.0]), np.array([40.0, 50.0]), receiver=told)
    with pytest.raises(BadInput, match=REFUSED):
        known.offsets_rad(0.1, 0.7, receiver="Z")
    with pytest.raises(BadInput, match=REFUSED):
        known.correct({"az_deg": [10.0], "el_deg": [40.0], "receiver": ["Z"]})


def test_a_term_of_zeros(tmp_path):
    """It refuses labels like any other."""
    path = tmp_path / "model.toml"
    path.write_text(MODEL.replace("-60.0", "0.0").replace("30.0", "0.0"))
    known = pyport.load_model(path)

    for ask in (known.offsets, known.offsets_rad):
        assert ask(0.1, 0.7, receiver="X") == (0, 0)
        with pytest.raises(BadInput, match=REFUSED):
            ask(0.1, 0.7, receiver="Z")


def test_apply(model, tmp_path):
    """By an option and by a column; rows that tell none are counted."""
    targets = tmp_path / "targets.csv"
    targets.write_text("az_deg,el_deg\n10,40\n20,50\n")
    with pytest.raises(BadInput, match=REFUSED):
        applied(model, targets, "--set", "receiver=Z")
    with pytest.raises(BadInput, match=r"--set reciever: no condition is called so, .* 'receiver'"):
        applied(model, targets, "--set", "reciever=X")
    with pytest.raises(BadInput, match=r"--set sessoin: no condition is called so, .* 'session'"):
        applied(model, targets, "--set", "sessoin=april")

    targets.write_text(TARGETS.replace("X", "Z"))
    with pytest.raises(BadInput, match=REFUSED):
        applied(model, targets)

    targets.write_text(TARGETS.replace("X", ""))
    said = "1 rows do not tell receiver: what follows it counts as zero"
    assert said in applied(model, targets).stderr


@pytest.mark.parametrize(
    ("rows", "line"), [("10,40,K\n11,41,X\n12,42,Z\n", 4), (",,\n11,41,Q9\n12,42,Z\n", 3)]
)
def test_apply_names_the_line(model, tmp_path, rows, line):
    """Of the first row whose label the model does not know, of an effect's own and of a fit's."""
    targets, each = tmp_path / "targets.csv", tmp_path / "each.toml"
    targets.write_text(f"az_deg,el_deg,receiver\n{rows}")
    pyport.fit(night(80, 2, ["K", "X"]), per=["receiver"]).model.save(each)
    for one in (model, each):
        with pytest.raises(
            BadInput, match=rf"targets.csv:{line}: the model's term .*receiver '[QZ]"
        ):
            applied(one, targets)


def test_table_and_fit(model):
    """Wherever the model's values are used."""
    with pytest.raises(BadInput, match=REFUSED):
        tabulate(str(model), beside=Conditions(columns={"receiver": np.array("Z")}))
    with pytest.raises(BadInput, match=REFUSED):
        pyport.fit(night(60, 1, ["K", "X", "Z"]), load(str(model)))


def test_a_frequency_below_all_bands(tmp_path):
    """It was that of no receiver; between two bands it is still the lower one's."""
    path = tmp_path / "bands.toml"
    path.write_text(BANDS)
    known = pyport.load_model(path)

    assert known.offsets(10.0, 40.0, frequency=8400.0).d_el.value == pytest.approx(30)
    assert known.offsets(10.0, 40.0, frequency=1500.0).d_el.value == 0
    with pytest.raises(BadInput, match=r"no coefficients for frequency_mhz '610.0'"):
        known.offsets(10.0, 40.0, frequency=610.0)


def test_coefficients_of_one_antenna_are_said_to_be_another_s(tmp_path):
    """They hold wherever they are asked for: they are all there is. A night has none of its own."""
    rng, n = np.random.default_rng(2), 60
    table = {
        "az_deg": rng.uniform(0, 360, n),
        "el_deg": rng.uniform(20, 80, n),
        "d_xel_arcsec": rng.normal(0, 3, n),
        "d_el_arcsec": 40 + rng.normal(0, 3, n),
        "antenna": np.full(n, "W01"),
        "session": np.full(n, "march"),
    }
    path, targets = tmp_path / "one.toml", tmp_path / "targets.csv"
    pyport.fit(table).save(path)
    targets.write_text("az_deg,el_deg\n10,40\n")
    said = "the coefficients are those of antenna W01, taken for W02"

    told = applied(path, targets, "--set", "antenna=W02", "--json")
    assert json.loads(told.stdout)["notes"] == [said]
    assert said in applied(path, targets, "--set", "antenna=W02").stderr
    same = applied(path, targets, "--set", "antenna=W01", "--set", "session=april")
    assert "taken for" not in same.stderr
