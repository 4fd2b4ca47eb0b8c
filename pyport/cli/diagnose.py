"""`pyport diagnose`: what a model leaves out of recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import beside_model
from pyport.cli.manners import recordings as named

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


@click.command(
    "diagnose",
    epilog="Example: pyport diagnose offsets.csv --model altaz --out diagnosis",
)
@click.argument("recordings", nargs=-1, required=True, shell_complete=named)
@beside_model
@click.option(
    "--refit",
    default="all",
    show_default=True,
    metavar="all|none|NAME,NAME",
    help="Which of the model's effects are refitted together with those under test.",
)
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@click.option("--jobs", default=1, show_default=True, help="Processes that share the work.")
@click.option("--cluster", metavar="ADDRESS", help="A Dask scheduler whose workers share the work.")
@click.option(
    "--each",
    metavar="LABEL",
    help="Diagnose each value of a label by itself, from folders LABEL=VALUE: antenna, ...",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder to write the reports to.")
@click.option(
    "--save",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write the model completed by all findings: .toml, or another format that can hold it.",
)
@click.option(
    "--antennas",
    type=click.Path(path_type=Path),
    help="CSV file of surveyed antenna positions to compare with: name,east_m.",
)
@about_file
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--timings", is_flag=True, help="Print how long each stage took.")
@click.option("--json", "as_json", is_flag=True, help="Print the reports as JSON lines.")
def command(
    recordings: tuple[str, ...],
    model: str,
    refit: str,
    seed: int,
    jobs: int,
    cluster: str | None,
    each: str | None,
    out: Path | None,
    given: FileOptions,
    save: Path | None,
    antennas: Path | None,
    *,
    quiet: bool,
    timings: bool,
    as_json: bool,
) -> None:
    """Find, name and model what a pointing model leaves out of RECORDINGS.

    Each file of recordings gets a folder OUT/STEM with report.html, a page that
    needs no network, report.json, rows.csv and a picture per finding. Recordings
    of several antennas also tell what the antennas share, what repeats, and how
    far each stands from where its offsets were computed for. A folder of Parquet
    files is a data set of any size: it is gone through in pieces, all of its rows
    go into normal points.
    """
    from pyport import pipeline
    from pyport.recordings.antennas import read_survey

    if out is None and save is None:
        raise click.UsageError("nothing to write: give --out FOLDER, --save MODEL.toml or both")
    if save is not None and len(recordings) + (each is not None) > 1:
        raise click.UsageError("--save keeps one model: give one file of recordings")
    survey = None if antennas is None else read_survey(antennas)
    names = recordings if each is None else pipeline.apart(recordings, each)
    requests = pipeline.requests(
        names, model=model, refit=refit, seed=seed, out=out, given=given, survey=survey, save=save
    )
    for done in pipeline.run_all(requests, jobs=jobs, cluster=cluster):
        if as_json:
            click.echo(done.report)
        elif not quiet:
            click.echo(done.summary + "\n")
        if timings:
            taken = sorted(done.seconds.items(), key=lambda one: -one[1])
            parts = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in taken)
            click.echo(f"{sum(done.seconds.values()):.2f} s: {parts}\n", err=as_json)
