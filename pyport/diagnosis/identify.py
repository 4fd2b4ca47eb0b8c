"""Naming: which effects the data cannot tell from the winner, and what would tell them apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.diagnosis.evidence import Beside, Trial
from pyport.fitting.gram import inverted

#: Squared cosine from which two curves count as one: a cosine of 0.95.
ALIKE = 0.95**2
#: An effect that falls behind by less than this in BIC is not excluded.
NOT_EXCLUDED = 6.0

#: A coefficient that physics fixes may be off by this many sigmas and this share of itself.
KNOWN_SIGMAS, KNOWN_SHARE = 4.0, 0.1

_DECIDE: dict[frozenset[str], str] = {
    frozenset({"scan_direction", "scan_timing"}): (
        "scan once more at half the rate: a time tag shifts the peak half as far, "
        "mechanical play by the same amount; or compare days, which only a time tag tells apart"
    ),
    frozenset({"site_latitude", "tilt"}): (
        "read an inclinometer on the azimuth axis, or compare with surveyed coordinates: "
        "over an array a site error grows with the distance from the reference, a tilt does not"
    ),
    frozenset({"site_longitude", "tilt"}): (
        "measure the azimuth offset too (a longitude error also turns the azimuth zero), "
        "or read an inclinometer on the azimuth axis"
    ),
    frozenset({"site_longitude", "clock"}): (
        "compare antennas: a clock error is one for all, a longitude error is each one's own"
    ),
    frozenset({"sag_cosine", "refraction"}): "observe below 15 deg elevation, where cot E turns up",
    frozenset({"sag_sine", "refraction"}): "observe below 15 deg elevation, where cot E turns up",
    frozenset({"sag_cosine", "elevation_zero"}): "observe over a wider range of elevation",
    frozenset(
        {"epoch_offset", "drift"}
    ): "observe in between: a step stays a step, a drift fills in",
    frozenset({"refraction", "refraction_curvature"}): "observe between 3 and 15 deg elevation",
}


@dataclass(frozen=True)
class Name:
    """What the winner of a turn is called.

    Attributes
    ----------
    members
        Ids that the data cannot tell apart, the winner first.
    runner_up
        The best effect outside the class, None where there is none.
    """

    members: tuple[str, ...]
    runner_up: Trial | None


def name(winner: Trial, trials: Sequence[Trial], beside: Beside) -> Name:
    """Return the class of the winner of a turn and the best effect outside it."""
    members = [winner.candidate.effect.id]
    rivals = sorted(
        (t for t in trials if t.candidate.effect.physical and fits_physics(t)),
        key=lambda t: -t.delta_bic,
    )
    outside: list[Trial] = []
    for rival in rivals:
        effect = rival.candidate.effect.id
        if effect in members:
            continue
        close = rival.delta_bic > winner.delta_bic - NOT_EXCLUDED
        # A rival with many more coefficients can draw any curve; that is no likeness.
        same = (
            rival.scope == winner.scope
            and rival.dof <= 2 * winner.dof
            and beside.share(winner, rival) >= ALIKE
        )
        if close or same:
            members.append(effect)
        else:
            outside.append(rival)
    outside = [rival for rival in outside if rival.candidate.effect.id not in members]
    return Name(tuple(members), outside[0] if outside else None)


def fits_physics(trial: Trial) -> bool:
    """Tell whether a trial's coefficients agree with the values that physics fixes, if any."""
    candidate = trial.candidate
    sigma = np.sqrt(np.maximum(np.diag(inverted(trial.information)[0]), 0))
    for n, (value, error) in enumerate(zip(trial.values, sigma, strict=True)):
        which = candidate.coefficients[n % len(candidate.coefficients)]
        coefficient = candidate.effect.coefficients[which]
        if coefficient.expected is None:
            continue
        off = abs(value / coefficient.scale - coefficient.expected)
        if off > KNOWN_SIGMAS * error / coefficient.scale + KNOWN_SHARE * coefficient.expected:
            return False
    return True


def decide_by(members: tuple[str, ...]) -> str | None:
    """Name the observation that would tell the members of a class apart."""
    if len(members) < 2:
        return None
    found = [text for pair, text in _DECIDE.items() if pair <= set(members)]
    if found:
        return "; ".join(found)
    return "observe where " + " and ".join(members) + " differ: other directions, other sessions"
