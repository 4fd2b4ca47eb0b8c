"""Measurements told again, word for word or with another last digit, make nothing surer."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import pytest

from pyport.diagnosis.diagnose import diagnose
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import write_recordings
from pyport.formats.models import load
from pyport.noise.pointings import pointings
from pyport.recordings import read

OFFSETS, PLACES = ("d_az_deg", "d_el_deg"), ("az_deg", "el_deg")


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return the lines before the table, the names of its columns and its rows."""
    path = tmp_path_factory.mktemp("night") / "night.csv"
    write_recordings(Spec("one", "one", "refraction", 1.0, 160).make(2), path)
    lines = path.read_text().splitlines()
    head = next(n for n, line in enumerate(lines) if not line.startswith("#"))
    return lines[:head], lines[head].split(","), [line.split(",") for line in lines[head + 1 :]]


def found(night, rows, path, without=()):
    """Write rows, diagnose them, and return the chance of noise and the first finding's sigma."""
    head, names, _ = night
    kept = [n for n, name in enumerate(names) if name not in without]
    table = [names, *rows]
    path.write_text("\n".join([*head, *(",".join(row[n] for n in kept) for row in table)]) + "\n")
    done = diagnose(read(path), load("altaz"))
    assert done.findings[0].effect == "refraction"
    return done.p_value, done.findings[0].parameters[0].sigma


def jittered(night, row, which, rng):
    """Return a row with the last digit of some of its cells changed by one."""
    row = list(row)
    for n, name in enumerate(night[1]):
        up = rng.choice([-1, 1])
        if name not in which or not row[n]:
            continue
        if name == "time_utc":
            moved = datetime.fromisoformat(row[n]) + timedelta(milliseconds=int(up))
            row[n] = moved.isoformat(timespec="milliseconds").replace("+00:00", "Z")
        else:
            digits = len(row[n].partition(".")[2])
            row[n] = f"{float(row[n]) + up * 10.0**-digits:.{digits}f}"
    return row


@pytest.mark.parametrize(
    ("which", "times", "share", "without"),
    [
        ((), 1, 0.4, ()),
        ((), 1, 1.0, ("time_utc",)),
        (OFFSETS, 1, 0.4, ()),
        ((*OFFSETS, *PLACES, "time_utc"), 3, 1.0, ()),
        ((*OFFSETS, *PLACES), 3, 1.0, ("time_utc", "hour_angle_h")),
    ],
)
def test_told_again_it_is_no_surer(night, tmp_path, which, times, share, without):
    """Some rows or all, once or three times more, with a time or without."""
    rng = np.random.default_rng(4)
    rows = night[2]
    again = [
        jittered(night, row, which, rng)
        for row in rows
        for _ in range(times)
        if rng.random() < share
    ]
    chance, sigma = found(night, rows, tmp_path / "once.csv", without)
    again_chance, again_sigma = found(night, rows + again, tmp_path / "again.csv", without)

    assert again_sigma > 0.9 * sigma
    # Taken for pointings of their own, twice the rows would double the logarithm.
    assert np.log10(again_chance) > 1.6 * np.log10(chance) - 3


def test_a_chain_of_readings_is_no_single_pointing(tmp_path):
    """Rows less than a second apart, each near to the next: a pointing lasts a second, no more."""
    path = tmp_path / "chain.csv"
    rows = [f"10,{20 + 0.001 * n},1,2003-06-01T10:00:{0.4 * n:06.3f}" for n in range(60)]
    path.write_text("az_deg,el_deg,d_el_arcsec,time_utc\n" + "\n".join(rows) + "\n")

    assert pointings(read(path)).tolist() == np.repeat(range(20), 3).tolist()
