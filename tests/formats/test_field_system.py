"""The Field System: unit responses, fits and files, against its own outputs and by hand."""

from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from samples import sample

from pyport.angles import ARCSEC, DEG
from pyport.errors import BadInput
from pyport.formats.field_system import agreement, ctl, err
from pyport.formats.field_system.fit import Data, columns, fit
from pyport.recordings.formats.xtr import read_xtr, sections

CLASSICAL = (1, 3, 4, 5, 6, 7, 8)


def simulated(n, noise_arcsec, seed, told_arcsec=1.0):
    """Return data with the classical parameters, and the truth [rad]."""
    rng = np.random.default_rng(seed)
    az, el = rng.uniform(0, 2 * np.pi, n), rng.uniform(0.2, 1.4, n)
    truth = rng.normal(0, 100 * ARCSEC, len(CLASSICAL))
    told = np.full(n, told_arcsec * ARCSEC)
    data = Data(az, el, 0 * az, 0 * az, told / np.cos(el), told, np.ones(n, bool))
    across, along = columns(data, CLASSICAL, 90.0)
    noise = rng.normal(0, noise_arcsec * ARCSEC, (2, n))
    return replace(
        data, d_az=across @ truth + noise[0] / np.cos(el), d_el=along @ truth + noise[1]
    ), truth


@pytest.mark.parametrize("phi", [90.0, 35.0])
def test_unit_responses_are_the_field_systems(phi):
    """Every parameter, everywhere, to 1e-10."""
    found = agreement.responses(sample(f"field_system/{agreement.GRID}"))

    assert {one.name for one in found if one.phi_deg == phi} == {f"P{n}" for n in range(1, 31)}
    assert max(one.worst for one in found if one.phi_deg == phi) < 1e-10


@pytest.mark.parametrize("name", ["lmt", "auxtel2022"])
def test_fits_are_the_field_systems(name):
    """Values and sigmas to its single precision, correlations to the digits that it prints."""
    folder = sample(f"field_system/{name}.err").parent
    found = agreement.compared(folder, name)

    np.testing.assert_allclose(*found.value, atol=1e-8)
    np.testing.assert_allclose(*found.sigma, atol=1e-9)
    np.testing.assert_allclose(*found.correlation, atol=5.1e-4)


#: Sections of an err file, and how far a printed number may be off by single precision.
SECTIONS = {
    "observed": 1.1e-5,
    "observed_stats": 1.1e-5,
    "old_model": 0,
    "uncorrected": 1.1e-5,
    "uncorrected_stats": 1.1e-5,
    "fit_stats": 1.1e-3,
    "correlation": 1.1e-3,
    "corrected": 1.1e-5,
    "corrected_stats": 1.1e-5,
}


@pytest.mark.parametrize("name", ["lmt", "auxtel2022"])
def test_a_whole_err_file_is_written_as_the_field_system_writes_it(tmp_path, name):
    """Section by section the same numbers."""
    theirs = sections(sample(f"field_system/{name}.err"))
    model = ctl.read(sample("field_system/mdlpo.ctl"))
    path = tmp_path / "own.err"
    err.write(err.fitted(read_xtr(sample(f"field_system/{name}.xtr")), model), path)
    ours = sections(path)

    assert list(ours) == list(theirs)
    for section, tolerance in SECTIONS.items():
        expected, actual = (
            np.array([float(word) for line in one[section] for word in line.words])
            for one in (theirs, ours)
        )
        np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance, err_msg=section)


def test_noise_that_the_errors_do_not_tell_is_found():
    """Sigmas are those of the scatter: pulls are normal, chi is one."""
    pulls = []
    for seed in range(20):
        data, truth = simulated(150, 6.0, seed)
        found = fit(data, CLASSICAL)
        pulls.append((found.value - truth) / found.sigma)
        assert found.scatter[1:] == pytest.approx((1, 1), abs=0.01)
        assert np.array(found.noise) / ARCSEC == pytest.approx([5.9, 5.9], rel=0.2)

    assert 0.85 < np.std(pulls) < 1.15


def test_noise_may_be_less_than_the_errors_tell():
    """It is then taken away, and negative."""
    data, _ = simulated(400, 1.0, 0, told_arcsec=1.5)
    found = fit(data, CLASSICAL)

    assert max(found.noise) < 0
    assert found.scatter[0] == pytest.approx(1, abs=0.02)


def test_flagged_data_have_no_vote():
    """A row out of use may hold anything."""
    data, _ = simulated(60, 1.0, 3)
    used = np.arange(60) > 4
    spoilt = np.where(used, data.d_el, 1.0)

    whole = fit(replace(data, used=used), CLASSICAL)
    spoiled = fit(replace(data, used=used, d_el=spoilt), CLASSICAL)

    np.testing.assert_array_equal(whole.value, spoiled.value)


@pytest.mark.parametrize(
    ("numbers", "rows", "words"),
    [
        ((1, 2), 60, "P2 moves nothing here"),
        ((8, 10), 60, "cannot distinguish the fitted parameters"),
        (CLASSICAL, 3, "6 offsets cannot determine 7"),
    ],
)
def test_what_cannot_be_fitted_is_said(numbers, rows, words):
    """One line instead of numbers that mean nothing."""
    data, _ = simulated(rows, 1.0, 1)

    with pytest.raises(BadInput, match=words):
        fit(data, numbers)


FLAGS = "  90.0  {} 0 1 1 1  1 {} {} 0 0"
XTR = "$antenna\n TEST azel 1\n$data\n{}$stats\n"


