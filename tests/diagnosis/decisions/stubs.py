"""Statistics made by hand, for the rules that decide by them."""

from types import SimpleNamespace

import numpy as np

from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.searching.turns import Step
from pyport.diagnosis.trial import CandidateFit
from pyport.effects import CATALOGUE, Circumstances

ONE_ANTENNA = SimpleNamespace(antennas=1, groups=lambda _: np.zeros(1, int))


def candidate(effect="refraction", choices=1, columns=1, **changes):
    """Return a candidate of the catalogue with columns of its own."""
    return Candidate(
        CATALOGUE[effect], np.arange(columns), tuple(range(columns)), choices, **changes
    )


def trial(effect="refraction", evidence=20.0, gain=None, sigma=1.0, value=None, **changes):
    """Return what a candidate gains; its coefficient has a sigma, in internal units."""
    of = changes.pop("of", None) or candidate(effect)
    known = {
        "scope": "all",
        "gain": evidence + 5 if gain is None else gain,
        "dof": 1,
        "delta_bic": evidence,
        "evidence": evidence,
        "noise_dof": 200,
        "values": np.array([1.0 if value is None else value]),
        "information": np.array([[1 / sigma**2]]),
        "drawn": np.ones(300),
    } | changes
    return CandidateFit(of, **known)


def beside(**alike):
    """Return a projection in which effects share a winner's curve to given squared cosines."""
    return SimpleNamespace(
        share=lambda _, other: alike.get(other.candidate.effect.id, 0.0),
        evidence=SimpleNamespace(numbers=100),
    )


def step(winner, chosen=None, trials=()):
    """Return a turn of the search in which a trial won."""
    chosen = Chosen(winner.candidate, winner.scope) if chosen is None else chosen
    return Step(winner, chosen, (winner, *trials), beside(), 1e-6)


def rows_with(n, **columns):
    """Return circumstances of n rows that have columns and nothing else."""
    return Circumstances(np.zeros(n), np.zeros(n), columns=columns)


def problem_with(**known):
    """Return as much of a problem as a rule looks at."""
    named = {one.effect.id: one.effect for one in known.get("candidates", ())}
    usual = {"blocks": ONE_ANTENNA, "base": (), "seed": 0, "named": tuple(named.values())}
    usual["remembered"] = lambda _key, _whose, make: make()
    usual |= {"precision": lambda _: 0.0}
    return SimpleNamespace(**(usual | known))
