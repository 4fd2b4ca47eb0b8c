"""Public recordings are read as published, measured as stated, and held to the facts."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pyport
from pyport import recordings
from pyport.errors import BadInput
from pyport.examiner import scores
from pyport.examiner.real import huber, measures, published, readers, sets, studies, table

DATA = Path(__file__).parents[3] / "shared" / "data"
RNG = np.random.default_rng(0)


def drawn(n=120, nights=6, sigma=3.0, outliers=0.0, seed=0):
    """Return recordings of a telescope whose coefficients are 10, 20, ... arcsec."""
    rng = np.random.default_rng(seed)
    az, el = rng.uniform(0, 2 * np.pi, n), rng.uniform(0.3, 1.4, n)
    truth = 10.0 * np.arange(1, 8)
    offset = scores.altaz(az, el) @ truth + sigma * rng.standard_normal((n, 2))
    offset[rng.uniform(size=(n, 2)) < outliers] += 40 * sigma
    night = np.array([f"n{k * nights // n}" for k in range(n)])
    columns = {
        "az_deg": np.degrees(az),
        "el_deg": np.degrees(el),
        "d_xel_arcsec": offset[:, 0],
        "d_el_arcsec": offset[:, 1],
        "session": night,
    }
    return sets.Recordings(
        "drawn", columns, {}, az, el, *offset.T, night, np.full(n, "", dtype="U40")
    )


def report(*findings, **more):
    """Return a report with findings, each given by what differs from an empty one."""
    empty = {
        "effect": "clock",
        "variant": "",
        "verdict": "named",
        "sentence": "",
        "looks_like": None,
        "where": {"axes": ["xel", "el"], "since": None},
        "parameters": [],
        "heldout": None,
        "stability": None,
        "visible_rms_arcsec": 1.0,
        "true_rms_arcsec": 1.0,
    }
    return {
        "mismatch": bool(findings),
        "findings": [empty | one for one in findings],
        "fit": {},
        "detection_limit_arcsec": {"clock": 1.0},
    } | more


def parameter(name, value, sigma=1.0, unit="arcsec"):
    """Return a coefficient as reports have them."""
    return {"name": name, "value": value, "sigma": sigma, "unit": unit}


def test_huber_is_least_squares_without_outliers_and_robust_with():
    """Close to the truth either way; plain least squares is not."""
    clean, spoilt = drawn(2000), drawn(2000, outliers=0.05)
    truth = 10.0 * np.arange(1, 8)
    flat = scores.altaz(spoilt.az, spoilt.el).reshape(-1, 7)
    plain = np.linalg.lstsq(flat, spoilt.offsets().ravel(), rcond=None)[0]

    assert huber.fit(clean)[""] == pytest.approx(truth, abs=2)
    assert np.linalg.norm(huber.fit(spoilt)[""] - truth) < np.linalg.norm(plain - truth) / 2


def test_huber_agrees_with_that_of_scipy():
    """The same loss at the same scale has the same minimum."""
    from scipy.optimize import least_squares

    some = drawn(300, outliers=0.03)
    value = huber.fit(some)[""]
    left = huber.residuals(some, {"": value})
    scale = np.array([huber.scatter(one) for one in left.T])
    design = (some.columns() / scale[:, None]).reshape(-1, 7)
    data = (some.offsets() / scale).ravel()
    theirs = least_squares(
        lambda v: (design @ v - data) / huber.K, np.zeros(7), loss="huber", xtol=1e-12, ftol=1e-12
    ).x

    assert value == pytest.approx(theirs, abs=0.01)


def test_a_ratio_is_by_axis_and_ignores_what_is_not_measured():
    """Twice in one axis, equal in the other."""
    theirs = np.ones((50, 2)) * [1.0, 5.0]
    ours = theirs * [2.0, 1.0]
    blank = np.where(np.arange(50)[:, None] < 25, ours, np.nan)

    assert huber.ratio(ours, theirs) == pytest.approx(math.sqrt(2.5))
    assert huber.ratio(blank, theirs) == pytest.approx(math.sqrt(2.5))
    assert huber.ratio(theirs, theirs) == 1
    assert huber.ratio(ours * [1, np.nan], theirs * [1, np.nan]) == pytest.approx(2)
    assert huber.clipped(100 * theirs, theirs) < 5


def test_the_programs_coefficients_are_taken_as_the_examiners():
    """A fit by the program leaves what Huber's does."""
    some = drawn(400, nights=1)
    fit = pyport.fit(some.table).report
    ours = huber.residuals(some, measures.coefficients(some, fit))
    theirs = huber.residuals(some, huber.fit(some))

    assert huber.ratio(ours, theirs) == pytest.approx(1, abs=0.01)


