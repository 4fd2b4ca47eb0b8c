"""Where no time is recorded: whether the order of the rows stands for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import Array
from pyport.effects import Circumstances
from pyport.recordings import read
from pyport.recordings.schema import Recordings
from pyport.recordings.sky import clock, horizon, with_nights


def raster() -> tuple[Array, Array]:
    """Return a grid along azimuth."""
    az, el = np.meshgrid(np.arange(10.0, 350.0, 20.0), np.arange(10.0, 80.0, 10.0))
    return az.ravel(), el.ravel()


def columns_of_elevation() -> tuple[Array, Array]:
    """Return a grid along elevation."""
    el, az = np.meshgrid(np.arange(10.0, 80.0, 5.0), np.arange(10.0, 350.0, 60.0))
    return az.ravel(), el.ravel()


def followed() -> tuple[Array, Array]:
    """Return one source in three nights of ten hours."""
    hour_angle = np.tile(np.radians(np.linspace(-75.0, 75.0, 40)), 3)
    az, el = horizon(hour_angle, np.full(len(hour_angle), np.radians(20.0)), np.radians(53.0))
    return np.degrees(az) % 360, np.degrees(el)


def stars() -> tuple[Array, Array]:
    """Return directions in any order."""
    rng = np.random.default_rng(1)
    return rng.uniform(0, 360, 80), rng.uniform(10, 85, 80)


def upward() -> tuple[Array, Array]:
    """Return directions sorted by elevation."""
    az, el = stars()
    return az, np.sort(el)


def rising() -> tuple[Array, Array]:
    """Return one source as it rises."""
    az, el = followed()
    return az[:20], el[:20]


def spiral() -> tuple[Array, Array]:
    """Return a sweep that goes up as it turns."""
    return np.linspace(0, 3000, 80) % 360, np.linspace(10, 85, 80)


def ring() -> tuple[Array, Array]:
    """Return directions of one elevation, in any order."""
    return np.random.default_rng(2).uniform(0, 360, 80), np.full(80, 45.0)


@pytest.mark.parametrize(
    ("places", "in_order"),
    [
        (raster, False),
        (columns_of_elevation, False),
        (followed, True),
        (stars, True),
        (ring, True),
        (upward, False),
        (rising, True),
        (spiral, True),
    ],
)
def test_order_stands_for_time_unless_the_rows_stand_in_the_order_of_places(
    tmp_path: Path, places: Callable[[], tuple[Array, Array]], *, in_order: bool
) -> None:
    """Lines of a grid, and elevations sorted, are a table's; a source moves in both."""
    az, el = places()
    path = tmp_path / "places.csv"
    lines = [f"{a:.6f},{e:.6f},1.0,2.0" for a, e in zip(az, el, strict=True)]
    path.write_text("\n".join(["az_deg,el_deg,d_xel_arcsec,d_el_arcsec", *lines]) + "\n")
    recordings = with_nights(read(path))
    assert np.isfinite(clock(recordings.at)).any() == in_order
    assert ("order_from" in recordings.meta) == in_order
    assert ("no_time" in recordings.meta) != in_order


def timed(time: Array) -> Recordings:
    """Return recordings at some times, one a line, in places of no order."""
    n = len(time)
    az, el = np.radians(stars())[:, :n]
    nothing = np.full(n, np.nan)
    at = Circumstances(az, el, None, {"time": time})
    return Recordings(
        at, np.zeros(n), np.zeros(n), nothing, nothing, np.arange(n) + 2, Path("made")
    )


def test_a_row_without_a_time_has_that_of_the_nearest_row() -> None:
    """So that one blank cell hides neither nights nor drifts; the report says it."""
    time = 1e9 + 60.0 * np.arange(40.0) + 86400.0 * (np.arange(40) >= 20)
    blank = time.copy()
    blank[[7, 19, 20, 39]] = np.nan
    found = with_nights(timed(blank))

    assert clock(found.at)[[7, 39]].tolist() in ([time[6], time[38]], [time[8], time[38]])
    assert clock(found.at)[[19, 20]].tolist() == [time[18], time[21]]
    assert len(np.unique(found.label("session"))) == 2
    assert found.meta["times_from"] == "the nearest rows of the file for 4 of them"
    assert "times_from" not in with_nights(timed(time)).meta


