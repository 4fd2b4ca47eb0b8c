"""Reading 100,000 recordings, beside astropy's own CSV reader on the same file."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.recordings import read

ROWS = 100_000


@pytest.fixture(scope="module")
def big_file(tmp_path_factory):
    """Write a night of many recordings and return its path."""
    rng = np.random.default_rng(1)
    path = tmp_path_factory.mktemp("big") / "night.csv"
    azimuth, elevation = rng.uniform(-270, 270, ROWS), rng.uniform(5, 85, ROWS)
    offsets = rng.normal(0, 10, (2, ROWS))
    with path.open("w") as file:
        file.write("# latitude_deg: 53\naz_deg,el_deg,d_xel_arcsec,d_el_arcsec,source,time_utc\n")
        file.writelines(
            f"{a:.5f},{e:.5f},{x:.3f},{y:.3f},3C84,2003-06-01T12:00:00.5Z\n"
            for a, e, x, y in zip(azimuth, elevation, *offsets, strict=True)
        )
    return path


@pytest.mark.benchmark(group="read 100,000 rows of CSV")
def test_pyport(benchmark, big_file):
    """Read, check and interpret the file."""
    night = benchmark.pedantic(read, (big_file,), rounds=3)

    assert len(night) == ROWS


@pytest.mark.benchmark(group="read 100,000 rows of CSV")
def test_astropy(benchmark, big_file):
    """Read the same cells with astropy, nothing interpreted."""
    from astropy.table import Table

    table = benchmark.pedantic(
        Table.read, (big_file,), {"format": "ascii.csv", "comment": "#"}, rounds=3
    )

    assert len(table) == ROWS