def test_folds_are_nights_or_blocks_of_time():
    """Every row is left out once."""
    for some, scheme, count in ((drawn(), "nights", 6), (drawn(nights=1), "blocks", 5)):
        name, out = measures.folds(some)

        assert (name, len(out)) == (scheme, count)
        assert np.all(np.sum(out, axis=0) == 1)


def test_halves_share_no_night():
    """Each row is in one of them."""
    for first, second in measures.halves(drawn(), np.random.default_rng(0), 3):
        assert not set(first.night) & set(second.night)
        assert len(first) + len(second) == 120


def test_differences_are_over_both_sigmas():
    """Three apart with sigmas of three and four; what is open in one is left out."""
    one = {"parameters": [{"labels": [""], **parameter("skew", 1.0, 3.0)}]}
    two = {"parameters": [{"labels": [""], **parameter("skew", 4.0, 4.0)}]}
    none = {"parameters": [{"labels": [""], **parameter("skew", None, None)}]}

    assert measures.differences(one, two) == [pytest.approx(-0.6)]
    assert measures.differences(one, none) == []


def test_coefficients_that_go_together_are_one_number():
    """Three apart are three; three that are one and the same are one; unknown ones count not."""

    def independent(matrix):
        return measures.independent_of({"correlation": {"matrix": matrix}})

    assert independent(np.eye(3).tolist()) == pytest.approx(3)
    assert independent(np.ones((3, 3)).tolist()) == pytest.approx(1)
    assert independent([[1, 0, None], [0, 1, None], [None, None, None]]) == pytest.approx(2)


def test_a_ratio_has_the_error_of_its_pointings():
    """Of residuals alike it is none; of independent ones it falls with the root of their number."""
    rng = np.random.default_rng(1)
    ours, theirs = rng.normal(size=(2, 400, 2))

    assert huber.ratio_sigma(theirs, theirs) < 1e-12
    # Either rms of 800 numbers is known to 1 / sqrt(2 * 800).
    assert huber.ratio_sigma(ours, theirs) == pytest.approx(np.sqrt(2 / 1600), rel=0.25)


def test_sigmas_below_the_rounding_are_counted():
    """Offsets in whole tens of arcsec give no term to a millionth of one."""
    some = replace(drawn(), step_arcsec=10.0)
    fit = {"parameters": [parameter("skew", 1.0, 1e-6), parameter("collimation", 1.0, 50.0)]}

    assert measures.below_rounding(some, fit) == 1


@pytest.mark.parametrize(
    ("before", "after", "worse"), [(3.6, 326.0, 1), (3.6, 3.5, 0), (3.6, 3.6, 0), (None, 3.0, 0)]
)
def test_a_finding_is_worse_when_held_out_readings_are(before, after, worse):
    """As in the report, whole and by finding."""
    heldout = {"rms_before_arcsec": before, "rms_after_arcsec": after}
    told = measures.of_findings(report({"heldout": heldout}, fit={"heldout": heldout}))

    assert told["worse"] == worse
    assert (told["total"] is None) == (before is None)


@pytest.mark.parametrize(
    ("kept", "verdict", "unstable"), [(9, "named", 1), (39, "named", 0), (9, "ambiguous", 0)]
)
def test_a_name_that_does_not_come_back_is_unstable(kept, verdict, unstable):
    """Less than four of five."""
    finding = {"verdict": verdict, "stability": {"draws": 40, "kept": kept}}

    assert measures.of_findings(report(finding))["unstable"] == unstable


