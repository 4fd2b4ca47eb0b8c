"""A finding as the report spells it."""

from __future__ import annotations

from pyport.angles import ARCSEC
from pyport.diagnosis import finding as found
from pyport.diagnosis import stability
from pyport.fitting import combinations
from pyport.report.typed import Combination, Finding, HeldOut, Known, Place, Stability


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
        where=Place(where.axes, where.subset, where.region, curve, where.since),
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
    )


def _stability(one: stability.Stability) -> Stability:
    return Stability(
        **vars(one),
        instead=one.instead,
        nameless=one.nameless,
        stable=one.stable,
        words=one.words,
    )


def combination_of(one: combinations.Combination) -> Combination:
    """Return a combination of coefficients as the report spells it."""
    told = one.as_json()
    return Combination(**told | {"known": tuple(Known(**each) for each in told["known"])})
