"""What the recordings must hold before an effect is named, whatever its evidence.

Evidence weighs how well a curve fits. It does not know that one night has one temperature
curve, that a change between sessions needs two of them, or that five readings are five.

A name is weighed by the scatter of what is left. From n numbers beyond all coefficients that is
known to a share of 1 / sqrt(2 n): with twenty to a sixth, so that four sigmas may be three and a
half or five; with five to a third, so that they may be anything. Below that nothing is looked for,
and nothing that was found keeps a name.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array
from pyport.diagnosis.case import Problem, measurements
from pyport.diagnosis.naming.nights import goes_with_the_hour, night_numbers, nights
from pyport.diagnosis.naming.scene import Scene
from pyport.diagnosis.searching.instead import lasting_instead
from pyport.effects.base import THE_HOUR, Effect
from pyport.effects.circumstances import NIGHT_GAP_S
from pyport.thresholds import (
    CARRIERS,
    ENOUGH,
    FEWEST,
    NOT_EXCLUDED,
    SAME_STRENGTH,
    SEEN,
    SIGNIFICANT,
)


@dataclass(frozen=True)
class TooFew:
    """Recordings that say nothing: how many there are, and for how many coefficients.

    `numbers` are measured offsets, one for each axis of a pointing.
    """

    pointings: int
    numbers: int
    coefficients: int

    @property
    def lacking(self) -> int:
        """Return how many measured numbers more are needed."""
        return lacking(self.numbers, self.coefficients)

    @property
    def scatter_known(self) -> bool:
        """Tell whether enough is left beyond the coefficients to hold anything against."""
        return self.numbers - self.coefficients >= FEWEST

    @property
    def sentence(self) -> str:
        """Return that nothing can be said, and what would be needed."""
        of = "pointing" if self.pointings == 1 else "pointings"
        return (
            f"Too few recordings: nothing can be said from {self.pointings} {of} "
            f"({self.numbers} measured numbers) with {self.coefficients} fitted coefficients; "
            f"{self.coefficients + ENOUGH} numbers are needed"
        )


def lacking(numbers: int, coefficients: int) -> int:
    """Return how many measured numbers are lacking beside so many coefficients, 0 for none."""
    return max(0, coefficients + ENOUGH - numbers)


def measured(problem: Problem, rows: NDArray[np.bool_] | None = None) -> int:
    """Return how many numbers some readings (m,) measured; repeats of a pointing are one."""
    number = measurements(problem)
    return len(np.unique(number if rows is None else number[rows]))


def too_few(problem: Problem) -> TooFew | None:
    """Return how few recordings there are beside the model's own terms; None for enough."""
    design = problem.expanded(problem.base)
    rank = int(np.linalg.matrix_rank(design)) if design.size else 0
    numbers, terms = measured(problem), design.shape[1]
    found = TooFew(len(np.unique(problem.pointing)), numbers, rank if numbers >= terms else terms)
    return found if found.lacking else None


def smallest_seen(limits: dict[str, float]) -> str | None:
    """Return how large an effect would have been seen, the best seen one; None where none is."""
    known = {name: size for name, size in limits.items() if np.isfinite(size)}
    if not known:
        return None
    name = min(known, key=lambda one: known[one])
    return (
        f"an offset of {known[name] / ARCSEC:.2g} arcsec rms would have been seen in half of such "
        f"recordings ({name.replace('_', ' ')}, what they show best), a smaller one not"
    )


@dataclass(frozen=True)
class Refusal:
    """Why an effect is not named, and what would have to be observed."""

    reason: str
    decide_by: str


def refusal(
    scene: Scene, effect: Effect, seen: Array, since: float | None = None
) -> Refusal | None:
    """Return why these recordings cannot carry an effect's name; None where they can.

    `seen` is what is visible of it in each reading [rad], shape (m,); `since` [s] is when it began,
    of a step at one moment.
    """
    return (
        _too_few(scene, seen)
        or _neglected(scene, effect, seen)
        or _one_session(scene, effect, since)
        or _one_night(scene, effect)
        or _once_only(scene, effect, seen)
        or _in_a_part_of_the_sky(scene, effect)
    )


def _too_few(scene: Scene, seen: Array) -> Refusal | None:
    rank = scene.joint.solution.rank
    there = measured(scene.problem, scene.weighed.used)
    if lack := lacking(there, rank):
        axes = len(np.unique(scene.problem.stack.is_y))
        return Refusal(
            f"{there} measured numbers are too few for {rank} coefficients and {ENOUGH} more, by "
            "which one cause is distinguished from another",
            f"record at least {-(-lack // axes)} more pointings",
        )
    if (carried := carriers(scene, seen)) < CARRIERS:
        return Refusal(
            f"what is seen of it rests on {carried:.1f} pointings, fewer than {CARRIERS}",
            "record more pointings where it is seen",
        )
    return None


