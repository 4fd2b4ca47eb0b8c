"""The verdict on a finding: can the recordings carry its name, and does that come back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pyport.diagnosis import identify
from pyport.diagnosis.finding import Finding
from pyport.diagnosis.guards import Refusal, refusal
from pyport.diagnosis.identify import decide_by
from pyport.diagnosis.resampling import stability
from pyport.diagnosis.scene import Scene
from pyport.diagnosis.stability import Stability
from pyport.diagnosis.steps import Step
from pyport.effects import Effect, known
from pyport.thresholds import MOST_MEMBERS


def honest(scene: Scene, choice: int, step: Step, found: Sequence[Finding]) -> list[Finding]:
    """Return the findings of a choice: refused where the name needs more, else with its stability.

    Parameters
    ----------
    scene
        What findings are read from.
    choice, step
        The choice's place in the joint fit, and the turn that it was chosen in.
    found
        What would be told.
    """
    named = [one for one in found if one.verdict != "unknown"]
    if not named:
        return list(found)
    own = scene.joint.choices[choice].candidate.effect
    refusals = {id(one): _refusal(scene, one, own) for one in named}
    told = [one for one in named if refusals[id(one)] is None]
    comes_back = None
    if told:
        members = {name for one in told for name in one.members}
        members.update(identify.name(step.winner, step.trials, step.beside).members)
        comes_back = stability(scene, choice, step, members)
    out = []
    for one in found:
        refused = refusals.get(id(one))
        if refused is not None:
            out.append(_refused(one, refused))
        else:
            out.append(judged(one, comes_back) if comes_back is not None and one in told else one)
    return out


def judged(one: Finding, stability: Stability) -> Finding:
    """Return a finding with the verdict that its name's stability allows.

    Parameters
    ----------
    one
        A finding that has a name.
    stability
        How often that, or one of its class, came first on resampled data.
    """
    one = replace(one, stability=stability)
    verdict = stability.verdict(one.verdict)
    if stability.stable or one.verdict == "unknown":
        return one
    members = (*one.members, *(n for n in stability.returned if n not in one.members))
    counts = f"resampling {stability.resampled}, {stability.counts}"
    if verdict == "ambiguous" and len(members) <= MOST_MEMBERS:
        return replace(
            one,
            verdict=verdict,
            members=members,
            sentence=f"{one.sentence}; the name is not certain: {counts}",
            decide_by=decide_by(members) or f"more recordings like these: {counts}",
        )
    return _nameless(one, counts, decide_by(members) or "record more pointings where it is seen")


def _refusal(scene: Scene, one: Finding, chosen: Effect) -> Refusal | None:
    """Return why a finding of a choice is not named; what it is in single antennas may differ."""
    assert one.curve is not None  # noqa: S101 - what has a name has a curve
    effect = chosen if one.effect == chosen.id else known(one.effect)
    assert effect is not None  # noqa: S101 - a name is one of the catalogue
    return refusal(scene, effect, one.curve)


def _sentence(one: Finding) -> str:
    effect = known(one.effect)
    return one.effect if effect is None else effect.sentence


def _refused(one: Finding, why: Refusal) -> Finding:
    """Return a finding without its name, and why."""
    checks = (*one.checks, f"not named: {why.reason}")
    return replace(_nameless(one, why.reason, why.decide_by), checks=checks)


def _nameless(one: Finding, reason: str, next_: str) -> Finding:
    """Return a finding whose name became what it looks like; `next_` is what would decide."""
    shape = f" ({one.variant})" if one.variant else ""
    return replace(
        one,
        effect="unknown",
        members=("unknown",),
        verdict="unknown",
        sentence=f"something is left that these recordings cannot name: {reason}",
        looks_like=f"{_sentence(one)}: {one.effect}{shape}",
        decide_by=next_,
    )
