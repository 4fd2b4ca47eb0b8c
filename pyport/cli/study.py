"""`pyport study`: the analyses of two documents, repeated on their data."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pyport.cli.manners import PATH, flag, in_json, option, say

if TYPE_CHECKING:
    from pyport.angles import Array
    from pyport.recordings import Recordings
    from pyport.studies.gmrt.curves import Track


@click.group("study")
def command() -> None:
    """Repeat the analyses of the two documents that the program began with."""


@command.command("gmrt", epilog="Example: pyport study gmrt --out gmrt")
@option(
    "--garble seeds",
    "How often to garble good rows on purpose, to measure the realignment.",
    0,
    type=click.IntRange(min=0),
    show_default=False,
)
@option("--out", "Folder for figures 1 to 4.", type=PATH)
@in_json
def gmrt(seeds: int, out: Path | None, *, as_json: bool) -> None:
    """Repeat the GMRT paper's analysis on its own tables, shipped with pyport.

    How much of them was recovered, both functional forms for each antenna and
    day, what they say of the antennas' places, which antennas repeat from day to
    day, whether the arms are mirror images, and whether offsets jump at transit.
    """
    from pyport.recordings import read
    from pyport.runs.stages import working
    from pyport.studies.gmrt.figures import write_figures

    with working("repeating the paper's analysis"):
        june, sections = _analysis(seeds)
    drawn = []
    if out is not None:
        from pyport.studies.gmrt.curves import tracks

        drawn = write_figures([*tracks(read("gmrt-2003-05-31")), *june], out)
    _say({"sections": sections, "figures": drawn}, as_json=as_json)


def _say(answer: dict[str, Any], *, as_json: bool) -> None:
    """Print an analysis as JSON, or its sections under their titles and its figures' names."""
    sections = [f"{one}\n{'-' * len(one)}\n{text}\n" for one, text in answer["sections"].items()]
    say("\n".join([*sections, *map(str, answer["figures"])]), answer, as_json=as_json)


def _analysis(seeds: int) -> tuple[list[Track], dict[str, str]]:
    from pyport.angles import DEG
    from pyport.recordings import read
    from pyport.studies.gmrt import summary
    from pyport.studies.gmrt.curves import curves, tracks
    from pyport.studies.gmrt.published import LATITUDE_DEG, SESSIONS, apparent_place
    from pyport.studies.gmrt.recovery import recovery
    from pyport.studies.gmrt.repetition import jumps_at_transit, mirrors, repeatability

    june = tracks(read("gmrt-cyg-a"))
    plain, times_cos_el = curves(june), curves(june, times_cos_el=True)
    _, dec = apparent_place(SESSIONS[2])
    return june, {
        "Recovery": recovery.text(seeds),
        "Curves, forward and reverse apart": summary.forms(plain, times_cos_el),
        "Doubts about these curves": summary.warnings([*plain, *times_cos_el]),
        "Places": summary.site(times_cos_el, dec, LATITUDE_DEG * DEG),
        "Repeatability": summary.repeatability(repeatability(june)),
        "Mirror images": summary.mirrors(mirrors(times_cos_el)),
        "Transit": summary.jumps(jumps_at_transit(june)),
    }


@command.command(
    "gmrt-array", epilog="Example: pyport study gmrt-array --antennas antennas.csv --out array"
)
@option(
    "--antennas", "CSV file of surveyed antenna positions to compare with: name,east_m.", type=PATH
)
@option("--out", "Folder for the picture.", type=PATH)
@flag("--json as_json", "Print the numbers as JSON.")
def gmrt_array(antennas: Path | None, out: Path | None, *, as_json: bool) -> None:
    """Analyse the GMRT's days of 2003 as those of one array.

    What the antennas share from day to day and what each has of its own, and
    whether it repeats; how far each antenna stands from where its offsets were
    computed for, beside a survey if there is one; whole antenna-days predicted
    from all others; the Crab predicted from Cyg A. Your own array: `pyport
    diagnose` says the same of any recordings.
    """
    import json

    from pyport.recordings.files import read_survey
    from pyport.report.typed import as_json as finite
    from pyport.studies.gmrt import array as gmrt_array

    survey = None if antennas is None else read_survey(antennas)
    found = gmrt_array.evidence(survey, lambda line: click.echo(line, err=True))
    click.echo(json.dumps(finite(found.as_json())) if as_json else gmrt_array.page(found))
    if out is not None:
        for path in gmrt_array.write(found, out):
            click.echo(str(path), err=as_json)


