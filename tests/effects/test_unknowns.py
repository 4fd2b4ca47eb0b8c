"""What is not known, or known for some rows only."""

import numpy as np
import pytest
from effects.sky import campaign, replaced, without

from pyport.effects import CATALOGUE, MissingColumn
from pyport.effects.sky.frame import ut1_minus_utc

AT = campaign()
NEEDING = [
    ("temperature", "temperature_c", "temperature_c"),
    ("wind_tilt", "wind_az", "wind_az_deg"),
    ("ionosphere", "frequency_mhz", "frequency_mhz"),
    ("drift", "time", "time_utc"),
    ("oscillation", "time", "time_utc"),
    ("annual_aberration", "time", "time_utc"),
    ("polar_motion", "time", "time_utc"),
    ("nutation", "time", "time_utc"),
]


def blanked(column, share):
    """Return the campaign with a column blank in a share of the rows, and which those are."""
    blank = np.arange(len(AT)) % 10 < 10 * share
    return replaced(AT, **{column: np.where(blank, np.nan, AT.columns[column])}), blank


@pytest.mark.parametrize(("effect", "column", "_"), NEEDING)
def test_rows_of_unknown_circumstances_show_nothing(effect, column, _):
    """Where a few cells are blank those rows show no effect, and the others show it as ever."""
    at, blank = blanked(column, 0.3)

    for member in CATALOGUE[effect].variants(at):
        x, y = member.columns(at)
        full = member.columns(AT)
        np.testing.assert_array_equal(x[blank], 0)
        np.testing.assert_array_equal(y[blank], 0)
        if member.looks_back:  # what a blank row would have said of the past is gone
            continue
        np.testing.assert_allclose(x[~blank], full[0][~blank], rtol=1e-12)
        np.testing.assert_allclose(y[~blank], full[1][~blank], rtol=1e-12)


@pytest.mark.parametrize(("effect", "column", "name"), NEEDING)
def test_columns_that_are_mostly_blank_are_missing(effect, column, name):
    """An effect is not testable on a column that is blank in most rows, or in all."""
    assert CATALOGUE[effect].missing(blanked(column, 0.6)[0]) == f"{name} in half of the rows"
    assert CATALOGUE[effect].missing(blanked(column, 1.0)[0]) == name


def test_site_without_longitude():
    """What the Earth's turning decides needs the longitude; what the pole's height does, not."""
    at = without(AT, "longitude_deg")

    assert CATALOGUE["nutation"].missing(at) == "longitude_deg"
    assert CATALOGUE["clock"].missing(at) is None
    assert CATALOGUE["diurnal_aberration"].missing(at) is None


@pytest.mark.parametrize(
    ("time", "why"),
    [
        (-1e9, "Earth orientation at these dates"),
        (4e9, "Earth orientation at these dates"),
        (1e10, "dates between 1900 and 2100"),
        (-1e10, "dates between 1900 and 2100"),
    ],
)
def test_dates_that_no_series_covers(time, why):
    """The pole of 1938 or of 2096 is not known; a clock error may be constant at any time."""
    at = replaced(AT, time=np.full(len(AT), time))

    assert CATALOGUE["polar_motion"].missing(at) == why
    assert CATALOGUE["clock"].missing(at) is None


def test_ut1_jumps_with_a_leap_second_only():
    """Around the leap second of 2006 UT1-UTC goes from -0.661 to +0.339 s at midnight."""
    midnight = 1_136_073_600.0
    hours = np.array([-30.0, -1.0, -0.01, 0.01, 1.0, 30.0])
    at = replaced(AT.take(slice(0, 6)), time=midnight + hours * 3600)

    np.testing.assert_allclose(
        ut1_minus_utc(at), [-0.661, -0.661, -0.661, 0.339, 0.339, 0.339], atol=2e-3
    )


def test_missing_names_nothing_else():
    """An effect that is only wrong because data are missing raises one kind of error."""
    with pytest.raises(MissingColumn, match="needs frequency_mhz"):
        CATALOGUE["ionosphere"].columns(without(AT, "frequency_mhz"))
