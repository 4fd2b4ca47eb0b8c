"""Scoring a set that was opened: check the seals, judge every answer, write the score down."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.errors import BadInput
from pyport.examiner.sealed import score
from pyport.examiner.sealed.judge import Table, Verdict, judge, numbers, place, read_table
from pyport.examiner.sealed.protocol import THRESHOLDS, Spec
from pyport.examiner.sealed.published import read_report, read_seal
from pyport.examiner.sealed.seal import (
    Folder,
    check_answers,
    check_truths,
    check_untouched,
    write_json,
)
from pyport.examiner.sealed.skill import skill
from pyport.progress import track

#: Groups whose cases say what is gained on data left out.
_SKILLED = frozenset({"one", "curve", "moment"})


@dataclass(frozen=True)
class Score:
    """What a set scored, in full."""

    name: str
    sealed: dict[str, Any]
    verdicts: list[Verdict]
    rows: list[score.Row]

    @property
    def passed(self) -> bool:
        """Tell whether no row that has a threshold fails."""
        return all(row.passed is not False for row in self.rows)


def examine(root: Path, jobs: int = 1, solver_sha256: str | None = None) -> Score:
    """Score a set.

    Raises `BadInput`: it was not opened yet, or truths, recordings, reports, solver, examiner or
      thresholds are not those that were sealed.
    """
    folder = Folder(root)
    sealed = read_seal(folder.seal)
    if not folder.answers.exists():
        raise BadInput("this set is still sealed: expected one that was opened", root)
    check_untouched(root, solver_sha256)
    check_answers(root)
    truths = check_truths(folder.opened, sealed)
    tasks = [(folder, case, truth) for case, truth in truths.items()]
    with ProcessPoolExecutor(jobs) as pool:
        judged = track(pool.map(_judge, tasks, chunksize=4), "scoring", total=len(tasks))
        verdicts = list(judged)
    rows = [*score.table(verdicts), *_controls(folder, verdicts)]
    whole = Score(sealed["name"], sealed, verdicts, rows)
    write_json(root / "score.json", as_json(whole))
    return whole


def _judge(task: tuple[Folder, str, dict[str, Any]]) -> Verdict:
    folder, case, truth = task
    report = read_report(folder.report(case))
    verdict = judge(case, truth, report)
    table = read_table(folder.recordings(case))
    verdict = replace(
        verdict, place=place(table, report.get("findings", []), truth["truth"]["effects"])
    )
    loud = verdict.spec["rho"] >= THRESHOLDS["skill_rho_least"]
    if verdict.group in _SKILLED and loud and folder.rows(case).exists():
        made = Spec(**truth["spec"]).make(truth["seed"])
        verdict = replace(verdict, skill=skill(made, folder.recordings(case), folder.rows(case)))
    return verdict


def _controls(folder: Folder, verdicts: Iterable[Verdict]) -> list[score.Row]:
    """Return the rows of answers dealt out at random and of a solver without offsets."""
    least = THRESHOLDS["one_rho_least"]
    named = [one for one in verdicts if one.group == "one" and one.spec["rho"] >= least]
    if len(named) < 2:
        return []
    names = [str(one.spec["effect"]) for one in named]
    mean, high = shuffled_key(named, np.random.default_rng(len(named)))
    hits, of = metadata_only([folder.recordings(one.case) for one in named], names)
    blind = score.Rate(hits, of)
    chance = 1 / len(set(names))
    return [
        score.Row(
            "control, shuffled key: class right first",
            f"{100 * mean:.1f} % (97.5 % of deals below {100 * high:.1f} %)",
            f"chance, about {100 * chance:.1f} %",
            mean <= 3 * chance,
        ),
        score.Row(
            "control, metadata only: class right",
            str(blind),
            f"chance, {100 * chance:.1f} %, inside the interval",
            blind.interval[0] <= chance,
        ),
    ]


def as_json(whole: Score) -> dict[str, Any]:
    """Return the score as plain data."""
    within_one, within_two = score.pulls(whole.verdicts)
    return {
        "name": whole.name,
        "passed": whole.passed,
        "table": [asdict(row) for row in whole.rows],
        "confusion": [list(line) for line in score.confusion(whole.verdicts)],
        "calibration": [[level, str(rate)] for level, rate in score.calibration(whole.verdicts)],
        "pulls": {"within_one_sigma": str(within_one), "within_two_sigma": str(within_two)},
        "verdicts": [_plain(one) for one in whole.verdicts],
    }


def _plain(verdict: Verdict) -> dict[str, Any]:
    """Return a verdict as JSON can hold it: a place that was not found is null."""
    found = {key: value if np.isfinite(value) else None for key, value in verdict.place.items()}
    return {**asdict(verdict), "place": found}


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