def _neglected(scene: Scene, effect: Effect, seen: Array) -> Refusal | None:
    """Refuse what lasts and is smaller than what terms lose that only add up."""
    if effect.changes_with or float(np.sqrt(np.mean(seen[seen != 0] ** 2))) > scene.neglected:
        return None
    return Refusal(
        "it is smaller than what a model of terms that only add up loses of offsets so large, "
        f"about {scene.neglected / ARCSEC:.2g} arcsec",
        "enter the fitted terms and record again",
    )


def carriers(scene: Scene, seen: Array) -> float:
    """Return how many pointings carry what is visible of an effect.

    One over the sum of the squares of the shares that pointings have in its weight (Kish
    1965, Survey Sampling: the effective size of a sample).
    """
    size = scene.weighed.used * seen / np.maximum(scene.floor, 1e-300)
    weight: Array = np.bincount(scene.problem.pointing, size**2).astype(float)
    weight /= max(float(weight.max(initial=0.0)), 1e-300)
    return float(weight.sum() ** 2 / max(float(weight @ weight), 1e-300))


def _one_session(scene: Scene, effect: Effect, since: float | None = None) -> Refusal | None:
    if not effect.is_change:
        return None
    at = scene.problem.recordings.at
    if "order" in at and "session" not in at and not effect.came_back:
        # Nothing tells one session from the next: the step itself does.
        return None
    sessions = len(np.unique(scene.problem.session))
    if max(sessions, nights(scene)) > 1:
        return None
    if _is_within_a_night(scene, since):
        return Refusal(
            "a single session shows when something moved and by how much, but not what it was, "
            "for whatever else changed at that moment looks the same",
            "observe in a second session",
        )
    return Refusal(
        "a change from one session to another cannot be tested in a single one: whatever else "
        "changed in that night looks the same",
        "observe in a second session",
    )


def _is_within_a_night(scene: Scene, since: float | None) -> bool:
    """Tell whether a night goes on across a moment [s]."""
    time = scene.problem.recordings.at.times
    if time is None or since is None or not time.min() < since <= time.max():
        return False
    return bool(time[time >= since].min() - time[time < since].max() <= NIGHT_GAP_S)


def _one_night(scene: Scene, effect: Effect) -> Refusal | None:
    """Refuse what follows something that went with the hour, where there is one night only."""
    driver = effect.driver
    if driver is None or nights(scene) > 1:
        return None
    if driver != THE_HOUR and not goes_with_the_hour(scene, driver):
        return None
    what = "what drives it" if driver == THE_HOUR else driver
    at = scene.problem.recordings.at
    if "time" in at or "session" in at:
        where, more = "these recordings are of one night or day", "observe in a second night"
    else:
        where = "nothing says that these recordings are of more than one night"
        more = "record when each pointing was made, or in which night"
    return Refusal(
        f"{where}, in which {what} went with the hour: whatever else did looks the same", more
    )


def _once_only(scene: Scene, effect: Effect, seen: Array) -> Refusal | None:
    """Refuse what belongs to a label and did not come back with it in a second night."""
    label = effect.belongs_to
    if not label:
        return None
    row = scene.problem.stack.row
    names = np.asarray(scene.problem.recordings.label(label)).astype(str)[row]
    power = scene.weighed.used * (seen / np.maximum(scene.floor, 1e-300)) ** 2
    moved = [one for one in np.unique(names) if power[names == one].any()]
    again = sum(power[names == one].sum() for one in moved if comes_back(scene, names == one, seen))
    if again >= 0.5 * power.sum():
        return None
    one = f"one {label}" if len(moved) == 1 else f"each {label}"
    return Refusal(
        f"offset of {one} on one night: it did not come back in a second one",
        f"observe the same {label}s in a second night",
    )


def _in_a_part_of_the_sky(scene: Scene, effect: Effect) -> Refusal | None:
    """Refuse what was displaced for a while where a field that lasts is not excluded."""
    if not effect.came_back:
        return None
    one = next(each for each in scene.outcome.chosen if each.candidate.effect is effect)
    field = lasting_instead(scene.outcome, one)
    if field is None or field.evidence < scene.outcome.step_of(one).winner.evidence - NOT_EXCLUDED:
        return None
    return Refusal(
        f"what lasts explains as well what was seen meanwhile ({field.field.variant})",
        "observe the same part of the sky at another time",
    )


def comes_back(scene: Scene, rows: NDArray[np.bool_], seen: Array) -> bool:
    """Tell whether a curve is there again, of about the same size, in two nights and more.

    Parameters
    ----------
    scene
        What findings are read from.
    rows
        Which readings the curve is looked for in, shape (m,).
    seen
        The curve [rad], shape (m,).
    """
    left = scene.problem.residual - scene.joint.predicted + seen
    weight = scene.weighed.used / np.maximum(scene.floor, 1e-300) ** 2
    number, found = night_numbers(scene), 0
    for night in np.unique(number[rows]):
        own = rows & (number == night)
        power = float((weight[own] * seen[own] ** 2).sum())
        if power <= 0:
            continue
        size = float((weight[own] * seen[own] * left[own]).sum()) / power
        sigma = 1 / np.sqrt(power)
        found += size > SEEN * sigma and abs(size - 1) < max(SIGNIFICANT * sigma, SAME_STRENGTH)
    return found >= 2