STEP = {"when": "2020-02-01 12:00:00+00:00", "within_h": 1.0, "p10": -2.0, "p11": 5.0}


def _since(when, axes=("xel", "el")):
    return {"where": {"axes": list(axes), "since": when}, "parameters": [parameter("b[x]", 2.0)]}


@pytest.mark.parametrize(
    ("kind", "fact", "told", "passed"),
    [
        ("step", STEP, report(_since("2020-02-01T11:20:00Z")), True),
        ("step", STEP, report(_since("2020-02-01T10:20:00Z")), False),
        ("step", STEP, report(_since("2020-02-01T11:20:00Z", ["el"])), False),
        (
            "step",
            STEP,
            report(_since("2020-02-01T11:20:00Z"), _since("2020-02-05T00:00:00")),
            False,
        ),
        ("step", STEP, report(), False),
        ("only", {"effects": ["clock"]}, report({}), True),
        ("only", {"effects": ["drift"]}, report({}), False),
        ("lacks", {"effects": ["clock"]}, report({}), False),
        ("lacks", {"effects": ["drift"]}, report({}), True),
        (
            "change",
            {"parameter": "tilt_", "arcsec": 5.0},
            report({"parameters": [parameter("tilt_north[b]", 3.0), parameter("tilt_east[b]", 4)]}),
            True,
        ),
        (
            "change",
            {"parameter": "tilt_", "arcsec": 9.0},
            report({"parameters": [parameter("tilt_north[b]", 3.0), parameter("tilt_east[b]", 4)]}),
            False,
        ),
        ("change", {"parameter": "sag_", "arcsec": 5.0}, report({}), False),
        (
            "change_or_asked",
            {"parameter": "sag_", "arcsec": 5.0, "words": "add a session"},
            report(warnings=["add a session to see it"]),
            True,
        ),
        (
            "says",
            {"words": "tilts? differ", "under": ["two_axes"]},
            report(two_axes=[{"sentence": "the Tilts differ"}]),
            True,
        ),
        ("says", {"words": "tilts? differ", "under": ["two_axes"]}, report(two_axes=[]), False),
        ("silent", {"words": "too few"}, report(warnings=["too few rows"]), True),
        ("silent", {"words": "too few"}, report({}, warnings=["too few rows"]), False),
        ("silent", {"words": "too few"}, report(), False),
        ("no_number_above_data", {}, report({"parameters": [parameter("a", 50.0)]}), True),
        ("no_number_above_data", {}, report({"parameters": [parameter("a", 5000.0)]}), False),
        ("no_number_above_data", {}, report({"true_rms_arcsec": 5000.0}), False),
    ],
)
def test_facts_are_looked_for(kind, fact, told, passed):
    """Each kind passes where it should and nowhere else."""
    _, found = published.KINDS[kind](drawn(), told, {"parameters": [], "warnings": []}, fact)

    assert found is passed


def test_a_sky_rms_is_that_of_the_published_terms():
    """Recordings of zeros alone are left with their noise on the sky, sqrt(2) of an axis."""
    some = drawn(400, nights=1)
    fact = {
        "terms": {
            "IA": ["azimuth_zero", 1],
            "IE": ["elevation_zero", -1],
            "CA": ["collimation", 1],
        }
    }
    truth = np.zeros(7)
    truth[:3] = 30.0
    noise = some.offsets() - some.columns() @ (10.0 * np.arange(1, 8))
    x, y = (some.columns() @ truth + noise).T
    columns = some.table | {"d_xel_arcsec": x, "d_el_arcsec": y}
    some = replace(some, table=columns, x=x, y=y)

    told, right = published.KINDS["sky_rms"](
        some, report(), {}, fact | {"after": 3 * math.sqrt(2), "within": 0.3}
    )
    assert right, told


