"""A completed model leaves what the fit or diagnosis leaves; every table prints one number."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import recordings
from samples import sample

from pyport import api
from pyport.angles import ARCSEC, DEG
from pyport.diagnosis import joint
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.diagnose import diagnose
from pyport.effects import CATALOGUE
from pyport.effects.empirical.epochs import epoch_step
from pyport.effects.empirical.oscillations import oscillation
from pyport.errors import BadInput
from pyport.fitting.fit import completed as completed_fit
from pyport.fitting.fit import fit
from pyport.fitting.table import as_json as fit_json
from pyport.fitting.table import text
from pyport.formats.models import load
from pyport.models import toml
from pyport.models.complete import OVER, PAST, decimals, lines
from pyport.models.conditions import Completed, Value
from pyport.models.model import Model, Term
from pyport.models.terms.editing import edited
from pyport.page import of_diagnosis, of_fit
from pyport.pointing import printed
from pyport.report.finding import completed
from pyport.report.made import report_of
from pyport.report.typed import as_json
from pyport.steering.tabulate import tabulate

TERMS = {"IA": 30, "IE": 12, "CA": -20, "NPAE": 25, "AN": 8, "AW": 1, "TF": 50}
OLD = "\n".join(["old", "T 1 1 0 0", *(f"  {name} {n}.0" for name, n in TERMS.items()), "END\n"])
#: How closely the saved model's offsets repeat what was found.
PROMISED = 1e-9 * DEG


@pytest.fixture(scope="module")
def old(tmp_path_factory):
    """Return TPOINT's file of the model in force."""
    path = tmp_path_factory.mktemp("model") / "old.mod"
    path.write_text(OLD)
    return path


@pytest.fixture(scope="module")
def searched(old):
    """Return a diagnosis whose candidates are at hand."""
    antenna = np.array(["a", "b"])[np.arange(500) % 2]
    return diagnose(recordings(500, 4, antenna=antenna), load(str(old)))


@pytest.mark.slow
@pytest.mark.parametrize("scope", ["all", "antenna", "session", "antenna and session"])
@pytest.mark.parametrize(
    "effect", ["epoch_offset", "epoch_tilt", "tilt", "drift", "elevation_scale"]
)
def test_whatever_is_chosen_is_carried(effect, scope, searched, tmp_path):
    """A step in time, coefficients by session and antenna: every member, as if it were found."""
    problem, given = searched.problem, searched.problem.model
    for candidate in (one for one in problem.candidates if one.effect.id == effect):
        after = joint.fit(problem, searched.weighed, [Chosen(candidate, scope)])
        new = completed(replace(searched, after=after))
        toml.write(new, tmp_path / "new.toml")
        back = load(str(tmp_path / "new.toml"))
        at = problem.recordings.at
        x, y = (n - o for n, o in zip(back.offsets(at), given.offsets(at), strict=True))

        np.testing.assert_allclose(
            problem.stack.spread(x, y), after.predicted, atol=PROMISED, rtol=0
        )


@pytest.mark.slow
def test_every_table_prints_the_same_number(old):
    """A diagnosis: page, report and file; a fit: page, fit.json, text and file."""
    measured = recordings(600, 3, y=lambda at: 30 / np.tan(at.el))
    found, done = diagnose(measured, load(str(old))), fit(measured, load(str(old)))

    of_model = {one.name: one for one in completed(found).completed.values}
    rows = {row.name: row for row in of_diagnosis(found)[1].rows}
    report = {
        row["name"]: row
        for term in as_json(report_of(found))["completed_model"]["term"]
        for row in term["coefficients"]
    }
    assert set(of_model) == set(rows) == set(report) >= {"IA", "refraction"}
    for name, one in of_model.items():
        assert rows[name].value == report[name]["value"] == one.value
        assert rows[name].before == report[name]["before"] == one.before
        assert one.change == one.value - one.before
    fitted = {one.name: one for one in completed_fit(done).completed.values}
    shown = {row.name: row.value for row in of_fit(done)[1].rows}
    written = {row["name"]: row["value"] for row in fit_json(done)["parameters"]}
    assert shown == written == {name: one.value for name, one in fitted.items()}
    assert f"{fitted['IA'].value:10.2f}" in text(done)


@pytest.mark.parametrize(
    ("value", "sigma", "digits"),
    [(1100.25, None, 2), (45.78, None, 4), (-177.416, None, 3), (45.78, 0.23, 2), (0.0, None, 3)],
)
def test_what_was_held_is_shown_to_its_last_digit(value, sigma, digits):
    """It is entered into a control system; what was fitted has two digits of its error."""
    one = Value("IA", "azimuth_zero", "arcsec", value, sigma, value, {}, None, determined=True)

    assert decimals(one) == digits


