"""Recordings of every sort: a diagnosis and a fit answer, or refuse in one line, and never fail."""

import contextlib
import warnings

import numpy as np
import pytest

import pyport
from pyport.errors import BadInput

#: Values that a column may have besides its own: blanks, one value throughout, whole numbers.
SPOILT = (
    lambda rng, one: np.where(rng.random(len(one)) < 0.4, np.nan, one),
    lambda _, one: np.full(len(one), one[0]),
    lambda _, one: np.round(one),
    lambda _, one: np.zeros(len(one)),
    lambda rng, one: np.where(np.arange(len(one)) == rng.integers(len(one)), 1e5, one),
)
ROWS = (1, 2, 3, 5, 8, 9, 12, 20, 33)


def labels(rng, rows, letter, most):
    """Return labels of rows in order, few or as many as there are rows."""
    some = np.sort(rng.integers(0, rng.choice([1, 2, most, rows]), rows))
    return np.char.add(letter, some.astype(str))


def recordings(seed):
    """Return columns and a header: few rows, columns that are blank, constant or missing."""
    rng = np.random.default_rng(seed)
    n = int(rng.choice(ROWS))
    size = 10 ** rng.uniform(-2, 3)
    table = {
        "az_deg": rng.uniform(-180, 540, n),
        "el_deg": rng.uniform(5, 89.9, n),
        "d_xel_arcsec": size * rng.standard_normal(n),
        "d_el_arcsec": size * rng.standard_normal(n) + 30,
    }
    more = {
        "time_utc": np.datetime64("2020-01-01T00:00:00")
        + rng.uniform(0, 10 ** rng.uniform(2, 7), n).astype("timedelta64[s]"),
        "session": labels(rng, n, "n", 4),
        "source": rng.permutation(labels(rng, n, "S", 3)),
        "antenna": rng.permutation(labels(rng, n, "A", 3)),
        "temperature_c": rng.standard_normal(n).cumsum(),
        "focus_z_mm": rng.standard_normal(n).cumsum(),
        "sigma_el_arcsec": 0.1 + np.abs(rng.standard_normal(n)),
    }
    table |= {name: column for name, column in more.items() if rng.random() < 0.4}
    for name, column in table.items():
        if column.dtype.kind == "f" and rng.random() < 0.15:
            table[name] = SPOILT[rng.integers(len(SPOILT))](rng, column)
    place = {"latitude_deg": rng.uniform(-80, 80), "longitude_deg": rng.uniform(-180, 180)}
    return table, place if rng.random() < 0.6 else {}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 60, 10))
def test_whatever_is_recorded_is_answered_or_refused(first):
    """Without a warning of numpy either."""
    answered = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        for seed in range(first, first + 10):
            table, header = recordings(seed)
            for command in (pyport.fit, pyport.diagnose):
                with contextlib.suppress(BadInput):
                    done = command(table, "altaz", header=header)
                    assert done.report
                    assert done.summary()
                    answered += 1
    assert answered > 2
