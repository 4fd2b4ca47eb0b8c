"""Before a finding is told: can the recordings carry its name, and does that come back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pyport.diagnosis import identify
from pyport.diagnosis.finding import Finding
from pyport.diagnosis.guards import Refusal, refusal
from pyport.diagnosis.resampling import stability
from pyport.diagnosis.scene import Scene
from pyport.diagnosis.steps import Step
from pyport.effects import CATALOGUE


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
    refusals = {id(one): _refusal(scene, one) for one in named}
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
            out.append(replace(one, stability=comes_back) if one in told else one)
    return out


def _refusal(scene: Scene, one: Finding) -> Refusal | None:
    assert one.curve is not None  # noqa: S101 - what has a name has a curve
    return refusal(scene, CATALOGUE[one.effect], one.curve)


def _refused(one: Finding, why: Refusal) -> Finding:
    """Return a finding without its name, and why."""
    shape = f" ({one.variant})" if one.variant else ""
    return replace(
        one,
        effect="unknown",
        members=("unknown",),
        verdict="unknown",
        sentence=f"something is left that these recordings cannot name: {why.reason}",
        looks_like=f"{CATALOGUE[one.effect].sentence}: {one.effect}{shape}",
        decide_by=why.decide_by,
        checks=(*one.checks, f"not named: {why.reason}"),
    )
