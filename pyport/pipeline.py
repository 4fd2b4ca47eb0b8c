"""A diagnosis from a file of recordings to the folder of its report, one for each file."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.diagnosis.arrays.report import report as report_array
from pyport.diagnosis.arrays.report import with_site
from pyport.diagnosis.arrays.words import words
from pyport.diagnosis.diagnose import diagnose
from pyport.errors import BadInput
from pyport.formats.models import load
from pyport.models.model import Model
from pyport.recordings import read, resolve
from pyport.recordings.files import Survey
from pyport.recordings.raw import NOTHING, FileOptions
from pyport.recordings.stream import is_data_set, pass_files
from pyport.report.finding import completed
from pyport.runs.stages import stage, timed, track, working
from pyport.runs.workers import Spread, workers


@dataclass(frozen=True)
class Request:
    """One file to diagnose; where its folder and the completed model go, None for nowhere.

    `in_use` says that its offsets are what the model left.
    """

    file: Path
    model: str
    refit: tuple[str, ...] | None
    seed: int
    folder: Path | None
    given: FileOptions = NOTHING
    survey: Survey | None = None
    save: Path | None = None
    in_use: bool = False


@dataclass(frozen=True)
class Done:
    """What one diagnosis has to say: plain text, the report on one line, and what took how long.

    `seconds` are those of each stage, the stages inside it not counted.
    """

    folder: Path | None
    summary: str
    report: str
    seconds: dict[str, float]


def requests(
    names: Sequence[str],
    *,
    model: str,
    refit: str,
    seed: int,
    out: Path | None,
    given: FileOptions = NOTHING,
    survey: Survey | None = None,
    save: Path | None = None,
    in_use: bool = False,
) -> list[Request]:
    """Check the arguments and return what is to be done.

    Raises `BadInput`: a file or model is missing, two files would share a folder, or `refit` names
      an effect that the model does not hold.
    """
    held = ids_of(load(model), refit)
    files = [resolve(name) for name in names]
    stems = [file.stem for file in files]
    for stem in stems:
        if stems.count(stem) > 1:
            raise BadInput(f"two files are called {stem}: their results would share a folder", out)
    folders = [None if out is None else out / stem for stem in stems]
    return [
        Request(file, model, held, seed, folder, given, survey, save, in_use)
        for file, folder in zip(files, folders, strict=True)
    ]


def ids_of(model: Model, refit: str) -> tuple[str, ...] | None:
    """Return the ids of the effects to refit; None for all of them."""
    if refit == "all":
        return None
    names = () if refit == "none" else tuple(name.strip() for name in refit.split(","))
    known = [term.effect.id for term in model.terms]
    for name in names:
        if name not in known:
            raise BadInput(
                f"--refit: the model {model.name} has no effect {name!r}, it has {', '.join(known)}"
            )
    return names


def apart(names: Sequence[str], label: str) -> list[str]:
    """Return the parts of data sets whose folders are named by a label, `LABEL=VALUE`.

    Raises `BadInput`: a name is no such data set.
    """
    found = []
    for name in names:
        parts = sorted(one for one in Path(name).glob(f"{label}=*") if is_data_set(one))
        if not parts:
            raise BadInput(f"--each {label}: no folders {label}=NAME with Parquet files", name)
        found += [str(one) for one in parts]
    return found


def run_all(wanted: Sequence[Request], jobs: int = 1, cluster: str | None = None) -> Iterator[Done]:
    """Diagnose every file and yield the results in the order of the requests.

    A single data set is gone through by all workers, several inputs go to one worker each.
    """
    with workers(jobs, cluster) as spread:
        if len(wanted) == 1:
            with working(f"diagnosing {wanted[0].file.name}") as tell:
                done = run_one(wanted[0], tell, spread)
            yield done
        else:
            yield from track(spread(run_one, wanted), "diagnosing", total=len(wanted))


def run_one(
    request: Request, tell: Callable[[str], None] = lambda _: None, spread: Spread[Any, Any] = map
) -> Done:
    """Diagnose one file and write its folder."""
    with timed() as clock:
        text, report = _run_one(request, tell, spread)
    return Done(request.folder, text, report, clock.seconds)


@stage("writing pages and pictures")
def _run_one(
    request: Request, tell: Callable[[str], None], spread: Spread[Any, Any]
) -> tuple[str, str]:
    """Return the summary and the report of one file."""
    from pyport import page
    from pyport.formats.completed import write_model
    from pyport.plots.findings import write_findings
    from pyport.plots.places import write_places
    from pyport.report.folder import text as in_words
    from pyport.report.folder import write
    from pyport.report.made import report_of
    from pyport.report.typed import as_json

    recordings = stage("reading")(read)(request.file, request.given, spread, request.folder)
    model = load(request.model)
    if request.in_use:
        recordings = model.added_to(recordings)
    diagnosis = diagnose(recordings, model, refit=request.refit, seed=request.seed, tell=tell)
    array = None
    if diagnosis.problem.blocks.antennas > 1 or request.survey is not None:
        array = report_array(diagnosis.problem, diagnosis.after, request.survey)
        diagnosis = with_site(diagnosis, array)
    contents = report_of(diagnosis, array)
    text = in_words(contents)
    if array is not None:
        text += "\n" + words(array)
    if (folder := request.folder) is None:
        report = as_json(contents)
    else:
        beside = write_findings(diagnosis, folder)
        beside.append(page.write(*page.of_diagnosis(diagnosis, contents), folder / "report.html"))
        if array is not None and (places := write_places(array, folder)) is not None:
            beside.append(places)
        report = write(diagnosis, folder, contents, beside)
        for kept in pass_files(folder):
            kept.unlink(missing_ok=True)
    if request.save is not None:
        saved = write_model(completed(diagnosis), request.save)[2].words
        text += f"\n{request.save}: {saved}" if saved else ""
    return text, json.dumps(report)