def test_labels_and_what_was_held_come_back(tmp_path):
    """Coefficients of each antenna, one fixed for all, errors and covariance."""
    antenna = np.array(["a", "b", "c"])[np.arange(600) % 3]
    measured = recordings(
        600, 3, antenna=antenna, y=lambda at: 40.0 * (at.column("antenna") == "b")
    )
    model = edited(load("altaz"), fix=["NPAE=30"])
    done = fit(measured, model)
    path = tmp_path / "each.toml"
    toml.write(completed_fit(done), path)
    back = load(str(path))
    x, y = back.offsets(measured.at)
    left = done.stack.value - done.stack.spread(x, y)
    values = back.completed.values
    zeros = {one.labels["antenna"]: one.value for one in values if one.name == "elevation_zero"}

    np.testing.assert_allclose(left, done.residual, atol=PROMISED, rtol=0)
    assert zeros["b"] - zeros["a"] == pytest.approx(40, abs=3)
    assert [one.sigma for one in values if one.name == "NPAE"] == [None]
    sigma = np.array([one.sigma or 0.0 for one in values])
    np.testing.assert_allclose(np.sqrt(np.diag(back.completed.covariance)), sigma, rtol=1e-6)
    with pytest.raises(
        ValueError, match="no coefficients for antenna 'd': it has them for a, b, c"
    ):
        back.offsets(recordings(5, 1, antenna=np.array(["d"] * 5)).at)


def test_what_the_recordings_leave_open_keeps_what_the_file_had(tmp_path):
    """Collimation and skew at one elevation: not determined, and said so in the file."""
    measured = recordings(300, 2)
    flat = np.full(300, 0.8)
    measured = replace(measured, at=replace(measured.at, el=flat))
    done = fit(measured, load("altaz"))
    path = tmp_path / "open.toml"
    toml.write(completed_fit(done), path)
    values = {one.name: one for one in load(str(path)).completed.values}

    assert not values["collimation"].determined
    assert values["collimation"].value == values["collimation"].before == 0
    assert values["tilt_north"].determined


def test_the_rt32s_parameters_are_absolute(tmp_path):
    """p1..p12 as the control system has them; the offsets are those of the exact form and more."""
    base = load("rt32-exact")
    measured = recordings(400, 6)
    x, y = base.offsets(measured.at)
    measured = replace(measured, x=measured.x + x, y=measured.y + y)
    found = diagnose(measured, base)
    path = tmp_path / "rt32.toml"
    toml.write(completed(found), path)
    back = load(str(path))
    new_x, new_y = back.offsets(measured.at)
    told = found.problem.stack.spread(new_x - x, new_y - y)
    values = {one.name: one for one in back.completed.values}
    np.testing.assert_allclose(
        told, found.problem.residual - found.left(found.after), atol=PROMISED, rtol=0
    )
    assert values["p2"].before == pytest.approx(printed()[1] / ARCSEC)
    assert values["p2"].change == pytest.approx(found.after.solution.values[1] / ARCSEC)


def test_a_term_made_in_python_is_refused_by_name(tmp_path):
    """What no file can hold is said before anything is written; the diagnosis itself stands."""
    bent = replace(CATALOGUE["skew"], basis=lambda at: (at.el[:, None] ** 2, 0 * at.el[:, None]))
    done = completed_fit(fit(recordings(200, 1), Model("mine", (Term(bent),))))

    with pytest.raises(ValueError, match="no file can hold the model's terms skew"):
        toml.write(done, tmp_path / "x.toml")
    assert not (tmp_path / "x.toml").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('schema = "pyport.model/1"', 'schema = "pyport.model/9"', "schema is 'pyport.model/9'"),
        ("value = ", "value = true, was = ", "expected a number"),
        ('effect = "skew"', 'effect = "skow"', "no effect is called 'skow'"),
        ('unit = "arcsec"', 'unit = "parsec"', "expected 'arcsec'"),
        ("[[term]]", "[[turn]]", "no key 'term'"),
        ("lower_triangle = [", "lower_triangle = [ [1.0],", "no lower triangle"),
    ],
)
def test_a_spoilt_file_is_one_line(tmp_path, old, new, said):
    """With the file's name, and no traceback."""
    path = tmp_path / "new.toml"
    toml.write(completed_fit(fit(recordings(200, 1), load("altaz"))), path)
    text = path.read_text()
    path.write_text(text.replace(old, new) if old == "[[term]]" else text.replace(old, new, 1))

    with pytest.raises(ValueError, match=said) as error:
        load(str(path))
    assert str(error.value).startswith(str(path))


