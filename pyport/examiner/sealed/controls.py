"""Controls: what an examination scores that has nothing to go by must be what chance scores."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pyport.angles import Array
from pyport.examiner.sealed.judge import Verdict
from pyport.examiner.sealed.places import Table, numbers, read_table

_SHUFFLES = 500
_OFFSETS = frozenset({"d_az_deg", "d_el_deg"})


def shuffled_key(verdicts: Sequence[Verdict], rng: np.random.Generator) -> tuple[float, float]:
    """Return how often answers fit truths dealt out at random: mean, and 97.5 % of the deals."""
    names = np.array([str(one.spec["effect"]) for one in verdicts])
    said = np.array([one.said for one in verdicts])
    rates = [float(np.mean(said == rng.permutation(names))) for _ in range(_SHUFFLES)]
    return float(np.mean(rates)), float(np.quantile(rates, 0.975))


def metadata_only(paths: Sequence[Path], names: Sequence[str]) -> tuple[int, int]:
    """Return (hits, of) of a solver that sees all columns but the offsets.

    It has the truths of all other cases, and names that of the case whose
    columns are most like these in mean, spread and range.
    """
    features = _standardised(np.array([_summary(read_table(path)) for path in paths]))
    apart = np.linalg.norm(features[:, None, :] - features[None, :, :], axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = np.argmin(apart, axis=1)
    truth = np.array(names)
    return int(np.sum(truth[nearest] == truth)), len(truth)


def _summary(table: Table) -> list[float]:
    """Return what there is to see of a case besides its offsets."""
    summary = [float(len(table["el_deg"])), float("scan_axis" in table)]
    for column in sorted(set(table) - _OFFSETS - {"scan_axis"}):
        try:
            value = numbers(table, column)
        except ValueError:
            summary.append(float(len(set(table[column]))))
        else:
            summary += [float(f(value)) for f in (np.mean, np.std, np.min, np.max)]
    return summary


def _standardised(features: Array) -> Array:
    spread = features.std(axis=0)
    return (features - features.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
