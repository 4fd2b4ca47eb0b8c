"""Scoring a set that was opened: check the seals, judge every answer, write the score down.

The examiner knows the noise, so it can ask of each prediction of a reading that
was held out how far it is from the noiseless truth. R0 is that of the base
alone, R1 that of the tool's model, R* that of a refit of the true form; the
gain is R0^2 - R1^2, what could be gained R0^2 - R*^2.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.errors import BadInput
from pyport.examiner.ideal import observer
from pyport.examiner.sealed.protocol import THRESHOLDS, Spec
from pyport.examiner.sealed.record.files import Rate
from pyport.examiner.sealed.record.published import read_report, read_seal
from pyport.examiner.sealed.scoring import overall, score
from pyport.examiner.sealed.scoring.judge import Table, Verdict, judge, numbers, place, read_table
from pyport.examiner.sealed.seal import (
    Folder,
    check_answers,
    check_truths,
    check_untouched,
    write_json,
)
from pyport.examiner.worlds.case import Case
from pyport.runs.stages import track

_FOLDS = 10


def skill(case: Case, recordings: Path, rows: Path) -> tuple[float, float] | None:
    """Return gained and gainable mean squares on held-out readings, in units of the noise's.

    `case`: the case of one antenna, made again from its seed.
    `recordings`: what the solver saw.
    `rows`: the solver's residuals on data left out, by line and axis.
    Returns `gained`, `gainable`: or None where the rows do not say what was predicted.
    """
    measured = _measured(recordings)
    before, after = _left_out(rows, recordings, measured.shape[1])
    sigma = _sigma(case)
    clean = np.stack(case.clean)
    noise = measured - clean
    misfit_before, misfit_after = (before - noise) / sigma, (after - noise) / sigma
    misfit_best = (clean - _best(case, measured)) / sigma
    known = np.isfinite(misfit_before) & np.isfinite(misfit_after)
    if not known.any():
        return None
    start, end, best = (
        float(np.mean(misfit[known] ** 2)) for misfit in (misfit_before, misfit_after, misfit_best)
    )
    return start - end, start - best


def _sigma(case: Case) -> Array:
    """Return the noise per axis [rad], shape (2, 1)."""
    noise = case.truth["noise"]
    return np.array([[noise["xel_arcsec"]], [noise["el_arcsec"]]]) * ARCSEC


def _measured(recordings: Path) -> Array:
    """Return both measured offsets [rad], x across, shape (2, n); NaN where not measured."""
    table = read_table(recordings)
    el = numbers(table, "el_deg") * DEG
    measured = np.full((2, len(el)), np.nan)
    on_sky = (("d_az_deg", np.cos(el)), ("d_el_deg", np.ones_like(el)))
    for axis, (column, scale) in enumerate(on_sky):
        if column in table:
            measured[axis] = numbers(table, column) * DEG * scale
    return measured


def _left_out(rows: Path, recordings: Path, count: int) -> tuple[Array, Array]:
    """Return the solver's residuals of readings left out [rad], before and after, (2, n) each."""
    with recordings.open(encoding="utf-8") as file:
        first_line = 2 + sum(1 for line in file if line.startswith("#"))
    before, after = np.full((2, count), np.nan), np.full((2, count), np.nan)
    try:
        with rows.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                place = (0 if row["axis"] == "xel" else 1), int(row["line"]) - first_line
                for values, column in ((before, "before"), (after, "after")):
                    text = row[f"heldout_{column}_arcsec"]
                    values[place] = float(text) * ARCSEC if text else np.nan
    except (KeyError, TypeError, ValueError, IndexError, csv.Error) as error:
        wanted = "expected columns axis, line, heldout_before_arcsec and heldout_after_arcsec"
        raise BadInput(f"{type(error).__name__} {error}: {wanted}", rows) from None
    return before, after


def _best(case: Case, measured: Array) -> Array:
    """Return what the base and the true form, refitted without a fold, predict of it, (2, n)."""
    columns = np.stack(case.base)
    form = np.stack(case.signature)[:, :, None]
    design = np.concatenate([columns, form / (np.abs(form).max() or 1.0)], axis=2)
    sigma = _sigma(case)
    known = np.isfinite(measured)
    predicted = np.full(measured.shape, np.nan)
    fold = _folds(case)
    for one in np.unique(fold):
        fitted = known & (fold != one)
        weighed = (design / sigma[:, :, None])[fitted]
        values, *_ = np.linalg.lstsq(weighed, (measured / sigma)[fitted], rcond=1e-12)
        predicted[:, fold == one] = (design @ values)[:, fold == one]
    return predicted


