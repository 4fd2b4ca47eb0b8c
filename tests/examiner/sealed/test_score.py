"""The score says what the answers were worth, and writes it down."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.cli.dev.trials import command
from pyport.examiner.sealed import examine as examining
from pyport.examiner.sealed import seal
from pyport.examiner.sealed.examine import examine
from pyport.examiner.sealed.record.files import Rate, write_recordings
from pyport.examiner.sealed.record.published import read_json
from pyport.examiner.sealed.scoring import judge as judging
from pyport.examiner.sealed.scoring import score
from pyport.examiner.sealed.scoring.judge import judge
from pyport.examiner.worlds.kinds import make_case


def finding(effect, *members, verdict="named", **more):
    """Return a finding."""
    return {"effect": effect, "class": [effect, *members], "verdict": verdict, "where": {}, **more}


def judged(findings, *causes, group="one", **facts):
    """Return the verdict on findings, for hidden causes given as (effect, class)."""
    effects = [
        {"effect": effect, "class": list(names), "parameters": {"size": 2.0}, "facts": facts}
        for effect, names in causes
    ]
    truth = {"spec": {"group": group, "rho": 1.0, "effect": "x"}, "truth": {"effects": effects}}
    report = {"mismatch": bool(findings), "findings": findings, "examined": {}}
    return judge("case-0001", truth, report)


SAG = ("sag_sine", ["sag_sine"])
LATITUDE = ("site_latitude", ["site_latitude", "tilt"])
UNCATALOGUED = ("unknown", ["unknown"])


def test_the_right_name_first_is_right():
    """A class of one that is the truth, first."""
    verdict = judged([finding("sag_sine")], SAG)

    assert (verdict.first, verdict.three, verdict.found) == (True, True, (True,))


def test_the_right_name_as_runner_up_is_among_the_first_three():
    """What came next to the first finding counts as second."""
    verdict = judged([finding("drift", evidence={"runner_up": "sag_sine"})], SAG)

    assert (verdict.first, verdict.three) == (False, True)


def test_the_fourth_is_too_late():
    """Only three are looked at, though the cause counts as found."""
    verdict = judged([*map(finding, ("drift", "skew", "tilt")), finding("sag_sine")], SAG)

    assert (verdict.three, verdict.found) == (False, (True,))


def test_a_class_of_everything_is_no_answer():
    """Naming the whole catalogue names nothing."""
    everything = finding("sag_sine", *"abcdefg", verdict="ambiguous")

    assert not judged([everything], SAG).first


def test_a_twin_wants_the_whole_class():
    """One confident name out of a class of two is the right class, but not an honest answer."""
    alone = judged([finding("tilt")], LATITUDE)
    both = judged([finding("tilt", "site_latitude", verdict="ambiguous")], LATITUDE)

    assert (alone.first, alone.whole_class) == (True, False)
    assert (both.first, both.whole_class) == (True, True)


def test_an_uncatalogued_cause_wants_unknown():
    """Any name for what is in no catalogue is wrong, and unknown is no name for what is."""
    assert judged([finding("unknown", verdict="unknown")], UNCATALOGUED).first
    assert not judged([finding("sag_sine")], UNCATALOGUED).first
    assert not judged([finding("unknown", "sag_sine", verdict="unknown")], SAG).first


def test_a_pull_is_how_many_sigmas_a_coefficient_is_off():
    """Known by the truth under its name, or by physics as the report itself expects."""
    parameters = [
        {"name": "size", "value": 2.5, "sigma": 0.25, "expected": None},
        {"name": "of_nature", "value": 19.5, "sigma": 0.5, "expected": 20.5},
        {"name": "free", "value": 3.0, "sigma": 0.1, "expected": None},
    ]
    verdict = judged([finding("sag_sine", parameters=parameters)], SAG)

    weaker = finding("sag_sine", parameters=parameters)
    again = judged([finding("sag_sine", parameters=parameters), weaker], SAG)

    assert verdict.pulls == (("sag_sine", "size", 2.0), ("sag_sine", "of_nature", -2.0))
    assert again.pulls == verdict.pulls


@pytest.mark.parametrize(("variant", "compared"), [("k = 3", 1), ("k = 30", 0), ("k = 2", 0)])
def test_coefficients_of_another_harmonic_are_others(variant, compared):
    """Three waves were hidden."""
    parameters = [{"name": "size", "value": 2.5, "sigma": 0.25, "expected": None}]
    verdict = judged([finding("sag_sine", parameters=parameters, variant=variant)], SAG, k=3)

    assert len(verdict.pulls) == compared


def test_wilson_s_interval_is_that_of_the_books():
    """10 of 100: 5.5 to 17.4 %; none of 20: 0 to 16.1 %."""
    np.testing.assert_allclose(Rate(10, 100).interval, (0.0552, 0.1744), atol=1e-4)
    np.testing.assert_allclose(Rate(0, 20).interval, (0.0, 0.1611), atol=1e-4)
    assert str(Rate(10, 100)) == "10.0 % (10 of 100; 5.5 to 17.4)"


TABLE = {
    "az_deg": ["350", "10", "80", "170", "-5"],
    "el_deg": ["20", "30", "40", "50", "60"],
    "time_utc": [f"2004-01-0{day}T00:00:00Z" for day in range(1, 6)],
}


def test_regions_overlap_in_rows_and_azimuth_goes_round():
    """A region across north holds 350, 10 and -5 degrees; the overlap counts rows."""
    north = [{"column": "az_deg", "low": 340, "high": 20}]
    low_north = [*north, {"column": "el_deg", "low": None, "high": 35}]
    first = finding("unknown", where={"region": low_north})

    np.testing.assert_array_equal(judging.inside(TABLE, north), [1, 1, 0, 0, 1])
    assert judging.region_overlap(TABLE, first, north) == pytest.approx(2 / 3)


def test_what_no_finding_places_is_nowhere():
    """The first finding that says a place counts; silence overlaps nothing and is far away."""
    north = [{"column": "az_deg", "low": 340, "high": 20}]
    vague, right = finding("drift"), finding("unknown", where={"region": north})
    cause = {"where": {"region": north, "since": "2004-01-03T12:00:00Z", "curve": None}}

    assert judging.place(TABLE, [vague, right], [cause])["region_iou"] == 1
    assert judging.place(TABLE, [], [cause]) == {"region_iou": 0, "moment_rows": np.inf}
    assert judging.place(TABLE, [right], []) == {}


def test_a_region_in_a_column_that_is_not_there_holds_nothing():
    """A place that the recordings do not have is nowhere."""
    assert not judging.inside(TABLE, [{"column": "moon_deg", "low": 0, "high": 9}]).any()


def test_curves_are_compared_in_elevation_where_the_found_one_runs():
    """The median distance over the found azimuths, the true curve interpolated round north."""
    true = [{"az_deg": az, "el_deg": 50.0 + az / 36} for az in range(0, 360, 10)]
    found = [{"az_deg": az, "el_deg": 51.5 + az / 36} for az in (15, 95, 205)]

    assert judging.curve_distance_deg({"where": {"curve": found}}, true) == pytest.approx(1.5)
    assert judging.curve_distance_deg({"where": {"curve": None}}, true) is None


def test_moments_are_compared_in_recordings():
    """Two recordings lie between noon of the first and noon of the third day."""
    found = {"where": {"since": "2004-01-01T12:00:00Z"}}

    assert judging.moment_rows(TABLE, found, "2004-01-03T12:00:00Z") == 2


@pytest.mark.parametrize(("share", "expected"), [(0.0, 0.0), (0.5, 0.75), (1.0, 1.0)])
def test_skill_is_what_was_gained_of_what_could_be(tmp_path, share, expected):
    """A tool that takes half of an effect away gains three quarters of its square."""
    case = make_case("one", 5, effect="refraction", rho=2.0, rows=400, noise="white")
    recordings, rows = tmp_path / "recordings.csv", tmp_path / "rows.csv"
    write_recordings(case, recordings)
    _predict(case, share, rows)

    gained, gainable = examining.skill(case, recordings, rows)

    assert gained / gainable == pytest.approx(expected, abs=0.03)


def _predict(case, share, path):
    """Write residuals of a base that is known exactly and of a share of the hidden effect."""
    el = np.radians(case.columns["el_deg"])
    measured = np.stack(
        [np.radians(case.columns["d_az_deg"]) * np.cos(el), np.radians(case.columns["d_el_deg"])]
    )
    columns = np.concatenate(case.base)
    form = np.concatenate(case.signature)
    values, *_ = np.linalg.lstsq(columns, form, rcond=None)
    left = (form - columns @ values).reshape(2, -1)
    base = np.stack(case.clean) - left
    lines = ["line,axis,heldout_before_arcsec,heldout_after_arcsec"]
    for axis, name in enumerate(("xel", "el")):
        before = np.degrees(measured - base)[axis] * 3600
        after = np.degrees(measured - base - share * left)[axis] * 3600
        lines += [
            f"{row + 7},{name},{b:.6f},{a:.6f}"
            for row, (b, a) in enumerate(zip(before, after, strict=True))
            if np.isfinite(b)
        ]
    path.write_text("\n".join(lines) + "\n")


def test_answers_dealt_out_at_random_score_chance():
    """Ten names, each said once: a tenth of a random deal is right."""
    verdicts = [replace(judged([finding(str(n))], SAG), spec={"effect": str(n)}) for n in range(10)]
    mean, high = examining.shuffled_key(verdicts, np.random.default_rng(1))

    assert mean == pytest.approx(0.1, abs=0.02)
    assert high < 0.5


@pytest.mark.slow
def test_metadata_that_tells_is_told(tmp_path):
    """The control would notice a column that gives the truth away, and notices none in ours."""
    paths, names = [], []
    for n, effect in enumerate(["refraction", "sag_sine"] * 6):
        case = make_case("one", 100 + n, effect=effect, rows=60)
        paths.append(tmp_path / f"{n}.csv")
        names.append(effect)
        write_recordings(case, paths[-1])
    honest = examining.metadata_only(paths, names)
    for path, effect in zip(paths, names, strict=True):
        text = path.read_text().splitlines()
        told = [f"{line},{effect == 'refraction':d}" for line in text[6:]]
        loud = [f"{text[5]},hint", *told]
        path.write_text("\n".join([*text[:5], *loud]) + "\n")

    assert honest[1] == 12
    assert examining.metadata_only(paths, names)[0] > honest[0]


@pytest.mark.slow
def test_all_right_passes_every_row_and_is_written_down(answered):
    """A set whose every answer is right passes."""
    seal.reveal(answered)

    whole = examine(answered)

    assert [row.what for row in whole.rows if row.passed is False] == []
    assert whole.passed
    assert len([row for row in whole.rows if row.passed]) >= 12
    assert "one cause: class right first" in [row.what for row in whole.rows]
    assert json.loads((answered / "score.json").read_text())["passed"]


@pytest.mark.slow
def test_silence_passes_where_nothing_is_hidden_and_nowhere_else(sealed):
    """A solver that says nothing claims nothing, finds nothing, and it is said so."""
    folder = seal.Folder(sealed)
    for one in read_json(folder.seal)["cases"]:
        report = folder.report(one["case"])
        report.parent.mkdir(parents=True)
        report.write_text(json.dumps({"mismatch": False, "findings": [], "examined": {}}))
    runner = CliRunner()
    opened = runner.invoke(command, ["reveal", str(sealed)])
    scored = runner.invoke(command, ["score", str(sealed)])

    assert opened.exit_code == scored.exit_code == 0
    assert "a-set: not passed" in scored.output
    table = {
        row["what"]: row["passed"]
        for row in json.loads((sealed / "score.json").read_text())["table"]
    }
    assert table["nothing hidden: claims anything"]
    assert table["control, amplitude zero: claims anything"]
    assert not table["one cause: class right first"]
    assert not table["a curve: distance [deg] (1)"]


def test_what_is_said_beside_counts_against_the_score():
    """A finding that means nothing hidden is wrong, and one that is part of a cause is not."""
    refraction = {**cause_of("refraction"), "beside": ["refraction_curvature"]}
    told = [finding("refraction"), finding("refraction_curvature"), finding("drift")]
    verdict = judge(
        "case-0001",
        {"spec": SPEC, "truth": {"effects": [refraction]}},
        {"mismatch": True, "findings": told, "examined": {}},
    )
    rows = {row.what: row for row in score.table([verdict])}

    assert verdict.first
    assert verdict.wrong == ("drift",)
    assert not rows["one cause: class right first and nothing wrong beside it"].passed
    assert not rows["found, and something wrong beside it"].passed
    assert judged([finding("drift")], group="null").wrong == ("drift",)


SPEC = {"group": "one", "rho": 0.5, "effect": "x", "rows": 600}


def cause_of(effect):
    """Return what a truth says of a cause."""
    return {"effect": effect, "class": [effect], "parameters": {}, "where": {}, "facts": {}}


def test_what_may_be_left_unknown_is_right_without_a_name():
    """A term driven by a condition may be unknown; another cause may not."""
    unknown = finding("unknown", verdict="unknown")

    assert judging.is_right(unknown, {**cause_of("driven_term"), "or_unknown": True})
    assert not judging.is_right(unknown, cause_of("driven_term"))


def test_antennas_and_periods_are_placed():
    """Antennas by the rows that both name; a period by how far it is off."""
    table = {"el_deg": ["1"] * 4, "antenna": ["A1", "A1", "A2", "A3"]}
    some = {**cause_of("sag_sine"), "where": {"subset": {"antenna": ["A1", "A2"]}}}
    said = finding("sag_sine", where={"subset": {"antenna": ["A1", "A3"]}})
    swing = {**cause_of("oscillation"), "facts": {"period_s": 3600.0}}
    hour = finding("oscillation", parameters=[{"name": "period", "value": 61.2}])

    assert judging.place(table, [said], [some]) == {"subset_iou": pytest.approx(0.5)}
    assert judging.place(table, [hour], [swing]) == {"period_off": pytest.approx(0.02)}
    assert judging.place(table, [], [swing]) == {"period_off": np.inf}


@pytest.mark.parametrize(("hits", "passed"), [(18, True), (13, True), (6, False)])
def test_detections_are_held_to_those_of_an_ideal_observer(hits, passed):
    """A cell fails where its whole interval is below nine tenths of what could be detected."""
    some = [
        replace(judged([finding("sag_sine")], SAG), spec=SPEC, possible=0.9, claimed=n < hits)
        for n in range(20)
    ]
    row = next(row for row in score.table(some) if row.what.startswith("600 rows, rho 0.5"))

    assert row.passed == passed
    assert row.result.startswith(f"{hits / 18:.2f} ({hits} of 18.0")


def test_findings_that_predict_worse_are_counted():
    """Worse than the base alone, against the noiseless truth, by more than answers are kept to."""
    one = replace(judged([finding("sag_sine")], SAG), spec=SPEC)
    rows = score.table([replace(one, skill=(-0.1, 0.2)), replace(one, skill=(0.1, 0.2))])
    row = next(row for row in rows if row.what == "held out: worse than without findings")

    assert (row.result[:6], row.passed) == ("50.0 %", False)