def test_the_table_of_facts_is_whole():
    """Every set has a reader and a source, every fact a kind; nothing is named twice."""
    entries = sets.catalogue()
    names = [one["name"] for one in entries]

    assert len(set(names)) == len(names)
    for one in entries:
        assert one["format"] in {*readers.READERS, "simulated"}
        assert one["source"]
        assert all(fact["kind"] in published.KINDS for fact in one.get("fact", ()))


def test_sets_are_chosen_by_how_they_begin():
    """Whatever its case; a name that no set begins with is refused."""
    assert {one["name"] for one in table.chosen(["gmrt 2003-06"])} == {
        *("GMRT 2003-06-01", "GMRT 2003-06-02", "GMRT 2003-06-05")
    }
    with pytest.raises(KeyError):
        table.chosen(["nowhere"])


def test_a_shipped_day_is_read_with_its_antennas():
    """Rows, sites and hour angles of the GMRT; what was excluded is not there."""
    (entry,) = table.chosen(["GMRT 2003-06-01"])
    some = sets.read(entry, None)

    assert isinstance(some, sets.Recordings)
    assert len(np.unique(some.group)) == 29
    assert np.isfinite(some.y).all()
    assert np.isnan(some.x).all()


def test_a_public_set_without_its_folder_is_said_to_be_absent(tmp_path):
    """The file's name is told."""
    (entry,) = table.chosen(["JCMT"])

    assert "harp" in str(sets.read(entry, tmp_path))


@pytest.mark.skipif(not DATA.is_dir(), reason="the folder of public recordings is not there")
@pytest.mark.parametrize(
    ("name", "rows", "nights"),
    [
        ("AuxTel 2022-04-06", 54, 1),
        ("LMT", 134, 2),
        ("IRAM 2015-03", 201, 9),
        ("MMT together, in order only", 342, 4),
        ("RTS2", 235, 2),
        ("MeerKAT", 8, 1),
        ("JCMT", 16, 1),
    ],
)
def test_every_format_is_read(name, rows, nights):
    """As many rows as there are; offsets of seconds and minutes of arc."""
    (entry,) = table.chosen([name])
    some = sets.read(entry, DATA)

    assert isinstance(some, sets.Recordings)
    assert (len(some), len(np.unique(some.night))) == (rows, nights)
    assert np.nanmax(np.abs(some.offsets())) < 3600
    assert np.all((some.el > 0) & (some.el < np.pi / 2))


@pytest.mark.skipif(not DATA.is_dir(), reason="the folder of public recordings is not there")
def test_two_readers_of_equatorial_records_agree():
    """The examiner's and the program's, each with its refraction: 1 arcsec at 20 deg."""
    (entry,) = table.chosen(["JCMT"])
    some = sets.read(entry, DATA)
    ours = recordings.read(DATA / "jcmt/harp20070702.dat")

    np.testing.assert_allclose(some.el, ours.at.el, atol=1 / 206265)
    np.testing.assert_allclose(some.y, np.degrees(ours.y) * 3600, atol=1)


@pytest.mark.slow
def test_a_set_is_measured_and_goes_on_where_it_stopped(tmp_path, monkeypatch):
    """Every column has its number; the second run reads the first one's row."""
    some = replace(drawn(150, 5), facts=({"kind": "lacks", "says": "none", "effects": ["clock"]},))
    monkeypatch.setattr(sets, "read", lambda *_: some)
    monkeypatch.setattr(measures, "FINDING_SPLITS", 1)
    (row,) = table.rows([{"name": "drawn"}], None, 2, tmp_path / "real.jsonl")

    assert row.in_fit == pytest.approx(1, abs=0.3)
    assert row.scheme == "nights"
    assert row.pairs == 7 * measures.SPLITS
    assert row.few == 2
    assert row.checks[0].passed
    monkeypatch.setattr(sets, "read", lambda *_: pytest.fail("done again"))
    (again,) = table.rows([{"name": "drawn"}], None, 2, tmp_path / "real.jsonl")
    assert again == row


