"""The verdict on a finding: can the recordings carry its name, and does that come back.

It decides the verdict: see `finding.Stability`. Whole sessions, or blocks of time, are drawn with
replacement. Their products add up, so a draw costs one small sum; the model, the other findings,
the name and its rivals are fitted anew in each.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.naming.classes import TIE, decide_by, fits_physics
from pyport.diagnosis.naming.finding import Finding, Stability
from pyport.diagnosis.naming.guards import Refusal, refusal
from pyport.diagnosis.naming.scene import Scene
from pyport.diagnosis.searching.confirming import confirmed
from pyport.diagnosis.searching.turns import Step
from pyport.diagnosis.trial import CandidateFit, at_best, shown_of, units
from pyport.effects import Effect, known
from pyport.least_squares.gram import inverse_of
from pyport.recordings.sky import clock
from pyport.runs.stages import stage
from pyport.thresholds import CONVINCING, ENOUGH_TO_RESAMPLE, MOST_MEMBERS, OUT_OF_REACH

DRAWS = 40
#: So many of the nearest names compete with it.
RIVALS = 4
#: With more columns than this the model stands as fitted to all the data, and is not drawn anew.
MOST_COLUMNS = 500
#: Blocks of time that are drawn where there are too few sessions.
UNITS = 40


@stage("resampling")
def stability(scene: Scene, choice: int, step: Step, members: Collection[str]) -> Stability:
    """Return how often the name of a choice comes first when the data are drawn anew.

    Parameters
    ----------
    scene
        What findings are read from.
    choice
        The choice's place in the joint fit.
    step
        The turn that it was chosen in, whose trials hold its rivals.
    members
        Ids of the effects that the data cannot tell from it: they count as the name itself.
    """
    problem, choices = scene.problem, scene.joint.choices
    own = choices[choice]
    others = [one for n, one in enumerate(choices) if n != choice]
    taken = {one.candidate.effect.id for one in others} | set(members)
    competing = [own, *(Chosen(one.candidate, one.scope) for one in _rivals(step, taken))]
    prices = [step.price, *(one.candidate.price for one in competing[1:])]
    columns, slices = _in_columns(scene, others, competing)
    resampled, unit = _units(problem, own)
    products = _products(columns, np.resize(unit, len(columns)))
    excess = [_excess(scene, one) for one in competing]
    rng = np.random.default_rng([problem.seed, choice])
    price, least = np.array(prices), 0.0
    share, scatter = np.ones_like(price), np.zeros_like(price)
    if confounded(problem, own.candidate.effect):
        # Most of a change's gain the noise could have had: its evidence, the price paid, is a
        # share of it. A gain scatters by twice its root, and so does what is left of it.
        odds = [confirmed(problem, others, one, one.candidate.price) for one in competing[1:]]
        sure = np.maximum([step.winner.evidence, *odds], 0.0)
        whole = _worths(products.sum(axis=0), slices, excess)
        share = np.clip(sure / np.maximum(whole, 1e-9), 1e-9, 1.0)
        scatter = 2 * np.sqrt(sure * (1 - share))
        price, least = np.zeros_like(price), CONVINCING
    first: Counter[str | None] = Counter()
    weak = 0
    for _ in range(DRAWS):
        times = np.bincount(rng.integers(0, len(products), len(products)), minlength=len(products))
        drawn = np.tensordot(times, products, axes=1)
        worth = share * _worths(drawn, slices, excess) - price
        worth = np.round(worth + scatter * rng.standard_normal(len(worth)), TIE)
        best = int(np.argmax(worth))
        if 0 < worth[best] <= least:
            weak += 1
            continue
        first[competing[best].candidate.effect.id if worth[best] > 0 else None] += 1
    kept = first.pop(own.candidate.effect.id, 0)
    names = {name: count for name, count in first.most_common() if name is not None}
    return Stability(resampled, DRAWS, kept, names, weak)


def _in_columns(
    scene: Scene, others: Sequence[Chosen], competing: Sequence[Chosen]
) -> tuple[Array, list[slice]]:
    """Return the whitened columns of a model, of what competes and the data, and where each is.

    A model of too many columns is projected out of the others instead: none of its own is left.
    """
    problem, white = scene.problem, scene.weighed.white
    parts = [problem.expanded([one], of=white) for one in competing]
    model = problem.expanded(others, of=white)
    columns = np.concatenate([model, *parts, white[:, -1:]], axis=1)
    if columns.shape[1] > MOST_COLUMNS:
        columns = columns[:, model.shape[1] :] - model @ _fitted(
            model, columns[:, model.shape[1] :]
        )
        model = model[:, :0]
    starts = np.cumsum([model.shape[1], *(part.shape[1] for part in parts)])
    return columns, [slice(int(a), int(b)) for a, b in pairwise(starts)]


def _fitted(model: Array, columns: Array) -> Array:
    """Return the coefficients of columns (n, K) in the model's (n, P), shape (P, K)."""
    return np.asarray(inverse_of(model.T @ model)[0] @ (model.T @ columns))