@command.command("rt32", epilog="Example: pyport study rt32 --out rt32")
@click.argument("recordings", required=False)
@option("--seed", "Seed of the simulated campaign.", 0)
@option(
    "--campaigns",
    "Number of simulated campaigns, from --seed on, to see how well Model3 is recovered.",
    1,
    type=click.IntRange(min=1),
)
@option(
    "--box-step",
    "The box offset before 2004 less that after; known (0.017 deg), fit or degrees.",
    "known",
)
@option("--out", "Folder for figures 3 to 5.", type=PATH)
@in_json
def rt32(
    recordings: str | None,
    seed: int,
    campaigns: int,
    box_step: str,
    out: Path | None,
    *,
    as_json: bool,
) -> None:
    """Repeat the fit of the RT32 Pointing Model, with robust ones beside it.

    The offsets that the document fitted were never published. Without RECORDINGS
    a simulated campaign takes their place: as many rows, the same two seasons,
    Model3, bad measurements.
    """
    from pyport.recordings import read, resolve
    from pyport.runs.stages import track, working
    from pyport.studies.rt32 import METHODS, document, fit_rt32
    from pyport.studies.rt32 import box_step as chosen_step
    from pyport.studies.rt32.fit import honest_sigmas

    if recordings is None:
        measured, error = _simulated(seed, out)
    else:
        measured, error = read(resolve(recordings)), None
    box = chosen_step(measured, box_step)
    with working("fitting") as tell:
        fits, honest = [], []
        for method in METHODS:
            tell(method)
            fits.append(fit_rt32(measured, method=method, box=box))
            honest.append(honest_sigmas(fits[-1]))
    parts = {
        "Parameters": document.text(fits[0], honest[0]),
        "Correlations": document.correlations(fits[0]),
        "Beside the document": document.beside(fits[0]),
    }
    if error is not None:
        made = [(fits[0], honest[0], error)]
        for other in track(range(seed + 1, seed + campaigns), "campaigns", campaigns - 1):
            measured, error = _simulated(other, None)
            fit = fit_rt32(measured, box=chosen_step(measured, box_step))
            made.append((fit, honest_sigmas(fit), error))
        parts["What was put in, and found"] = document.recovered(made)
    parts["Other methods, sigmas by sessions [arcsec]"] = document.compared(fits, honest)
    drawn = []
    if out is not None:
        from pyport.studies.rt32.sky import write_figures

        drawn = write_figures(fits[0], out)
    listed = [document.as_json(one, own) for one, own in zip(fits, honest, strict=True)]
    _say({"fits": listed, "sections": parts, "figures": drawn}, as_json=as_json)


def _simulated(seed: int, out: Path | None) -> tuple[Recordings, Array]:
    """Make a campaign and read it as anyone's file would be; with it what rows are off by [rad]."""
    from tempfile import TemporaryDirectory

    import numpy as np

    from pyport.angles import ARCSEC
    from pyport.examiner.sealed.record.files import write_recordings
    from pyport.examiner.worlds.rt32_campaign import rt32_campaign
    from pyport.recordings import read

    case = rt32_campaign(seed)
    with TemporaryDirectory() as scratch:
        path = (Path(scratch) if out is None else out) / "rt32-simulated.csv"
        write_recordings(case, path)
        return read(path), np.array(case.truth["error_arcsec"]) * ARCSEC
