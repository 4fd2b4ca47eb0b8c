"""Logs as they are: one odd cell, or a few of a hundred, change nothing of what is found."""

from __future__ import annotations

import numpy as np
import pytest

import pyport

ROWS, NIGHTS = 400, 4


def night_log():
    """Return a table of four nights: elevation drifts within hours, and azimuth has a wave."""
    rng = np.random.default_rng(8)
    night = np.arange(ROWS) * NIGHTS // ROWS
    time = 86400.0 * night + 240.0 * (np.arange(ROWS) % (ROWS // NIGHTS))
    az, el = rng.uniform(0, 360, ROWS), rng.uniform(15, 80, ROWS)
    drift, kept = np.zeros(ROWS), np.exp(-240.0 / 7200.0)
    for n in range(1, ROWS):
        keeps = kept * (night[n] == night[n - 1])
        drift[n] = keeps * drift[n - 1] + np.sqrt(1 - keeps**2) * rng.normal()
    return {
        "time_utc": np.datetime64("2024-01-01T18:00:00") + time.astype("timedelta64[s]"),
        "session": np.char.add("night ", night.astype(str)),
        "source": np.char.add("S", rng.integers(0, 200, ROWS).astype(str)),
        "az_deg": az,
        "el_deg": el,
        "d_xel_arcsec": 4.0 * rng.normal(size=ROWS) + 5.0 * np.sin(2 * np.radians(az)),
        "d_el_arcsec": 4.0 * rng.normal(size=ROWS) + 6.0 * drift + 5.0 * np.cos(2 * np.radians(az)),
        "temperature_c": 10.0 - 3.0 * np.sin(time / 86400.0 * np.pi),
        "wind_speed_m_s": rng.gamma(2.0, 2.0, ROWS),
        "focus_mm": rng.normal(size=ROWS),
    }


def one(name, value):
    """Return what spoils a single cell."""

    def spoil(table, _):
        table[name][17] = value

    return spoil


def some(name, value, share):
    """Return what spoils a share of a column's cells."""

    def spoil(table, rng):
        table[name][rng.random(ROWS) < share] = value

    return spoil


def twice(table, rng):
    """Tell three rows again."""
    again = np.append(np.arange(ROWS), rng.integers(0, ROWS, 3))
    table.update({name: cells[again] for name, cells in table.items()})


SPOILT = {
    "nothing": lambda *_: None,
    "a blank time": one("time_utc", np.datetime64("NaT")),
    "a time of 1970": one("time_utc", np.datetime64("1970-01-01T00:00:00")),
    "a third of the times blank": some("time_utc", np.datetime64("NaT"), 0.33),
    "a blank session": one("session", ""),
    "a temperature of -999": one("temperature_c", -999.0),
    "a wind of 9999": one("wind_speed_m_s", 9999.0),
    "a focus of -9999": one("focus_mm", -9999.0),
    "a blank focus": one("focus_mm", np.nan),
    "an offset of two degrees": one("d_el_arcsec", 7200.0),
    "offsets of zero": some("d_el_arcsec", 0.0, 0.02),
    "a third of one axis blank": some("d_xel_arcsec", np.nan, 0.33),
    "rows told twice": twice,
}


@pytest.mark.slow
@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT)
def test_the_same_is_found_whatever_is_odd(spoil):
    """The waves of a track and nothing else; the drift is no finding."""
    table = night_log()
    spoil(table, np.random.default_rng(3))
    report = pyport.diagnose(table, "altaz").report

    assert [found["effect"] for found in report["findings"]] == ["azimuth_track"]
    assert any(drift["axis"] == "elevation" for drift in report["noise"]["drifts"])