def test_auxtels_published_rms_is_told():
    """TPOINT's sky rms of 2022-04-06, 3.1416 arcsec over 54 stars, and its coefficients."""
    night = sample("auxtel/AT_point_data_20220406_tw004_corr.dat")
    done = api.fit(night, "none", add=["IA", "IE", "AN", "AW", "TX", "CA"], weights="equal")
    published = {"IA": -292.0, "IE": -213.05, "AN": 39.16, "AW": 70.89, "TX": -6.86, "CA": 90.93}

    assert done.rms["sky"].to_value("arcsec") == pytest.approx(3.1416, abs=5e-4)
    for name, value in published.items():
        assert done.coefficients[name].value == pytest.approx(value, abs=0.05)
    file = sample("auxtel/at_20220406_ia_ie_an_aw_tx10_ca.mod")
    facts = {one[0]: one for one in api.fit(night, file, weights="equal").drawn[1].facts}
    assert facts["sky rms"][1] == "3.1412"
    assert facts["sky rms"][2].endswith("the model's file says 3.1416")


def test_fewer_offsets_than_coefficients_make_no_model(tmp_path, monkeypatch):
    """A diagnosis counts them once, shows and saves nothing to enter; none is applied."""
    few = diagnose(recordings(40, 6).take(np.arange(3)), load("altaz"))
    report, path = report_of(few), tmp_path / "few.toml"
    wrong = "6 measured offsets cannot determine 7 coefficients"

    assert report.corrections == report.combinations == ()
    assert report.completed_model is None
    assert "(6 measured numbers) with 7 fitted coefficients" in report.verdict
    assert report.warnings == (f"fit of the model: {wrong}",)
    with pytest.raises(BadInput, match=wrong):
        toml.write(completed(few), path)

    with monkeypatch.context() as before:
        before.setattr(Completed, "undetermined", None)
        toml.write(completed(few), path)
    for use in (api.load_model, lambda name: tabulate(str(name), "none")):
        with pytest.raises(BadInput, match=wrong):
            use(path)


def test_coefficients_known_in_combination_only_are_saved_and_applied(tmp_path):
    """Collimation and skew at one elevation: enough offsets, so that their sum is known."""
    measured = recordings(300, 2)
    measured = replace(measured, at=replace(measured.at, el=np.full(300, 0.8)))
    found, path = diagnose(measured, load("altaz")), tmp_path / "together.toml"
    toml.write(completed(found), path)
    model = api.load_model(path)
    told = found.problem.stack.spread(*model.model.offsets(measured.at))

    assert not all(one.determined for one in model.values)
    np.testing.assert_allclose(
        told, found.problem.residual - found.left(found.after), atol=PROMISED, rtol=0
    )


def test_what_wandered_is_nothing_to_enter():
    """It holds in stretches that are past; what lasts, and a step's moment, stand in the table."""
    members = oscillation(3600.0, 0.0, [(0.0, 7200.0)], direction_deg=30.0), CATALOGUE["refraction"]
    terms = [Term(effect, finding=n) for n, effect in enumerate(members, 1)]
    values = [
        Value(one.name, term.effect.id, "arcsec", 2.0, 0.1, 0.0, {}, term.finding, determined=True)
        for term in terms
        for one in term.effect.coefficients
    ]
    told = lines(Completed({}, tuple(values), np.eye(len(values))), terms)

    assert [line.split()[0] for line in told] == ["enter", "refraction", "finding"]
    assert told[-1] == "finding 1: " + PAST


def test_what_came_back_is_nothing_to_enter():
    """A zero that was displaced for an hour is now as it was."""
    step = epoch_step(1.0e9, until=1.0e9 + 3600)
    values = [
        Value(one.name, step.id, "arcsec", 20.0, 0.1, 0.0, {}, 1, determined=True)
        for one in step.coefficients
    ]
    told = lines(Completed({}, tuple(values), np.eye(2)), [Term(step, finding=1)])

    assert told == ["finding 1: " + OVER]


def test_what_is_not_determined_is_not_entered():
    """Such a value is one of many: it is named, without the number."""
    known, open_ = (
        Value(name, name, "arcsec", 2.5, 0.1, 0.0, {}, None, determined=name == "tilt_north")
        for name in ("tilt_north", "skew")
    )
    nothing = "nothing to enter, not determined by these recordings: skew"

    assert lines(Completed({}, (open_,), np.eye(1))) == [nothing]
    head, table, last = lines(Completed({}, (known, open_), np.eye(2)))
    assert (head.strip(), table.split()[0]) == ("enter this into the control system", "tilt_north")
    assert last == nothing
