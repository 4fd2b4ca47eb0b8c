"""Steel that comes after the air, and zeros that differ from turn to turn, to their names."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.correction.kernel import BLOCK, kernel
from pyport.diagnosis.diagnose import diagnose
from pyport.effects import CATALOGUE, Circumstances
from pyport.formats.models import load
from pyport.models.model import Model, Term
from pyport.watch.detection.changes import members

HOUR_S = 3600.0


def weather(nights, rows, seed, hours=1.5):
    """Return times, and the air's and steel's temperature there: minutes of weather, from before.

    The air wanders within hours; the steel follows it with a time constant of `hours`.
    """
    rng = np.random.default_rng(seed)
    minutes = np.arange(-24 * 60, nights * 24 * 60)
    air, steel = np.zeros((2, len(minutes)))
    for n in range(1, len(minutes)):
        air[n] = air[n - 1] * (1 - 1 / 120) + rng.normal(0, 2 * np.sqrt(2 / 120))
        steel[n] = steel[n - 1] + (air[n] - steel[n - 1]) / (hours * 60)
    hour = np.sort(np.arange(rows) % nights * 24 + rng.uniform(0, 10, rows))
    at = [np.interp(hour * 60, minutes, one) for one in (air, steel)]
    return 1.6e9 + HOUR_S * hour, np.round(8 + at[0], 1), 8 + at[1]


def made(rows, seed, nights, **more):
    """Return recordings in such weather, and the steel's temperature."""
    time, air, steel = weather(nights, rows, seed)
    session = np.char.add("s", ((time - 1.6e9) // (24 * HOUR_S)).astype(int).astype(str))
    columns = {"time": time, "session": session, "temperature_c": air}
    offsets = {axis: lambda _, of=of: of(air, steel) for axis, of in more.items()}
    return recordings(rows, seed, **offsets, **columns)


def told(given):
    """Return the effect, member and verdict of each finding."""
    found = diagnose(given, load("altaz")).findings
    return [(one.effect, one.variant, one.verdict) for one in found]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "beside"),
    [(0, []), (1, ["elevation_zero follows the beginning of the session, settling in 2 h"])],
)
def test_a_zero_that_follows_the_rate_of_the_air_is_named_after_the_temperature(seed, beside):
    """Air less steel, four arcseconds for each kelvin, in four nights: not the hour, no drift.

    How warm the steel was as a night began is not recorded. Where all four nights agree by chance,
    what that did is found as well, and is one finding too many.
    """
    (first, *others) = told(made(500, seed, 4, y=lambda air, steel: 4 * (air - steel)))

    assert (first[0], first[2]) == ("temperature", "named")
    assert "thin parts against thick ones" in first[1]
    assert [variant for _, variant, _ in others] == beside


@pytest.mark.slow
def test_nothing_is_claimed_where_the_temperature_moves_nothing():
    """The same weather beside noise alone."""
    assert not told(made(500, 0, 4))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_zero_of_each_turn_is_one_finding(seed):
    """Ten arcseconds from turn to turn are no two scales, and come back with their size."""
    given = recordings(400, seed)
    az = (given.at.az + np.pi) % (2 * np.pi) - np.pi + 2 * np.pi * (np.arange(400) % 2)
    moved = np.where(az >= 2 * np.pi, 2, np.where(az >= 0, 1, 0)) * np.cos(given.at.el)
    given = replace(
        given,
        at=replace(given.at, az=az),
        x=given.x + 10 * np.pi / 648000 * moved,
    )
    (first,) = diagnose(given, load("altaz")).findings

    assert (first.effect, first.variant) == ("azimuth_turns", "turns counted from north")
    assert first.verdict == "named"
    (size,) = first.parameters
    assert abs(size.value - 10) < 4 * size.sigma < 4


def test_what_looks_back_is_applied_to_all_rows_at_once():
    """A model gives the same however many rows are asked for, and a watch leaves it out."""
    rows = BLOCK + 50
    time, air, _ = weather(3, rows, 0)
    at = Circumstances(
        np.zeros(rows), np.full(rows, 0.7), None, {"time": time, "temperature_c": air}
    )
    late = [one for one in CATALOGUE["temperature"].variants(at) if one.looks_back]
    model = Model("late", (Term(late[0], values=(0.0, 1.0)),))

    _, y = kernel(model, {}, None).many(at.az, at.el, dict(at.columns), None)
    np.testing.assert_allclose(y, late[0].columns(at)[1][:, 1], atol=1e-12)
    assert late
    assert not [one for one in members(at) if one.looks_back]