def files(tmp_path, flags, values):
    """Write an xtr of known parameters, and a model with these flags and old values."""
    data, truth = simulated(80, 0.0, 5)
    rows = np.degrees([data.az, data.el, data.d_az, data.d_el, data.sigma_az, data.sigma_el]).T
    text = "".join(f" 1 {' '.join(f'{v:.9f}' for v in row)}\n" for row in rows)
    (tmp_path / "mine.xtr").write_text(XTR.format(text))
    lines = [" ".join(values[:5]), " ".join(values[5:])]
    model = f"* mine\n 7 2026 001 02 03 04\n{FLAGS.format(*flags)}\n" + "\n".join(lines) + "\n"
    (tmp_path / "mdlpo.ctl").write_text(model)
    return (
        read_xtr(tmp_path / "mine.xtr"),
        ctl.read(tmp_path / "mdlpo.ctl"),
        dict(zip(CLASSICAL, truth / DEG, strict=True)),
    )


def values_of(file):
    """Return the parameters of a model that are in use [deg]."""
    return {int(e.name[1:]): float(e.value) for e in file.entries if e.used}


def test_an_old_model_is_put_back_and_fitted_anew(tmp_path):
    """Offsets are what an old model left: old and found add up, the number goes up by one."""
    old = ["0.1", "0", "0", "0", "0", "0", "-0.2", "0", "0", "0"]
    raw, model, truth = files(tmp_path, (1, 1, 1), old)

    done = err.fitted(raw, model)

    expected = truth | {1: truth[1] + 0.1, 7: truth[7] - 0.2}
    assert values_of(done.new) == pytest.approx(expected, abs=1e-6)
    assert done.new.details["number_and_date"][0] == 8


def test_held_parameters_stay_and_forgotten_ones_go(tmp_path):
    """Flag 2 keeps its value and its flag; flag 4 is put back into the data and dropped."""
    old = ["0.1", "0", "0", "0", "0", "0", "0.3", "0.05", "0", "0"]
    raw, model, truth = files(tmp_path, (2, 1, 4), old)

    done = err.fitted(raw, model)
    new = values_of(done.new)

    assert new[1] == 0.1
    assert 8 not in new
    assert next(e for e in done.new.entries if e.name == "P1").fixed
    assert done.fit.numbers == (3, 4, 5, 6, 7)
    assert new[7] == pytest.approx(truth[7] + 0.3 + 0.8 * (truth[8] + 0.05), abs=0.1)


def test_a_parameter_alone_holds_all_others(tmp_path):
    """Flag 3 fits P7 only, and becomes 1."""
    raw, model, _ = files(tmp_path, (1, 3, 1), ["0"] * 10)

    done = err.fitted(raw, model)

    assert done.fit.numbers == (7,)
    assert done.new.details["flags"] == [1, 0, 1, 1, 1, 1, 1, 1, 0, 0]
    assert values_of(done.new)[1] == 0


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("* only a comment\n", 1, "0 lines of a model"),
        ("1 2 3\n90 1\n0\n", 1, "expected a number, year"),
        ("1 2014 290 0 0 0\n90.0 7\n0.0\n", 2, "flags"),
        ("1 2014 290 0 0 0\n90.0 1 1\n0.0\n", 3, "1 parameters, expected 2"),
        ("1 2014 290 0 0 0\n90.0 1 1\n0.0 zero\n", 3, "'zero', expected a number"),
        ("1 2014 290 0 0 0\n90.0" + " 1" * 31 + "\n0.0\n", 2, "31 flags, expected 1 to 30"),
    ],
)
def test_a_bad_model_names_its_line(tmp_path, text, line, words):
    """One line that says what was expected."""
    path = tmp_path / "bad.ctl"
    path.write_text(text)

    with pytest.raises(BadInput, match=words) as caught:
        ctl.read(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("no sections\n", 1, "no line begins with"),
        ("$data\n 1 2 3\n", 1, r"no section \$antenna"),
        ("$antenna\n TEST spin 1\n$data\n 1 1 2 3 4 5 6\n", 2, "'spin', expected azel, hadc"),
        ("$antenna\n TEST azel 1\n$data\n 1 2 3\n", 4, "2 numbers behind the flag"),
        ("$antenna\n TEST azel 1\n$data\n x 1 2 3 4 5 6\n", 4, "flag is 'x'"),
        ("$antenna\n TEST azel 1\n$data\n 1 1 2 3 4 5 six\n", 4, "'six', expected a number"),
        ("$antenna\n A azel\n$antenna\n", 3, "a second section"),
    ],
)
def test_bad_data_name_their_line(tmp_path, text, line, words):
    """One line that says what was expected."""
    path = tmp_path / "bad.xtr"
    path.write_text(text)

    with pytest.raises(BadInput, match=words) as caught:
        read_xtr(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")


def test_a_model_for_another_mount_bends_p2_and_p8(tmp_path):
    """With phi = 35 deg they move what they do not at 90; both survive a file."""
    path = tmp_path / "x.ctl"
    path.write_text("1 2014 290 0 0 0\n35.0 0 1 0 0 0 0 0 1\n0 0.01 0 0 0\n0 0 0.02\n")
    model = ctl.read(path)
    ctl.write(model, tmp_path / "y.ctl")

    again = ctl.read(tmp_path / "y.ctl")

    assert again.phi_deg == Decimal(35)
    assert [e.value for e in again.entries] == [e.value for e in model.entries]
    assert len(again.model("x").terms) == 2