@pytest.mark.parametrize(("blank", "counts"), [(20, True), (21, False), (40, False)])
def test_times_count_where_half_of_the_rows_have_one(blank: int, *, counts: bool) -> None:
    """Else the order of the rows stands for them."""
    time = 1e9 + 60.0 * np.arange(40.0)
    time[:blank] = np.nan
    found = with_nights(timed(time))

    assert ("time" in found.at) == counts
    assert ("order" in found.at) != counts
    assert ("order_from" in found.meta) != counts


def test_one_time_for_all_rows_is_none() -> None:
    """It says nothing of before and after; of several antennas it is the moment of a scan."""
    alone = timed(np.full(40, 1e9))
    antennas = {**alone.at.columns, "antenna": np.resize(["C00", "C01"], 40)}
    array = replace(alone, at=replace(alone.at, columns=antennas))

    assert "time" not in with_nights(alone).at
    assert with_nights(alone).meta["order_from"] == "the order of the rows, all having one time"
    assert "time" in with_nights(array).at


SMOOTH = 10.0 + 5.0 * np.sin(np.arange(60.0) / 12.0)
ROUGH = np.random.default_rng(3).normal(size=60)


@pytest.mark.parametrize(
    ("values", "blank", "taken"),
    [
        (SMOOTH, [0, 7, 8, 30, 59], 5),
        (SMOOTH, range(0, 60, 2), 30),  # half of the rows
        (SMOOTH, range(31), 0),  # most of them
        (ROUGH, [0, 7, 8, 30, 59], 0),  # drawn anew in each row
    ],
)
def test_blank_cells_of_what_is_smooth_in_time_are_taken_from_around(
    values: Array, blank: Sequence[int], taken: int
) -> None:
    """At the ends from one side; the report says in how many rows."""
    cells = values.copy()
    cells[list(blank)] = np.nan
    given = timed(1e9 + 60.0 * np.arange(60.0))
    columns = {**given.at.columns, "temperature_c": cells}
    found = with_nights(replace(given, at=replace(given.at, columns=columns)))
    known = np.isfinite(found.at.column("temperature_c"))

    assert int(known.sum()) == 60 - len(list(blank)) + taken
    if taken:
        assert found.at.column("temperature_c") == pytest.approx(values, abs=0.5)
        assert found.meta["cells_from"] == f"temperature_c in {taken} rows"
    else:
        assert "cells_from" not in found.meta


def test_no_cell_is_taken_from_another_night() -> None:
    """A night without any temperature has none."""
    time = 1e9 + 60.0 * np.arange(60.0) + 86400.0 * (np.arange(60) >= 40)
    cells = SMOOTH.copy()
    cells[40:] = np.nan
    given = timed(time)
    columns = {**given.at.columns, "temperature_c": cells}
    found = with_nights(replace(given, at=replace(given.at, columns=columns)))

    assert np.isnan(found.at.column("temperature_c"))[40:].all()
    assert "cells_from" not in found.meta


def test_directions_are_taken_around_north() -> None:
    """A wind from 350 deg before and 10 deg after was one from the north."""
    time = 1e9 + 60.0 * np.arange(40.0)
    wind = np.radians(340.0 + np.arange(40.0)) % (2 * np.pi)
    cells = wind.copy()
    cells[20] = np.nan
    given = timed(time)
    columns = {**given.at.columns, "wind_az": cells}
    found = with_nights(replace(given, at=replace(given.at, columns=columns)))

    assert np.cos(found.at.column("wind_az") - wind) == pytest.approx(1.0, abs=1e-4)
    assert found.meta["cells_from"] == "wind_az_deg in 1 row"