def _rivals(step: Step, taken: Collection[str]) -> list[CandidateFit]:
    """Return the best trials of the nearest other names."""
    found: dict[str, CandidateFit] = {}
    for trial in sorted(step.trials, key=lambda one: -round(one.evidence, TIE)):
        effect = trial.candidate.effect
        if trial.evidence < step.winner.evidence - OUT_OF_REACH or len(found) == RIVALS:
            break
        if not effect.physical or effect.id in taken or effect.id in found:
            continue
        if effect.consists_of and step.winner.candidate.effect.on_altaz not in effect.consists_of:
            continue
        if fits_physics(trial):
            found[effect.id] = trial
    return list(found.values())


def _excess(scene: Scene, one: Chosen) -> float:
    return scene.weighed.evidence.common.factor if "antenna" not in one.scope else 1.0


def _units(problem: Problem, own: Chosen) -> tuple[str, Codes]:
    """Return what is drawn together, and the number of the unit of each reading, shape (m,)."""
    sessions = problem.session
    effect = own.candidate.effect
    of_session = "session" in own.scope or effect.is_change or own.candidate.of_time
    if len(np.unique(sessions)) >= ENOUGH_TO_RESAMPLE and not of_session:
        return "sessions", sessions
    at = problem.recordings.at
    time = clock(at)
    if not np.isfinite(time).all():
        rng = np.random.default_rng(problem.seed)
        distinct, pointing = np.unique(problem.pointing, return_inverse=True)
        deal = rng.permutation(len(distinct)) % min(UNITS, len(distinct))
        return "pointings", deal[pointing]
    # Moments in the order of sessions and time; what was measured at one moment stays together.
    keys = np.stack([sessions, time[problem.stack.row]])
    moments, moment = np.unique(keys, axis=1, return_inverse=True)
    session = moments[0].astype(np.intp)
    rank = np.arange(len(session)) * UNITS // len(session)
    unit = np.unique(np.stack([session, rank]), axis=1, return_inverse=True)[1]
    return f"blocks of {'time' if 'time' in at else 'rows'}", unit.ravel()[moment.ravel()]


def _products(columns: Array, unit: Codes) -> Array:
    """Return the products of columns (n, K) within each unit, shape (units, K, K)."""
    count, size = int(unit.max()) + 1, columns.shape[1]
    out = np.zeros((count, size, size))
    order = np.argsort(unit, kind="stable")
    edges = np.searchsorted(unit[order], np.arange(count + 1))
    for one, (low, high) in enumerate(pairwise(edges)):
        rows = columns[order[low:high]]
        out[one] = rows.T @ rows
    return out


def _worths(drawn: Array, slices: list[slice], excess: list[float]) -> Array:
    """Return the evidence for each of some blocks of columns beside the model, its price unpaid.

    The model's columns are those before the first block's.
    """
    model = slices[0].start
    inverse = inverse_of(drawn[:model, :model])[0]
    cross = drawn[:model, model:]
    left = drawn[model:, model:] - cross.T @ inverse @ cross
    found = []
    for one, factor in zip(slices, excess, strict=True):
        own = slice(one.start - model, one.stop - model)
        length = units(np.sqrt(np.maximum(np.diag(drawn)[one], 0)))
        information, moments = left[own, own] / np.outer(length, length), left[own, -1] / length
        strength, along = shown_of(information, moments)
        found.append(at_best(strength / factor, along / factor)[0] if len(along) else -np.inf)
    return np.array(found)


def honest(scene: Scene, choice: int, step: Step, found: Sequence[Finding]) -> list[Finding]:
    """Return the findings of a choice: refused where the name needs more, else with its stability.

    Parameters
    ----------
    scene
        What findings are read from.
    choice, step
        The choice's place in the joint fit, and the turn that it was chosen in.
    found
        What would be reported.
    """
    named = [one for one in found if one.verdict != "unknown"]
    if not named:
        return list(found)
    own = scene.joint.choices[choice].candidate.effect
    refusals = {id(one): _refusal(scene, one, own) for one in named}
    kept = [one for one in named if refusals[id(one)] is None]
    comes_back = None
    if kept:
        members = {name for one in kept for name in one.members}
        members.update(step.called.members)
        comes_back = stability(scene, choice, step, members)
    out = []
    for one in found:
        refused = refusals.get(id(one))
        if refused is not None:
            out.append(_refused(one, refused))
        else:
            out.append(judged(one, comes_back) if comes_back is not None and one in kept else one)
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
    since = chosen.parameter if chosen.changes_with == "session" else None
    return refusal(scene, effect, one.curve, since)


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
