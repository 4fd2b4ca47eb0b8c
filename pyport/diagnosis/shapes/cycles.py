"""Cycles: what comes back along an angle of the mount, whatever its form within a period.

Teeth of a gear, a worm and an encoder's interpolation err by the same amount in every period. Where
that is a sine it has a name; a sawtooth, or a jump once in each, takes a profile of the period.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.case import Problem
from pyport.diagnosis.shapes.fields import Ground
from pyport.diagnosis.shapes.forms import HARMONICS, Field
from pyport.diagnosis.weighing import View
from pyport.effects.base import Circumstances
from pyport.effects.empirical import fields
from pyport.effects.empirical.fields import Bumps
from pyport.mounts import ALTAZ
from pyport.runs.stages import stage
from pyport.thresholds import FEWEST, PERIODS_ALONE

#: Shortest cycle, whose shortest harmonic is half a degree long. [rad]
SHORTEST = 4 * DEG
#: Bins that a period is folded into while the best one is looked for. Of numbers of periods that
#: are tried neighbours differ by as much at the ends of the angle.
BINS = 10
_TURN = 2 * np.pi


@dataclass(frozen=True)
class _Angle:
    """An angle that a drive and an encoder turn by.

    Attributes
    ----------
    called
        Its column, and how what it errs by depends on another.
    values, lever
        The angle of each recording [rad], and what its errors move the beam by, shape (n,).
    bumps
        What its cycles are made of besides their period.
    axes
        In which of both axes they are looked for.
    """

    called: str
    values: Array
    lever: Array
    bumps: Bumps
    axes: Mapping[str, Sequence[int]] = field(
        default_factory=lambda: {"xel": (0,), "el": (1,), "both axes": (0, 1)}
    )

    @property
    def turns(self) -> list[Array]:
        """Return how often something may come back in a radian: any number, and whole in a turn.

        What sits on the axis comes back a whole number of times.
        """
        length = float(np.ptp(self.values))
        some = np.arange(PERIODS_ALONE, length / SHORTEST, 1 / BINS) / max(length, SHORTEST)
        whole = np.arange(1, _TURN / SHORTEST) / _TURN
        return [one for one in (some, whole[whole * length >= PERIODS_ALONE]) if len(one)]


def cycles(ground: Ground) -> Iterator[Field]:
    """Yield the cycles along each angle that explain most of what a model leaves, axis by axis."""
    problem, seen = ground.problem, ground.plain
    angles = [*_angles(problem.recordings.at)]
    kinds = sum(len(one.turns) * len(one.axes) for one in angles)
    for angle in angles:
        for turns in angle.turns:
            gains = _gains(problem, seen, angle, turns)
            for axis, which in angle.axes.items():
                gain = gains[list(which)].sum(axis=0)
                if gain.max() > 0:
                    period = float(1 / turns[np.argmax(gain)])
                    yield _cycle(problem, angle, axis, period, len(turns) * kinds)


def _cycle(problem: Problem, angle: _Angle, axis: str, period: float, choices: int) -> Field:
    bumps = {"kind": "cycle", "period_rad": period, "count": HARMONICS, **angle.bumps}
    values = fields.values(bumps, problem.recordings.at)[problem.stack.row]
    axes, count = angle.axes[axis], values.shape[1]
    return Field(
        "an error that repeats",
        f"{axis}: every {period / DEG:.4g} deg of {angle.called}",
        values,
        problem.stack.is_y,
        choices,
        bumps=bumps,
        axes=tuple(np.repeat(axes, count).tolist()),
        which=tuple(np.tile(range(count), len(axes)).tolist()),
    )


def _angles(at: Circumstances) -> Iterator[_Angle]:
    """Yield the mount's angles: the first around its circle and as it is wound, and the second.

    What the first drive errs by moves the beam by the cosine of the second angle.
    """
    mount, here, level = at.mount, at.axes, np.ones(len(at))
    first, second = (f"{one.column}_deg" for one in (mount.first, mount.second))
    begin = 0.0 if mount is ALTAZ else -np.pi
    around = (here.az - begin) % _TURN
    circle = {"name": "az_deg", "from_rad": begin, "in_axes": True}
    yield _Angle(first, around, level, circle)
    falls = f"{first}, as the cosine of {second}"
    yield _Angle(falls, around, at.onto_sky, {**circle, "falls": True}, {"xel": (0,)})
    if np.ptp(here.az) > _TURN:
        yield _Angle(f"unwrapped_{first}", here.az, level, {"name": "az_deg", "in_axes": True})
    yield _Angle(second, here.el, level, {"name": "el_deg", "in_axes": True})


@stage("fields")
def _gains(problem: Problem, seen: View, angle: _Angle, turns: Array) -> Array:
    """Return how much a profile of each number of turns [1/rad] explains in each axis, (2, T)."""
    row, is_y = problem.stack.row[seen.rows], problem.stack.is_y[seen.rows]
    gains = np.zeros((2, len(turns)))
    for axis in (0, 1):
        own = is_y == axis
        if np.count_nonzero(own) < FEWEST * BINS:
            continue
        root = seen.root[own] * angle.lever[row][own]
        weight, pull = root**2, root * seen.left[own]
        pull -= weight * (pull.sum() / weight.sum())
        heights = angle.values[row][own] * BINS
        for n, turn in enumerate(turns):
            bins = np.floor(heights * turn).astype(np.intp) % BINS
            mass = np.bincount(bins, weight, BINS)
            moved = np.bincount(bins, pull, BINS)
            gains[axis, n] = (moved**2 / np.maximum(mass, 1e-12)).sum()
    return gains