def _folds(case: Case) -> NDArray[np.intp]:
    """Return the session of each row, or one of ten stretches where a session is what is hidden."""
    if any(cause["effect"].startswith("epoch") for cause in case.truth["effects"]):
        count = len(case.columns["el_deg"])
        return np.arange(count) * 7919 % count * _FOLDS // count
    return np.unique(case.columns["session"], return_inverse=True)[1]


#: Groups whose cases are made again to ask what is gained on data left out; that of one cause whose
#: noise an observer can know.
_SKILLED = frozenset(
    {*("null", "one", "rows", "curve", "moment", "two", "three", "unknown", "when"), "oscillation"}
)
_OBSERVED = frozenset({"one", "rows"})


@dataclass(frozen=True)
class Score:
    """What a set scored, in full."""

    name: str
    sealed: dict[str, Any]
    verdicts: list[Verdict]
    rows: list[overall.Row]

    @property
    def passed(self) -> bool:
        """Tell whether no row that has a threshold fails."""
        return all(row.passed is not False for row in self.rows)


def examine(root: Path, jobs: int = 1) -> Score:
    """Score a set.

    Raises `BadInput`: it was not opened yet, or truths, recordings, reports, solver, examiner or
      thresholds are not those that were sealed.
    """
    folder = Folder(root)
    sealed = read_seal(folder.seal)
    if not folder.answers.exists():
        raise BadInput("this set is still sealed: expected one that was opened", root)
    check_untouched(root)
    check_answers(root)
    whole = scored(folder, check_truths(folder.opened, sealed), jobs)
    write_json(root / "score.json", as_json(whole))
    return whole


def scored(folder: Folder, truths: dict[str, dict[str, Any]], jobs: int = 1) -> Score:
    """Return the score of the answers in a folder, held to the truths by case."""
    sealed = read_seal(folder.seal)
    verdicts = judged(folder, truths, jobs)
    rows = [*score.table(verdicts), *_controls(folder, verdicts)]
    return Score(sealed["name"], sealed, verdicts, rows)


def judged(folder: Folder, truths: dict[str, dict[str, Any]], jobs: int = 1) -> list[Verdict]:
    """Return what every answer is worth."""
    tasks = [(folder, case, truth) for case, truth in truths.items()]
    with ProcessPoolExecutor(jobs) as pool:
        return list(track(pool.map(_judge, tasks, chunksize=4), "scoring", total=len(tasks)))


def _judge(task: tuple[Folder, str, dict[str, Any]]) -> Verdict:
    folder, case, truth = task
    report = read_report(folder.report(case))
    verdict = judge(case, truth, report)
    table = read_table(folder.recordings(case))
    verdict = replace(
        verdict, place=place(table, report.get("findings", []), truth["truth"]["effects"])
    )
    if verdict.group not in _SKILLED or verdict.spec["mount"] or verdict.spec["little"]:
        return verdict
    made = Spec(**truth["spec"]).make(truth["seed"])
    if verdict.group in _OBSERVED and verdict.spec["rho"]:
        verdict = replace(verdict, possible=observer.possible(made))
    if folder.rows(case).exists():
        verdict = replace(verdict, skill=skill(made, folder.recordings(case), folder.rows(case)))
    return verdict


def _controls(folder: Folder, verdicts: Iterable[Verdict]) -> list[overall.Row]:
    """Return the rows of answers dealt out at random and of a solver without offsets."""
    least = THRESHOLDS["one_rho_least"]
    named = [one for one in verdicts if one.group == "one" and one.spec["rho"] >= least]
    if len(named) < 2:
        return []
    names = [str(one.spec["effect"]) for one in named]
    mean, high = shuffled_key(named, np.random.default_rng(len(named)))
    hits, of = metadata_only([folder.recordings(one.case) for one in named], names)
    blind = Rate(hits, of)
    chance = 1 / len(set(names))
    return [
        overall.Row(
            "control, shuffled key: class right first",
            f"{100 * mean:.1f} % (97.5 % of deals below {100 * high:.1f} %)",
            f"chance, about {100 * chance:.1f} %",
            mean <= 3 * chance,
        ),
        overall.Row(
            "control, metadata only: class right",
            str(blind),
            f"chance, {100 * chance:.1f} %, inside the interval",
            blind.interval[0] <= chance,
        ),
    ]


def as_json(whole: Score) -> dict[str, Any]:
    """Return the score as plain data."""
    within_one, within_two = overall.pulls(whole.verdicts)
    return {
        "name": whole.name,
        "passed": whole.passed,
        "table": [asdict(row) for row in whole.rows],
        "confusion": [list(line) for line in overall.confusion(whole.verdicts)],
        "calibration": [[level, str(rate)] for level, rate in overall.calibration(whole.verdicts)],
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
    features = np.array([_summary(read_table(path)) for path in paths])
    spread = features.std(axis=0)
    features = (features - features.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
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
