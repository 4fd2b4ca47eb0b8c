"""Classes: what a winner may be called, and which effects the data cannot distinguish from it."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pyport.diagnosis.evidence import Projection
from pyport.diagnosis.trial import CandidateFit
from pyport.effects import Effect, degeneracies
from pyport.least_squares.gram import inverted
from pyport.thresholds import (
    ALIKE,
    BENT,
    IDENTICAL,
    IMPERFECTION,
    KNOWN_SHARE,
    NOT_EXCLUDED,
    OUT_OF_REACH,
    REFUTES,
    SEEN,
)

#: Evidence is compared to so many decimals: of effects that draw one and the same curve the
#: catalogue's first stands, whatever rounding says.
TIE = 6


@dataclass(frozen=True)
class Name:
    """What the winner of a turn is called.

    Attributes
    ----------
    members
        Ids that the data cannot distinguish, the winner first.
    runner_up
        The best effect outside the class, None where there is none.
    others
        Members of the winner's family that follow another condition, or are another term that
        follows it, and are not excluded.
    orders
        How often in a turn the winner may go as well, where it goes round so often: not excluded.
    """

    members: tuple[str, ...]
    runner_up: CandidateFit | None
    others: tuple[str, ...] = ()
    orders: tuple[float, ...] = ()


def name(winner: CandidateFit, trials: Sequence[CandidateFit], beside: Projection) -> Name:
    """Return the class of the winner of a turn and the best effect outside it."""
    inside = [winner]
    members = [winner.candidate.effect.id]
    rivals = sorted(
        (t for t in trials if t.candidate.effect.physical), key=lambda t: -round(t.evidence, TIE)
    )
    outside: list[CandidateFit] = []
    others: list[str] = []
    orders: list[float] = []
    # One whose evidence does not pay for the choice among all names explains nothing.
    choice = 2 * float(np.log(max(len({rival.candidate.effect.id for rival in rivals}), 1)))
    least = max(winner.evidence - NOT_EXCLUDED, choice)
    for rival in rivals:
        effect = rival.candidate.effect.id
        if effect in members:
            if rival.evidence > least and _another_term(winner, rival):
                others.append(rival.candidate.effect.variant)
            if rival.evidence > least and (order := _another_order(winner, rival)):
                orders.append(order)
            continue
        if not fits_physics(rival) and not _same(beside, winner, rival):
            continue
        if _changes(winner, rival):
            continue
        close = rival.evidence > least
        # A rival with many more coefficients can draw any curve; that is no likeness.
        same = (
            rival.scope == winner.scope
            and rival.dof <= 2 * winner.dof
            and winner.gain - rival.gain < max(OUT_OF_REACH, IMPERFECTION * winner.gain)
            and beside.share(winner, rival) >= ALIKE
        )
        if (close or same) and any(_only_adds_to(beside, one, rival) for one in inside):
            continue
        if close or same:
            inside.append(rival)
            members.append(effect)
        else:
            outside.append(rival)
    outside = [rival for rival in outside if rival.candidate.effect.id not in members]
    runner_up = outside[0] if outside else None
    return Name(tuple(members), runner_up, tuple(dict.fromkeys(others)), tuple(sorted(orders)))


def _another_term(winner: CandidateFit, rival: CandidateFit) -> bool:
    """Tell whether a rival of the winner's family follows another condition, or is another term."""
    one, other = winner.candidate.effect, rival.candidate.effect
    return one.id == other.id and _driven(one) != _driven(other)


def _driven(effect: Effect) -> tuple[str, str | None]:
    """Return which term changes, and the condition that it follows."""
    return effect.change_of, effect.member.get("follows", effect.driver)


def _another_order(winner: CandidateFit, rival: CandidateFit) -> float:
    """Return how often in a turn a rival of the winner's family goes, if not as often; else 0."""
    one, other = winner.candidate.effect, rival.candidate.effect
    own, order = (effect.member.get("k") for effect in (one, other))
    alike = one.id == other.id and winner.scope == rival.scope and own != order
    return float(order) if alike and order else 0.0


def _changes(winner: CandidateFit, rival: CandidateFit) -> bool:
    """Tell whether a rival is a change of the very term that the winner is.

    What changes is there. In one night a term times the hour draws nearly what the term draws.
    """
    effect = winner.candidate.effect
    return rival.candidate.effect.change_of == effect.on_altaz


def _only_adds_to(beside: Projection, one: CandidateFit, rival: CandidateFit) -> bool:
    """Tell whether a rival is a simpler effect and more, which the model has already.

    Beside zeros, skew and sag a receiver on a platform is the sine of elevation alone: as a
    second name for that it would widen every class of curves in elevation.
    """
    return (
        rival.dof < len(rival.values) and rival.dof == len(one.values) and _same(beside, one, rival)
    )


def _same(beside: Projection, winner: CandidateFit, rival: CandidateFit) -> bool:
    """Tell whether two effects draw one and the same curve."""
    return rival.scope == winner.scope and beside.share(winner, rival) >= IDENTICAL


def distinct(beside: Projection, trials: Iterable[CandidateFit], most: int) -> list[CandidateFit]:
    """Return the first few trials of those that draw curves of their own.

    Where data left out, or noise estimated anew, are against a curve they are against the same
    curve by another formula.
    """
    found: list[CandidateFit] = []
    for one in trials:
        if len(found) == most:
            break
        if not any(_same(beside, each, one) and _same(beside, one, each) for each in found):
            found.append(one)
    return found


def _of_known_size(trial: CandidateFit) -> Iterator[tuple[float, float, float]]:
    """Yield value, sigma and what physics says of each coefficient of known size."""
    candidate = trial.candidate
    coefficients = [candidate.effect.coefficients[which] for which in candidate.coefficients]
    if all(one.expected is None for one in coefficients):
        return
    sigma = np.sqrt(np.maximum(np.diag(inverted(trial.information)[0]), 0))
    of_each = itertools.cycle(coefficients)
    for value, error, coefficient in zip(trial.values, sigma, of_each, strict=False):
        if coefficient.expected is not None:
            yield value / coefficient.scale, error / coefficient.scale, coefficient.expected


def fits_physics(trial: CandidateFit) -> bool:
    """Tell whether a trial's coefficients agree with the values that physics fixes, if any."""
    return all(
        sigma <= known / SEEN and agrees(value, sigma, known)
        for value, sigma, known in _of_known_size(trial)
    )


def seen(trial: CandidateFit) -> bool:
    """Tell whether a trial's coefficients of known size come out with the right sign, and large."""
    return all(
        sigma <= known / SEEN and 1 / BENT < value / known < BENT
        for value, sigma, known in _of_known_size(trial)
    )


def agrees(value: float, sigma: float, expected: float) -> bool:
    """Tell whether a coefficient has the value that physics fixes, as far as its error tells."""
    return abs(value - expected) <= REFUTES * sigma + KNOWN_SHARE * expected


def decide_by(members: Sequence[str], others: Sequence[str] = ()) -> str | None:
    """Name the observation that distinguishes the members of a class, and what drives them."""
    if others:
        apart = f"{', or '.join(others)}, as well: observe where and while these go apart"
        return "; ".join(filter(None, (decide_by(members), apart)))
    if len(members) < 2:
        return None
    found = degeneracies.decisions(members)
    if found:
        return "; ".join(found)
    return "observe where " + " and ".join(members) + " differ: other directions, other sessions"
