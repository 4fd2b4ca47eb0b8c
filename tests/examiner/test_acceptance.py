"""Figures of acceptance: what counts as right, and that real lists are read as published."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pyport.examiner.acceptance import drawn, gains, real
from pyport.examiner.acceptance.drawn import Line
from pyport.examiner.sealed.record.files import Rate

DATA = Path(__file__).parents[3] / "shared" / "data"


def test_every_promised_kind_of_case_is_drawn():
    """Two hundred null sets; every cause at both loudnesses; every uncatalogued cause."""
    specs = list(drawn._specs())
    groups = {one.group for one in specs}

    assert groups == {"null", "one", "unknown"}
    assert sum(one.group == "null" for one in specs) == 200
    assert {one.rho for one in specs if one.group == "one"} == {0.5, 0.25}


def test_silence_is_broken_by_more_than_one_in_twenty():
    """Five per cent of claims pass, more do not."""
    verdict, _ = drawn._solve((drawn.Spec("null", "null", rows=200, noise="white"), 1))
    quiet = [replace(verdict, claimed=False)] * 19

    assert drawn._silence([*quiet, replace(verdict, claimed=True)]).passed
    assert not drawn._silence([*quiet, *[replace(verdict, claimed=True)] * 2]).passed


def test_a_share_passes_from_its_least_on():
    """Nineteen of twenty are 95 per cent."""
    assert drawn._at_least("x", Rate(19, 20), 0.95).passed
    assert not drawn._at_least("x", Rate(18, 20), 0.95).passed


@pytest.mark.slow
def test_an_uncatalogued_cause_counts_only_when_what_it_follows_is_told():
    """A misfit that follows a column must come back unknown, with that column."""
    task = drawn.Spec("unknown", "unknown", "strange_column", 1.0, 800), 4

    assert drawn._solve(task)[0].first


def test_the_distance_of_an_edge_is_the_median_over_its_length():
    """The true edge is off by nothing, one lifted by three degrees by three."""
    az = np.arange(-60.0, 400.0, 10.0)
    el = np.degrees(drawn.rt32_edge_on_the_cable(np.radians(az - 180)))

    def found(lifted):
        curve = [{"az_deg": a, "el_deg": e + lifted} for a, e in zip(az, el, strict=True)]
        return {"where": {"curve": curve}}

    assert drawn._edge_off_deg(found(0)) == pytest.approx(0, abs=1e-9)
    assert drawn._edge_off_deg(found(3)) == pytest.approx(3)
    assert drawn._edge_off_deg({"where": {"curve": None}}) is None


@pytest.mark.slow
@pytest.mark.skipif(not DATA.is_dir(), reason="the recordings of others are not there")
def test_the_lmts_published_terms_come_out():
    """Published coefficients and rms are met, and the tilts of both axes disagree."""
    lines = {one.what: one for one in real.lmt(DATA / "lmt" / "PointingData.csv")}

    assert all(one.passed is not False for one in lines.values())
    assert isinstance(lines["LMT, xel: rms"], Line)


@pytest.mark.slow
def test_a_gain_that_is_stated_is_one_on_fresh_recordings():
    """A tilt that steps, half of whose recordings are diagnosed; 3 s, for both halves count."""
    one = gains._gain(("epoch_tilt", 502))

    assert one.effect == "epoch_tilt"
    assert one.stated > 3 * one.stated_sigma
    assert abs(one.off) < 3
    assert 0 < one.fresh_sigma < one.fresh


@pytest.mark.parametrize(("off", "passed"), [(1.0, True), (3.0, False)])
def test_gains_pass_where_nine_of_ten_are_within_two_errors(monkeypatch, off, passed):
    """Of each sign."""
    drawn = [gains.Gain("dip", 2.0 + sign * off, 0.6, 2.0, 0.8) for sign in (1, -1)]
    monkeypatch.setattr(gains, "ProcessPoolExecutor", ThreadPoolExecutor)
    monkeypatch.setattr(gains, "_gain", lambda task: drawn[task[1] % 2])
    found = {one.what: one for one in gains.lines(1, 0, 10)}

    assert found["stated gains: within two errors of the fresh gain"].passed == passed
    assert found["stated gains: fresh over stated, in all"].value == "1.000"
