"""Four real nights over four years: what changed between them is found as it was published."""

from __future__ import annotations

import csv

import pytest
from samples import sample

from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.recordings import read

NIGHTS = ("2021-08-21", "2023-07-02", "2023-09-24", "2025-03-26")


@pytest.mark.slow
def test_the_tilt_of_one_night_is_no_clock(tmp_path):
    """13.3 arcsec more toward the east in the second night, the azimuth's zero the other way."""
    head, rows = [], []
    for night in NIGHTS:
        lines = sample(f"mmt/{night}.csv").read_text().splitlines()
        head = head or [line for line in lines if line.startswith("#")]
        rows += csv.DictReader(line for line in lines if not line.startswith("#"))
    path = tmp_path / "nights.csv"
    with path.open("w", newline="") as file:
        file.writelines(f"{line}\n" for line in head)
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    found = diagnose(read(path), load("altaz"))
    (tilt,) = (
        one for one in found.findings if one.effect == "epoch_tilt" and "2023-07-02" in one.variant
    )
    east = next(one for one in tilt.parameters if one.name.startswith("tilt_east"))

    assert "epoch_clock" not in {one.effect for one in found.findings}
    assert abs(east.value - 13.3) < 2 * east.sigma
    assert east.sigma < 0.5
