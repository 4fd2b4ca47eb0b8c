"""A look in words, and for other programs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable

from pyport.angles import ARCSEC
from pyport.effects import degeneracies
from pyport.effects.base import Circumstances
from pyport.effects.empirical.drivers import unit_in_words
from pyport.planning.look import Look
from pyport.planning.suggest import Direction, on_axes
from pyport.recordings.schema import as_input, counted
from pyport.report import typed
from pyport.thresholds import SEEN

_WIDTH = 96
_SEEN = (
    "Effects that would show beside it, each alone: error of its coefficient, and how many times "
    "the model enlarges it"
)
#: Decisions of a class, and promises, that are listed; the JSON has them all.
MOST_DECISIONS, MOST_PROMISES = 4, 10
#: Inflation from which a coefficient of the model is listed.
LOOSE = 5.0
#: Terms of the model that take up an effect, listed at most.
MOST_TERMS = 3
#: A promise of less than this factor is none.
WORTH = 1.2


def text(look: Look) -> str:
    """Return a look as plain text."""
    lines = [
        *_head(look),
        "",
        "Sky",
        *_sky(look),
        "",
        f"What {look.model.name} itself would be known to",
        *_model(look),
        "",
        _SEEN,
        *_seen(look),
    ]
    for title, lines_of in (
        ("Taken up by the model, whatever their size", _hidden),
        ("Not distinguishable", _classes),
        ("Not testable: column missing or too little variation", _untestable),
        ("To observe next", _next),
        ("What that would bring: error of the first beside the second", _promises),
    ):
        if some := list(lines_of(look)):
            lines += ["", title, *some]
    wrapped = []
    for line in lines:
        lead = " " * (len(line) - len(line.lstrip()) + 2)
        wrapped += textwrap.wrap(line, _WIDTH, subsequent_indent=lead) or [""]
    return "\n".join(wrapped)


def _head(look: Look) -> Iterable[str]:
    whose = f", antenna {look.antenna} of {look.antennas}" if look.antennas > 1 else ""
    yield f"{counted(as_input(look.recordings))}{whose}, model {look.model.name}"
    yield f"Noise {look.noise / ARCSEC:.3g} arcsec ({look.how})."
    yield from (f"Warning: {one}." for one in look.recordings.notes)


def _sky(look: Look) -> Iterable[str]:
    cover = look.coverage
    low, high = look.elevations
    yield (
        f"  {cover.covered} of {cover.cells} cells above {cover.lowest_deg:.0f} deg hold a "
        f"recording ({100 * cover.covered / cover.cells:.0f} %); elevations {low:.0f} to "
        f"{high:.0f} deg"
    )
    for hole in cover.holes:
        yield (
            f"  nothing within {hole.distance_deg:.0f} deg of azimuth {hole.az_deg:.0f}, "
            f"elevation {hole.el_deg:.0f}"
        )


def _model(look: Look) -> Iterable[str]:
    for one in look.known:
        if not math.isfinite(one.sigma):
            yield f"  {one.name:<28} not determined"
            continue
        loose = f", {one.inflation:.0f} times its error alone" if one.inflation > LOOSE else ""
        yield f"  {one.name:<28} {one.sigma:8.3g} {unit_in_words(one.unit)}{loose}"
    yield f"  condition number {look.condition:.3g}"


def _seen(look: Look) -> Iterable[str]:
    for one in look.separation.seen:
        name = one.effect + (f" ({one.variant})" if one.variant else "")
        size = f"{one.sigma:8.2g} {unit_in_words(one.unit):<10}"
        yield f"  {name:<60.60} {size} x {one.inflation:.1f}"
        if one.known_sigmas is not None and one.known_sigmas < SEEN:
            terms = [
                f"{term} {value:+.3g} arcsec"
                for term, value in one.taken_for[:MOST_TERMS]
                if abs(value) * ARCSEC > look.noise
            ]
            if terms:
                yield f"    not seen at the size that physics gives it: {', '.join(terms)} instead"


def _hidden(look: Look) -> Iterable[str]:
    if look.separation.hidden:
        yield f"  {', '.join(look.separation.hidden)}"


def _classes(look: Look) -> Iterable[str]:
    for members in look.separation.classes:
        yield f"  {', '.join(members)}"
        decisions = degeneracies.decisions(members)
        for decide in decisions[:MOST_DECISIONS]:
            yield f"    next: {decide}"
        if len(decisions) > MOST_DECISIONS:
            yield f"    and {len(decisions) - MOST_DECISIONS} more"


def _untestable(look: Look) -> Iterable[str]:
    by_reason: dict[str, list[str]] = {}
    for one in look.untestable:
        names = by_reason.setdefault(one.reason, [])
        if one.effect not in names:
            names.append(one.effect)
    for reason, effects in sorted(by_reason.items()):
        yield f"  {reason}: {', '.join(effects)}"


def place(one: Direction, at: Circumstances) -> str:
    """Return a direction in words: on the sky, and on the axes of another mount."""
    where = f"azimuth {one.az_deg:3.0f}, elevation {one.el_deg:2.0f}"
    angles = on_axes(at, one.az_deg, one.el_deg) or {}
    named = zip(at.mount.axes, angles.values(), strict=False)
    where += "".join(f", {axis.name} {angle:.0f}" for axis, angle in named)
    if one.hour_angle_h is None:
        return where
    return f"{one.source} at hour angle {one.hour_angle_h:+.1f} h ({where})"


def _next(look: Look) -> Iterable[str]:
    for n, one in enumerate(look.next, 1):
        why = f": {one.decides[0]} or {one.decides[1]}" if one.decides else ""
        yield f"  {n}. {place(one, look.recordings.at)}{why}"


def _promises(look: Look) -> Iterable[str]:
    open_pairs = [
        f"{one.one} or {one.other}" for one in look.promises if one.before < WORTH * one.after
    ]
    kept = [one for one in look.promises if one.before >= WORTH * one.after]
    kept.sort(key=lambda one: one.after / one.before)
    for one in kept[:MOST_PROMISES]:
        unit = unit_in_words(one.unit)
        yield f"  {one.one} beside {one.other}: {one.before:.2g} -> {one.after:.2g} {unit}"
    if len(kept) > MOST_PROMISES:
        yield f"  and {len(kept) - MOST_PROMISES} more pairs"
    if open_pairs:
        yield f"  no direction decides {'; '.join(open_pairs)}"


def as_json(look: Look) -> dict[str, object]:
    """Return a look for other programs."""
    cover = look.coverage
    found: dict[str, object] = typed.as_json(
        {
            "schema": "pyport.look/1",
            "file": look.recordings.file.name,
            "input": as_input(look.recordings),
            "recordings": len(look.recordings),
            "warnings": look.recordings.notes,
            "antenna": look.antenna,
            "antennas": look.antennas,
            "model": look.model.name,
            "noise": {"arcsec": look.noise / ARCSEC, "how": look.how},
            "coverage": {
                "lowest_deg": cover.lowest_deg,
                "cells": cover.cells,
                "covered": cover.covered,
                "holes": [vars(hole) for hole in cover.holes],
            },
            "known": [vars(one) for one in look.known],
            "condition_number": look.condition,
            "effects": [
                {**vars(one), "alike": [{"effect": e, "share": s} for e, s in one.alike]}
                for one in look.separation.seen
            ],
            "taken_up": look.separation.hidden,
            "classes": [
                {"effects": members, "decide_by": degeneracies.decisions(members)}
                for members in look.separation.classes
            ],
            "not_testable": {one.effect: one.reason for one in look.untestable},
            "next": [vars(one) for one in look.next],
            "promises": [vars(one) for one in look.promises],
        }
    )
    return found
