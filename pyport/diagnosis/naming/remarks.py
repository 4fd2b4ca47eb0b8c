"""What is said beside findings: of the fits, and where there is nothing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pyport.angles import ARCSEC
from pyport.diagnosis.candidates import conditions
from pyport.diagnosis.joint import Joint, rms, without_found
from pyport.diagnosis.naming.guards import smallest_seen
from pyport.diagnosis.naming.noise_remarks import DIFFER, NoiseRemarks
from pyport.effects.empirical.conditions import MOST_DRIVERS, OF_WEATHER, untried
from pyport.fitting.soundness import doubts, linear
from pyport.models.conditions import undetermined
from pyport.thresholds import FAMILY_ERROR, MOST_FINDINGS

if TYPE_CHECKING:
    from pyport.diagnosis.diagnose import Diagnosis


def warnings(diagnosis: Diagnosis, noise: NoiseRemarks) -> list[str]:
    """Return a sentence for everything that a user should know before trusting the numbers."""
    found = [*noise.outlying, *_lost(diagnosis)]
    alone = list(_of(diagnosis, diagnosis.before))
    found += [f"fit of the model: {one}" for one in alone]
    if diagnosis.findings:
        both = (one for one in _of(diagnosis, diagnosis.after) if one not in alone)
        found += [f"fit with what was found: {one}" for one in both]
    if len(diagnosis.steps) >= MOST_FINDINGS:
        found.append(
            f"the search did not come to its end: it stopped at {MOST_FINDINGS} effects, and more "
            "may be left"
        )
    if left := untried(conditions(diagnosis.problem.recordings)):
        found.append(
            f"{MOST_DRIVERS} conditions at most are tried as what a term follows: not "
            f"{', '.join(left)}"
        )
    return found


def _lost(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield that the offsets are too large for terms that only add up, if they are."""
    problem, after = diagnosis.problem, diagnosis.after
    left = rms(diagnosis.left(after), diagnosis.share)
    value = without_found(problem, after)
    if diagnosis.too_few is None:
        yield from linear(problem.stack, problem.recordings.at, value, diagnosis.weighed.used, left)


def _of(diagnosis: Diagnosis, fit: Joint) -> Iterator[str]:
    """Yield what is wrong with one fit."""
    solution = fit.solution
    known = solution.known
    free = np.count_nonzero(diagnosis.problem.precision(fit.choices) == 0)
    if wrong := undetermined(len(diagnosis.problem.residual), int(free)):
        yield wrong
        return
    if not known.all():
        of_choice = np.repeat(np.arange(len(fit.choices)), np.diff(fit.starts))
        names = [fit.choices[n].candidate.effect.id for n in np.unique(of_choice[~known])]
        yield (
            f"{int((~known).sum())} of {len(known)} coefficients are not determined, of "
            f"{', '.join(dict.fromkeys(names))}"
        )
    yield from doubts(
        condition=solution.condition,
        covariance=solution.covariance[np.ix_(known, known)],
        numbers=int(diagnosis.weighed.used.sum()),
        rank=solution.rank,
    )


def determines_nothing(diagnosis: Diagnosis) -> str | None:
    """Return that these directions determine nothing of the model, None where they do."""
    known = diagnosis.before.solution.known
    if diagnosis.too_few is not None or not len(known) or known.any():
        return None
    return (
        f"None of the {len(known)} coefficients of {diagnosis.problem.model.name} is determined: "
        "these recordings point in one direction, or in directions too much alike, and show no "
        "model."
    )


def nothing(diagnosis: Diagnosis, noise: NoiseRemarks) -> str:
    """Return what is said where no finding is: what was looked for, and how little was to be seen.

    No finding is no all-clear: few recordings show large effects only, and what is left may not
    look like noise though no effect that was tried is more than noise can do.
    """
    seen = smallest_seen(diagnosis.detection_limits)
    more = "" if seen is None else f"; {seen}"
    if diagnosis.too_few is not None:
        return f"{diagnosis.too_few.sentence}{more}"
    if diagnosis.p_value > FAMILY_ERROR:
        beside = " beside the outliers, which are no gross errors" if noise.outlying else ""
        hides = _hides(diagnosis, noise)
        if (near := diagnosis.nearest) is not None:
            which = f"{near.effect} ({near.variant})" if near.variant else near.effect
            said = f"the nearest is {which}: {near.reason}"
            return f"Nothing is certain to be missing{beside}; {said}{hides}"
        return f"Nothing is missing that these recordings could show{beside}{hides}{more}"
    return (
        "What is left does not look like the noise that was assumed, but no effect that was tried "
        "has odds of twenty to one and predicts unseen data better"
    )


def _hides(diagnosis: Diagnosis, noise: NoiseRemarks) -> str:
    """Return what counts as noise though it is none: departures, drifts, an uneven session."""
    scatter = [np.hypot(one.within, one.between) for one in diagnosis.weighed.covariance.noises]
    usual = float(np.median(scatter)) / ARCSEC
    largest = {}
    for one in sorted(noise.departing, key=lambda one: float(one["sigma_arcsec"])):
        # What departs by less than a pointing scatters is not seen in a picture either.
        if abs(one["most_arcsec"]) > usual:
            most = f"{one['most_arcsec']:.2g} in {one['most_label']}"
            sizes = f"{one['sigma_arcsec']:.2g} arcsec rms ({most})"
            largest[one["of"]] = f"{DIFFER[one['of']]} differ in the {one['term']} by {sizes}"
    said = [text for of, text in largest.items() if of != "source"]
    said += [f"{one['axis']} drifts by {one['rms_arcsec']:.2g} arcsec" for one in noise.drifting]
    remarks = []
    if said:
        sizes = " and ".join(said)
        remarks.append(f"whether something changed with time stays open: {sizes}")
        if not OF_WEATHER & diagnosis.problem.recordings.at.columns.keys():
            remarks.append("no weather is recorded that it might follow, as temperature_c would be")
    if "source" in largest:
        remarks.append(f"{largest['source']}, which counts as noise")
    alone = "which is worth a diagnosis of its own"
    remarks += [f"{one[0].lower()}{one[1:]}, {alone}" for one in noise.uneven]
    remarks += [f"but {one[0].lower()}{one[1:]}" for one in noise.beyond]
    return "".join(f"; {one}" for one in remarks)
