"""A source's catalogue is blamed only for what comes back with the source in another night."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pyport.diagnosis.naming import guards
from pyport.diagnosis.naming.guards import comes_back, night_of
from pyport.effects import CATALOGUE
from pyport.effects.base import Circumstances
from pyport.recordings.sky import NIGHT_GAP_S

DAY_S = 86400.0


def scene(size_of_night, seed=0, per_night=12, sigma=1.0, session=None):
    """Return what guards look at: one source, with an offset of its own in each night [sigma]."""
    rng = np.random.default_rng(seed)
    nights = len(size_of_night)
    night = np.repeat(np.arange(nights), per_night)
    source = np.tile(np.array(["3C 84", "W3OH"]), len(night) // 2)
    mine = source == "3C 84"
    curve = np.where(mine, 5.0, 0.0)
    residual = curve * np.asarray(size_of_night)[night] + sigma * rng.normal(size=len(night))
    time = DAY_S * night + 600.0 * np.tile(np.arange(per_night), nights)
    at = Circumstances(np.zeros(len(night)), np.zeros(len(night)), None, {"time": time})
    setup = SimpleNamespace(
        residual=residual,
        session=np.zeros(len(night), int) if session is None else session,
        stack=SimpleNamespace(row=np.arange(len(night)), is_y=np.zeros(len(night), bool)),
        recordings=SimpleNamespace(at=at, label=lambda _: source),
        pointing=np.arange(len(night)),
    )
    return (
        SimpleNamespace(
            setup=setup,
            weighed=SimpleNamespace(used=np.ones(len(night), bool)),
            joint=SimpleNamespace(predicted=curve, solution=SimpleNamespace(rank=3)),
            floor=np.full(len(night), sigma),
        ),
        mine,
        curve,
    )


@pytest.mark.parametrize(
    ("sizes", "back"),
    [
        ((1.0,), False),
        ((1.0, 1.0), True),
        ((1.0, 1.1, 0.9), True),
        # One night alone shows it; the other one shows nothing, or the opposite.
        ((2.0, 0.0), False),
        ((2.0, -1.0), False),
        # Nights that each show another size are no error of one position.
        ((4.0, 0.5), False),
    ],
)
def test_the_same_offset_must_come_back(sizes, back):
    """In two nights at least, and of about the same size."""
    for seed in range(20):
        one, mine, curve = scene(sizes, seed)

        assert comes_back(one, mine, curve) == back


@pytest.mark.parametrize(("nights", "refused"), [(1, True), (2, False)])
def test_one_night_blames_no_catalogue(nights, refused):
    """The reason is said in so many words, and what to observe."""
    one, _, curve = scene((1.0,) * nights, per_night=40)
    why = guards.refusal(one, replace(CATALOGUE["source_position"], variant="3C 84"), curve)

    assert (why is not None) == refused
    if why is not None:
        assert "offset of one source on one night" in why.reason
        assert "second night" in why.decide_by


def test_what_is_the_telescopes_needs_no_label():
    """Only effects that belong to a label are asked to come back with it."""
    one, _, curve = scene((1.0,), per_night=40)

    assert guards.refusal(one, CATALOGUE["refraction"], curve) is None


def test_a_long_session_has_its_nights():
    """Gaps part nights within a session, sessions part them where no time is known."""
    one, *_ = scene((1.0, 1.0, 1.0))
    assert len(np.unique(night_of(one))) == 3
    assert NIGHT_GAP_S < DAY_S

    sessions = np.repeat([0, 1], 12)
    two, *_ = scene((1.0, 1.0), session=sessions)
    at = two.setup.recordings.at
    two.setup.recordings.at = replace(at, columns={})
    assert np.array_equal(night_of(two), sessions)
