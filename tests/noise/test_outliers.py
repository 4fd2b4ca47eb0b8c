"""Outliers that are most of a session, a receiver or a source are no gross errors; that is said."""

import numpy as np
import pytest

import pyport
from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.noise.outliers import shared
from pyport.prediction import words
from pyport.prediction.compare import compare
from pyport.recordings.from_table import from_table
from pyport.recordings.schema import stack
from pyport.report.folder import text
from pyport.report.made import report_of

NIGHTS, EACH = 4, 24


def night(off_arcsec, label="session", only=None):
    """Return a table of four nights by noise of 2 arcsec; the last label is off across."""
    rng = np.random.default_rng(5)
    n = NIGHTS * EACH
    names = np.array([f"s{n}" for n in np.arange(n) // EACH])
    of_label = names if label == "session" else np.roll([f"s{n}" for n in np.arange(n) % 12], 5)
    off = of_label == ("s3" if only is None else only)
    start = np.datetime64("2025-03-01T20:00")
    return {
        "time_utc": start + (np.arange(n) // EACH * 1440 + np.arange(n) % EACH * 9).astype("m8[m]"),
        "az_deg": rng.uniform(0, 360, n),
        "el_deg": rng.uniform(20, 80, n),
        "d_xel_arcsec": rng.normal(0, 2, n) + off_arcsec * off,
        "d_el_arcsec": rng.normal(0, 2, n),
    } | {"session": names, label: of_label}


def test_a_fit_a_prediction_and_a_diagnosis_say_it():
    """Of a night that is 20 arcsec off, the same sentence with the numbers of each."""
    table = night(20.0)
    read = from_table(table)
    predicted = words.text(compare(read, load("altaz")))
    said = [
        "\n".join(pyport.fit(table).report["warnings"]),
        predicted,
        text(report_of(diagnose(read, load("altaz")))),
    ]

    for one in said:
        plain = " ".join(one.split())
        assert "outliers are in session s3 (" in plain
        assert f"of its {EACH} pointings): the telescope was in another state then" in plain
    assert "beside the outliers, which are no gross errors" in " ".join(said[2].split())


@pytest.mark.parametrize("label", ["source", "receiver"])
def test_a_source_and_a_receiver_are_named(label):
    """Eight pointings of one name, all of them outliers."""
    (said,) = _said(night(0.0, label), label, "s7", 8)

    assert said.startswith(f"8 of 8 outliers are in {label} s7 (8 of its 8 pointings)")


@pytest.mark.parametrize(("count", "said"), [(3, 0), (4, 0), (5, 1), (8, 1)])
def test_most_of_a_label_are_outliers(count, said):
    """Half of eight pointings are not most of them."""
    assert len(_said(night(0.0, "source"), "source", "s7", count)) == said


def test_a_session_is_named_once():
    """What the sentence of a session has is not said again of the sources in it."""
    table = night(0.0) | {"source": np.repeat([f"a{n}" for n in range(12)], 8)}
    (said,) = _said(table, "session", "s1", EACH)

    assert "session s1" in said


def test_scattered_outliers_are_gross_errors():
    """Four readings of four nights say nothing, and a file of one session is not most of itself."""
    read = from_table(night(0.0))
    used = np.ones(2 * NIGHTS * EACH, bool)
    used[:: 2 * EACH] = False

    assert list(shared(read, stack(read), used)) == []

    alone = from_table(night(0.0) | {"session": np.full(NIGHTS * EACH, "s0")})
    assert list(shared(alone, stack(alone), np.zeros(len(used), bool))) == []


def _said(table, label, name, count):
    """Return what is said where the first offsets across of one label are outliers."""
    read = from_table(table)
    numbers = stack(read)
    used = np.ones(len(numbers), bool)
    used[np.flatnonzero(read.label(label).astype(str)[numbers.row] == name)[:count]] = False
    return list(shared(read, numbers, used))


def test_the_first_pointings_after_slews_are_named():
    """Those of tracks of eight; not where every pointing is slewed to."""
    table = night(0.0)
    step = np.arange(NIGHTS * EACH)
    table["az_deg"] = 60.0 * (step // 8 % 3) + 10 * (step // 24) + step % 8
    first = (step % 8 == 0) & (step > 0)
    read = from_table(table)
    own = stack(read)
    said = list(shared(read, own, ~(first[own.row] & own.is_y)))

    assert len(said) == 1
    assert "11 of 11 outliers are the first after the longest slews (" in said[0]
    everywhere = from_table(night(0.0))
    assert not list(shared(everywhere, stack(everywhere), ~(first[own.row] & own.is_y)))
