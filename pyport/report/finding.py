"""A finding as the report spells it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.joint import sigmas
from pyport.diagnosis.naming import finding as found
from pyport.effects.empirical.fields import UNKNOWN
from pyport.fitting import combinations
from pyport.models.complete import Left, Solved, complete
from pyport.models.model import Model, Term
from pyport.recordings.schema import group
from pyport.report.typed import Combination, Finding, HeldOut, Known, Place, Stability, as_json


def finding_of(one: found.Finding) -> Finding:
    """Return a finding as the report spells it."""
    where = one.where
    curve = None
    if where.curve is not None:
        curve = tuple({"az_deg": az, "el_deg": el} for az, el in where.curve)
    return Finding(
        effect=one.effect,
        variant=one.variant,
        class_=one.members,
        verdict=one.verdict,
        sentence=one.sentence,
        where=Place(
            where.axes,
            where.subset,
            where.region,
            curve,
            where.since,
            where.until,
            where.between,
        ),
        parameters=one.parameters,
        evidence=one.evidence,
        visible_rms_arcsec=one.visible_rms / ARCSEC,
        true_rms_arcsec=one.true_rms / ARCSEC if one.true_rms <= one.largest else None,
        heldout=None if one.heldout is None else held_out_of(one.heldout),
        looks_like=one.looks_like,
        decide_by=one.decide_by,
        checks=one.checks,
        stability=None if one.stability is None else _stability(one.stability),
        combination=None if one.combination is None else combination_of(one.combination),
        size=one.size,
    )


def held_out_of(one: found.HeldOut) -> HeldOut:
    """Return rms of predictions as the report spells them."""
    return HeldOut(
        one.scheme,
        one.before / ARCSEC,
        one.after / ARCSEC,
        one.noise_floor / ARCSEC,
        one.gross,
        None if one.fall_sigma is None else one.fall_sigma / ARCSEC,
    )


def _stability(one: found.Stability) -> Stability:
    return Stability(
        **vars(one), instead=one.instead, nameless=one.nameless, stable=one.stable, words=one.words
    )


def combination_of(one: combinations.Combination) -> Combination:
    """Return a combination of coefficients as the report spells it."""
    values = one.as_json()
    return Combination(**values | {"known": tuple(Known(**each) for each in values["known"])})


def completed(diagnosis: Diagnosis) -> Model:
    """Return the model that leaves what the diagnosis leaves; see `pyport.models`."""
    problem, fit = diagnosis.problem, diagnosis.after
    plain = np.sqrt(np.maximum(np.diag(fit.solution.covariance), 0.0))
    sigma = sigmas(fit)
    for choice, chosen in enumerate(fit.choices):
        where = fit.slice(choice)
        sigma[where] = np.hypot(sigma[where], chosen.spread)
    # The same correlations, with errors widened as those that are stated of each coefficient.
    wider = np.divide(sigma, plain, out=np.zeros_like(sigma), where=plain > 0)
    covariance = fit.solution.covariance * np.outer(wider, wider)
    solved = [
        one
        for choice, term in enumerate(_terms(diagnosis))
        for one in _solved(diagnosis, choice, term, sigma, base=choice < len(problem.base))
    ]
    return complete(
        problem.model,
        problem.recordings,
        solved,
        covariance,
        by="diagnose",
        left=Left(diagnosis.left(fit), diagnosis.weighed.used, problem.stack),
        findings=[as_json(finding_of(one)) for one in diagnosis.findings],
    )


def _terms(diagnosis: Diagnosis) -> list[Term]:
    """Return the term of every choice: the model's, then one for each that was found."""
    problem = diagnosis.problem
    fitted = [chosen.candidate.effect for chosen in problem.base]
    own = [term for term in problem.model.terms if any(term.effect is one for one in fitted)]
    found = diagnosis.after.choices[len(own) :]
    return [*own, *(_found(one, _number(diagnosis, len(own) + n)) for n, one in enumerate(found))]


def _found(chosen: Chosen, number: int | None) -> Term:
    """Return what was found as a term of a model; what has no name is not fitted again."""
    per = tuple(label for label in ("antenna", "session") if label in chosen.scope)
    effect = chosen.candidate.effect
    return Term(effect, per, fixed=effect.id == UNKNOWN, finding=number)


def _number(diagnosis: Diagnosis, choice: int) -> int | None:
    """Return the number, from 1, of the first finding that was read from a choice."""
    for n, finding in enumerate(diagnosis.findings, 1):
        if finding.choice == choice:
            return n
    return None


def _solved(
    diagnosis: Diagnosis, choice: int, term: Term, sigma: Array, *, base: bool
) -> Iterator[Solved]:
    problem, fit = diagnosis.problem, diagnosis.after
    chosen = fit.choices[choice]
    start = int(fit.starts[choice])
    k, width = len(term.effect.coefficients), len(chosen.candidate.columns)
    rest = [label for label in term.per if label not in ("antenna", "session")] if base else []
    others = group(problem.recordings, rest)[1]
    groups = problem.blocks.groups(chosen.scope)
    for number, block in enumerate(np.unique(groups, return_index=True)[1]):
        labels_of = {
            "antenna": problem.blocks.antenna[block],
            "session": problem.blocks.session[block],
        }
        for n, other in enumerate(others):
            labels_of |= dict(zip(rest, other, strict=True))
            which = [
                (place, of)
                for place, of in enumerate(chosen.candidate.coefficients)
                if place // k == n or not base
            ]
            change, errors = np.zeros(k), np.zeros(k)
            places, known = [-1] * k, [False] * k
            for place, of in which:
                at = start + number * width + place
                change[of], errors[of] = fit.solution.values[at], sigma[at]
                places[of], known[of] = at, bool(fit.solution.known[at])
            labels = tuple(str(labels_of[label]) for label in term.per)
            yield Solved(term, labels, change, errors, places, known)
