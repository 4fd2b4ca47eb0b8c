"""The nights that the watch is measured on, and public recordings replayed to it."""

import os
from pathlib import Path

import numpy as np
import pytest

from pyport.examiner.nights import nights, replays
from pyport.examiner.nights.nights import Case, Step
from pyport.examiner.real import sets
from pyport.watch.detection import composite

DATA = Path(os.environ.get("PYPORT_SHARED_DATA", "../shared/data"))


def test_a_case_is_determined_by_its_kind_number_and_seed():
    """Drawn twice, it is the same; the step is what it says."""
    one, same = (nights.draw(Case("white", 7, 1, step=True)) for _ in range(2))
    moved = one.step.offset[one.step.first :]

    assert np.array_equal(one.noise, same.noise)
    assert np.array_equal(one.watched["d_el_arcsec"], same.watched["d_el_arcsec"])
    assert one.step.size == 3.0
    assert not one.step.offset[: one.step.first].any()
    acts = np.any(moved != 0, axis=0).sum()
    assert np.sqrt((moved**2).sum() / (len(moved) * acts)) / one.sigma == pytest.approx(3, rel=0.3)


def test_the_best_delay_is_lorden_s():
    """A CUSUM of a known shift needs the logarithm of the run length over the information."""
    rng = np.random.default_rng(2)
    delays = []
    for _ in range(300):
        offset = np.zeros((400, 2))
        offset[50:, 1] = 1.0
        step = Step("elevation_zero", 50, 1.0, offset, offset[:, 1], {})
        delays.append(nights.best_delay(step, rng.standard_normal((400, 2)), 10_000))

    assert np.mean(delays) == pytest.approx(np.log(10_000) / 0.5, rel=0.15)


def test_the_boundary_keeps_the_run_length():
    """Without any shift the CUSUM passes it as rarely as it should."""
    rng = np.random.default_rng(3)
    shift, wanted = 1.5, 200.0
    boundary = shift * nights._boundary(shift, wanted)
    lengths = []
    for _ in range(400):
        total, n = 0.0, 0
        while total < boundary:
            total = max(0.0, total + shift * rng.standard_normal() - shift**2 / 2)
            n += 1
        lengths.append(n)

    assert np.mean(lengths) == pytest.approx(wanted, rel=0.2)


@pytest.mark.slow
def test_outcomes_are_kept_and_summed_up(tmp_path):
    """A run that is called again goes on; the tables count what there is."""
    cases = [*nights.null_cases(5, 1), *nights.step_cases(2, 1)]
    file = tmp_path / "nights.jsonl"
    found = list(replays.outcomes(cases, file, 10_000.0))
    assert list(replays.outcomes(cases, file, 10_000.0)) == found
    assert len(file.read_text().splitlines()) == len(cases)
    nulls = [one for one in found if not one["step"]]
    assert "5 nights; 0.0 false alarms are promised at most" in replays.of_nulls(nulls, 1e4)
    assert "2/2" in replays.of_steps([one for one in found if one["step"]])


def real(name):
    """Return public recordings as the examiner reads them."""
    if not DATA.is_dir():
        pytest.skip(f"no public recordings in {DATA}: PYPORT_SHARED_DATA names their folder")
    return sets.read(next(one for one in sets.catalogue() if one["name"] == name), DATA)


@pytest.mark.slow
def test_known_events_of_public_recordings_are_raised():
    """Within as many pointings as the manual says, and some to spare."""
    found = replays._replayed(real("MMT together"), 10_000.0)

    said = [delay for _, delay in found.known]
    assert all(one <= most + 2 for one, most in zip(said, [10, 4, 12], strict=True))
    assert "known: " in replays.text(found)


@pytest.mark.parametrize(
    ("name", "delays"), [("IRAM 2015-03", [None]), ("MMT together", [4, 2, 2])]
)
def test_what_the_best_rule_makes_of_known_events(name, delays):
    """Knowing shape, size, moment and noise: the dampers do not show in the drift of the nights."""
    found, promise = real(name), 10_000.0
    known = [(replays._seconds(since), effect) for since, _, effect in replays.KNOWN[name]]
    best = replays.best(found.table, found.header, found.model, known, promise)

    assert [one.delay for one in best] == delays
    assert all((one.delay is None) == (one.most < np.log10(promise)) for one in best)


def test_the_best_rule_needs_what_wald_says():
    """In white noise a known step is seen after the logarithm of the rate over its information."""
    rng = np.random.default_rng(4)
    az, el = rng.uniform(0, 360, 300), rng.uniform(20, 80, 300)
    table = {
        "time_utc": np.datetime64("2024-01-01") + np.arange(300) * np.timedelta64(60, "s"),
        "az_deg": az,
        "el_deg": el,
        "d_xel_arcsec": 5 * rng.standard_normal(300),
        "d_el_arcsec": 5 * rng.standard_normal(300) + 5 * (np.arange(300) >= 150),
    }
    since = float(table["time_utc"][150].astype("datetime64[s]").astype(float))
    header = {"latitude_deg": 30.0, "longitude_deg": 0.0, "height_m": 0.0}
    (one,) = replays.best(table, header, "altaz", [(since, "elevation_zero")], 10_000.0)

    assert one.delay == pytest.approx(np.log(10_000) / 0.5, rel=0.5)
    # what the zero was before must be learnt too
    assert 4 < one.most < 150 * 0.5 / np.log(10)


@pytest.mark.slow
def test_a_wilder_night_is_no_change(monkeypatch):
    """A drift four times that of the past is none; by the noise of the past alone it would be."""
    case = Case("drift-2h", 0, 1, wilder=4.0)
    assert nights.examine(case, 10_000.0)["raised"] == []
    monkeypatch.setattr(composite, "WILDER", ())
    assert len(nights.examine(case, 10_000.0)["raised"]) > 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["IRAM 2013-10"])
def test_what_a_model_leaves_out_is_no_change(name):
    """The collimation follows the focus: in 437 pointings not one alarm of a change."""
    found = replays._replayed(real(name), 10_000.0)

    assert (found.nights, found.pointings, found.changes) == (3, 437, 0)
    assert any("collimation follows focus_z_mm" in one["sentence"] for one in found.alarms)
    assert "437 pointings, 0 alarms of a change" in replays.total([found], 10_000.0)
