"""What each effect of a diagnosis takes off the residuals, the model refitted beside it."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.finding import Finding
from pyport.least_squares.gram import inverted
from pyport.page.picture import Layer


def visible(diagnosis: Diagnosis) -> list[Array]:
    """Return what each chosen effect takes off the residuals [rad], shape (m,) each.

    An effect's curve less what the model draws of it, in the same weighing as the joint fit. The
    model alone is fitted under a noise of its own; what that changes is shared out evenly, so that
    together they lead exactly from the residuals of the model alone to those of the joint fit.
    """
    setup, joint = diagnosis.setup, diagnosis.after
    gram = diagnosis.weighed.evidence.gram
    model = [setup.part(one) for one in setup.base]
    inverse = inverted(gram.cross(model, model))[0]
    base = setup.expanded(setup.base)
    found = []
    for n in range(len(setup.base), len(joint.choices)):
        chosen = joint.choices[n]
        values = joint.solution.values[joint.slice(n)]
        shift = inverse @ (gram.cross(model, [setup.part(chosen)]) @ values)
        found.append(setup.expanded([chosen]) @ values - base @ shift)
    if not found:
        return found
    rest = diagnosis.left(diagnosis.before) - diagnosis.left(diagnosis.after) - sum(found)
    return [one + rest / len(found) for one in found]


def layers(diagnosis: Diagnosis, curves: list[Array]) -> tuple[list[Layer], list[int | None]]:
    """Return the layers of a diagnosis, and for each finding the number of its layer.

    A layer is called what its findings call it: an effect without a name by its shape.
    """
    chosen = diagnosis.after.choices[len(diagnosis.setup.base) :]
    of_finding = [_layer_of(finding, diagnosis, curves) for finding in diagnosis.findings]
    found = []
    for n, one in enumerate(chosen):
        mine = [f for f, at in zip(diagnosis.findings, of_finding, strict=True) if at == n]
        effect = one.candidate.effect
        names = list(dict.fromkeys(f.effect for f in mine)) or [effect.id]
        name = " and ".join(names).replace("_", " ") + (
            f" ({effect.variant})" if effect.variant else ""
        )
        region = tuple(part for f in mine for part in f.where.region)
        curve = next((f.where.curve for f in mine if f.where.curve), ())
        since = next((f.where.since for f in mine if f.where.since), None)
        found.append(Layer(name, region, curve, since))
    return found, of_finding


def _layer_of(finding: Finding, diagnosis: Diagnosis, curves: list[Array]) -> int | None:
    """Return the number of the chosen effect that a finding is read from, None of a survey."""
    chosen = diagnosis.after.choices[len(diagnosis.setup.base) :]
    effects = [one.candidate.effect for one in chosen]
    if not effects:
        return None
    same = [n for n, one in enumerate(effects) if one.variant == finding.variant] or [
        *range(len(effects))
    ]
    named = [n for n in same if effects[n].id == finding.effect]
    if len(named) == 1:
        return named[0]
    # A shape has no name of its own, and what antennas share may have another: go by the curve.
    curve = finding.curve
    if curve is None:
        return (named or same)[0]
    return max(named or same, key=lambda n: abs(_cosine(curve, curves[n])))


def _cosine(one: Array, other: Array) -> float:
    length = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(one @ other) / length if length > 0 else 0.0