def test_the_table_says_what_is_missed():
    """Each target that is missed is in the failures, on the page and in the text."""
    good = measures.Row("good", 100, 4, in_fit=1.0, across=1.0, rms_z=1.0, agreement=(4, 5))
    bad = replace(
        good, name="bad", in_fit=1.2, across=1.1, rms_z=2.0, worse=1, total=(3.0, 4.0),
        unstable=1, agreement=(1, 5), below_rounding=1, few=10, few_worse=1,
        checks=(published.Check("a step", "none", passed=False),),
    )  # fmt: skip

    assert table.failures(good) == []
    assert len(table.failures(bad)) == 10
    assert "1 of 2 sets meet every target" in table.text([good, bad], [])
    assert "| bad | a step | none | **no** |" in table.markdown([good, bad], ["lost: not there"])
    assert json.dumps(table.failures(measures.Row("x", 1, 1))) == '["not examined"]'


REAL = """# Recordings

| set | rows | nights | in fit | total, arcsec |
| --- | --- | --- | --- | --- |
| Here 1 | 20 | 2 | 1.000 | 3.00 to 2.00 |
| There | 30 | 1 | 1.000 | - |

## What was published, and what came out

| set | published | found | |
| --- | --- | --- | --- |
| Here 1 | a step | a step | yes |

## Findings

- Here 1: drift, named
- There: none

## Targets missed

- Here 1: one
"""


def test_a_case_study_is_filled_from_the_table_of_real_recordings():
    """Rows, facts and findings of its sets and of no other; what stood there before is gone."""
    page = "# A\n\n<!-- real: Here -->\nold\n<!-- end of real -->\n\nwords\n"
    text = studies.filled(page, REAL)

    assert "| Here 1 | 20 | 2 | 3.00 to 2.00 arcsec |" in text
    assert "| Here 1 | a step | a step | yes |" in text
    assert text.count("- Here 1") == 1
    assert "There" not in text
    assert "old" not in text
    assert text.endswith("\n\nwords\n")
    assert studies.filled(text, REAL) == text


def test_a_study_of_no_set_is_refused():
    """Its sets are named as the table names them."""
    with pytest.raises(BadInput, match="has no set Nowhere"):
        studies.filled("<!-- real: Nowhere -->\n<!-- end of real -->", REAL)


@pytest.mark.parametrize("study", ["gmrt", "published-table", *studies.PICTURES])
def test_the_manual_s_case_studies_are_those_of_the_table(study):
    """`pyport dev trials page` was called after `pyport dev real`; the picture is there."""
    docs = Path(__file__).parents[2] / "docs"
    text = (docs / "proof" / f"{study}.md").read_text("utf-8")
    pictures = re.findall(r"!\[[^\]]*\]\((.*?)\)", text)

    assert studies.filled(text, (docs / "real.md").read_text("utf-8")) == text
    assert pictures
    assert all((docs / "proof" / one).is_file() for one in pictures)


def test_a_picture_is_drawn_of_recordings(tmp_path, monkeypatch):
    """Residuals of both axes; where the recordings are not there it is said."""
    data = tmp_path / "data.csv"
    rng = np.random.default_rng(3)
    lines = ["# latitude_deg: 50", "time_utc,session,az_deg,el_deg,d_xel_arcsec,d_el_arcsec"]
    for n in range(40):
        az, el, x, y = *rng.uniform((0, 20), (360, 80)), *rng.normal(0, 2, 2)
        when = f"2004-01-0{1 + n // 20}T{n % 20:02}:00:00Z"
        lines.append(f"{when},N{n // 20},{az:.4f},{el:.4f},{x:.2f},{y:.2f}")
    data.write_text("\n".join([*lines, ""]))
    entry = {"name": "One", "format": "recordings", "files": ["data.csv"]}
    monkeypatch.setattr(sets, "catalogue", lambda: [entry])
    monkeypatch.setitem(studies.PICTURES, "one", (("One",), "time", ("2004-01-02", "then")))

    studies.draw("one", tmp_path, tmp_path / "one.png")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    assert "not there" in studies.draw("one", tmp_path / "other", tmp_path / "two.png")
