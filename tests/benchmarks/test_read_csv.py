"""Reading 100,000 recordings, beside astropy's own CSV reader on the same file."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks import limits

from pyport.recordings import read

ROWS = {"test_read": "csv"}
RECORDINGS = 100_000


@pytest.fixture(scope="module")
def big_file(tmp_path_factory):
    """Write a night of many recordings and return its path."""
    return written(tmp_path_factory.mktemp("big") / "night.csv")


def written(path):
    """Write a night of many recordings."""
    rng = np.random.default_rng(1)
    azimuth, elevation = rng.uniform(-270, 270, RECORDINGS), rng.uniform(5, 85, RECORDINGS)
    offsets = rng.normal(0, 10, (2, RECORDINGS))
    with path.open("w") as file:
        file.write("# latitude_deg: 53\naz_deg,el_deg,d_xel_arcsec,d_el_arcsec,source,time_utc\n")
        file.writelines(
            f"{a:.5f},{e:.5f},{x:.3f},{y:.3f},3C84,2003-06-01T12:00:00.5Z\n"
            for a, e, x, y in zip(azimuth, elevation, *offsets, strict=True)
        )
    return path


def test_read(beside, big_file):
    """Read, check and interpret the file; astropy reads the same cells, nothing interpreted."""
    from astropy.table import Table
    from pyarrow import csv

    ours = beside(
        lambda: read(big_file),
        {"astropy": lambda: Table.read(big_file, format="ascii.csv", comment="#")},
        rounds=8,
        limit=limits.Limit(
            lambda: csv.read_csv(big_file, csv.ReadOptions(use_threads=False, skip_rows=1)),
            "the same cells by pyarrow, in one thread",
        ),
    )

    assert len(ours) == RECORDINGS
