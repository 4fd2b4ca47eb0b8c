"""What must not matter to a diagnosis: order of rows, jobs, locale, time zone, rows told twice."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import write_recordings
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.recordings import read

ROWS = 200


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return recordings with one cause hidden, simulated."""
    path = tmp_path_factory.mktemp("night") / "night.csv"
    write_recordings(Spec("one", "one", "refraction", 1.0, ROWS).make(5), path)
    return path


def diagnosed(*files, out, jobs=1, **environment):
    """Diagnose files as a user does; return what is written about each."""
    subprocess.run(
        [sys.executable, "-m", "pyport", "diagnose", *map(str, files), "--out", str(out),
         "--jobs", str(jobs), "--quiet"],
        check=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment},
    )  # fmt: skip
    return [(out / file.stem / "report.json").read_text() for file in files]


@pytest.fixture(scope="module")
def plain(night, tmp_path_factory):
    """Return the diagnosis of the recordings as they are."""
    (told,) = diagnosed(night, out=tmp_path_factory.mktemp("plain"))
    return told


def rewritten(night, path, change):
    """Write the recordings with their rows changed; return the path."""
    lines = night.read_text().splitlines(keepends=True)
    head = next(n for n, line in enumerate(lines) if not line.startswith("#")) + 1
    path.write_text("".join([*lines[:head], *change(lines[head:])]))
    return path


def named(report):
    """Return what was found: effects and verdicts, and the first one's numbers."""
    found = report["findings"]
    return [(one["effect"], one["verdict"]) for one in found]


@pytest.mark.parametrize(
    "environment",
    [
        {"TZ": "Pacific/Kiritimati"},
        {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"},
        {"LC_ALL": "C", "PYTHONUTF8": "0"},
        {"PYTHONHASHSEED": "7"},
    ],
)
def test_surroundings_change_no_byte(night, plain, tmp_path, environment):
    """Zone, locale, encoding and the order of sets are no part of the answer."""
    (told,) = diagnosed(night, out=tmp_path, **environment)

    assert told == plain


def test_jobs_change_no_byte(night, plain, tmp_path):
    """Two files by two processes say what each says alone."""
    again = tmp_path / "again.csv"
    again.write_bytes(night.read_bytes())
    told = diagnosed(night, again, out=tmp_path / "out", jobs=2)
    before, after = json.loads(plain), json.loads(told[1])
    files = [one.pop("files") for one in (before, after)]
    models = [one.pop("completed_model") for one in (before, after)]

    assert told[0] == plain
    assert after.pop("input") == before.pop("input") | {"file": "again.csv"}
    assert after == before
    assert {**models[0], "made": None} == {**models[1], "made": None}
    # the page and the pictures have the file's name in their titles
    assert files[0].keys() == files[1].keys()
    assert files[0]["rows.csv"] == files[1]["rows.csv"]


def test_the_order_of_rows_changes_nothing_but_rounding(night, plain, tmp_path):
    """The same findings, the same numbers far within their sigmas."""
    order = np.random.default_rng(1).permutation(ROWS)
    path = rewritten(night, tmp_path / "night.csv", lambda rows: [rows[n] for n in order])
    (told,) = diagnosed(path, out=tmp_path)
    before, after = json.loads(plain), json.loads(told)

    assert named(before)
    assert named(after) == named(before)
    for one, other in zip(before["findings"], after["findings"], strict=True):
        for mine, yours in zip(one["parameters"], other["parameters"], strict=True):
            assert yours["value"] == pytest.approx(mine["value"], abs=0.1 * mine["sigma"])
            assert yours["sigma"] == pytest.approx(mine["sigma"], rel=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_rows_changes_a_fit_by_rounding(night, seed):
    """Coefficients, errors and condition number to a millionth of a sigma, whatever the order."""
    known = read(night)
    order = np.random.default_rng(seed).permutation(len(known))
    for model in ("altaz", "rt32-approximate"):
        one, other = (fit(rows, load(model)) for rows in (known, known.take(order)))
        for mine, yours in zip(one.coefficients, other.coefficients, strict=True):
            np.testing.assert_allclose(
                yours.value, mine.value, rtol=0, atol=1e-6 * mine.sigma.max()
            )
            np.testing.assert_allclose(yours.sigma, mine.sigma, rtol=1e-6)
        assert other.condition == pytest.approx(one.condition, rel=1e-6)


def test_rows_told_twice_make_nothing_surer(night, plain, tmp_path):
    """Every row a second time: excluded, each with its reason; every number as before."""
    path = rewritten(night, tmp_path / "night.csv", lambda rows: rows + rows)
    (told,) = diagnosed(path, out=tmp_path)
    before, after = json.loads(plain), json.loads(told)
    aside = after["input"].pop("set_aside")

    assert len(aside) == ROWS
    assert all("the same as line" in one["reason"] for one in aside)
    assert before["input"]["used"] == after["input"]["used"]
    del before["input"], after["input"], before["files"], after["files"]
    models = [one.pop("completed_model") for one in (before, after)]
    assert after == before
    assert {**models[0], "made": None} == {**models[1], "made": None}
