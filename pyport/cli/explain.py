"""Commands that find what a model leaves out, draw it, and say who predicts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import FILE, PATH, about_file, beside_model, flag, models, option, say
from pyport.cli.manners import recordings as named

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


@click.command(
    "diagnose", epilog="Example: pyport diagnose offsets.csv --model altaz --out diagnosis"
)
@click.argument("recordings", nargs=-1, required=True, shell_complete=named)
@beside_model
@option(
    "--refit",
    "Which of the model's effects are refitted together with those under test.",
    "all",
    metavar="all|none|NAME,NAME",
)
@flag("--in-use", "The offsets are what the model left while it was in use: it is added back.")
@option("--seed", "Seed of everything random.", 0)
@option("--jobs", "Processes that share the work.", 1)
@option("--cluster", "A Dask scheduler whose workers share the work.", metavar="ADDRESS")
@option(
    "--each",
    "Diagnose each value of a label by itself, from folders LABEL=VALUE: antenna, ...",
    metavar="LABEL",
)
@option("--out", "Folder to write the reports to.", type=PATH)
@option(
    "--save",
    "Write the model completed by all findings: .toml, or another format that can hold it.",
    type=FILE,
)
@option(
    "--antennas", "CSV file of surveyed antenna positions to compare with: name,east_m.", type=PATH
)
@about_file
@flag("--quiet", "Print nothing but errors.")
@flag("--timings", "Print how long each stage took.")
@flag("--json as_json", "Print the reports as JSON lines.")
def diagnose(
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
    in_use: bool,
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
    from pyport.recordings.files import read_survey

    kept = out is not None or save is not None
    if quiet and not kept:
        raise click.UsageError("nothing to print or write: give --out, --save, or no --quiet")
    if save is not None and len(recordings) + (each is not None) > 1:
        raise click.UsageError("--save keeps one model: give one file of recordings")
    survey = None if antennas is None else read_survey(antennas)
    names = recordings if each is None else pipeline.apart(recordings, each)
    requests = pipeline.requests(
        names,
        model=model,
        refit=refit,
        seed=seed,
        out=out,
        given=given,
        survey=survey,
        save=save,
        in_use=in_use,
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
    if not kept and not as_json:
        click.echo("Nothing was written: --out FOLDER keeps the page, its numbers and pictures.")


@click.command(
    "predict",
    epilog="Example: pyport predict offsets.csv --against published.mod --on another-night.csv",
)
@click.argument("recordings", shell_complete=named)
@option(
    "--model",
    "The model that waves over the sky are added to: built-in, or a file.",
    "altaz",
    shell_complete=models,
)
@option("--against", "A model to judge; repeat for more.", multiple=True, shell_complete=models)
@option(
    "--on nights",
    "Recordings of another night to predict; repeat for more.",
    multiple=True,
    shell_complete=named,
)
@flag(
    "--rehearse",
    "Rehearse on simulated nights of telescopes that follow each of the models exactly.",
)
@option("--seed", "Seed of everything random.", 0)
@about_file
@option(
    "--grid",
    "Write the model with waves over the sky, with its errors, as CSV.",
    type=PATH,
    metavar="FILE",
)
@option("--out", "Folder for prediction.json.", type=PATH)
@flag("--json as_json", "Print JSON.")
def predict(
    recordings: str,
    model: str,
    against: tuple[str, ...],
    nights: tuple[str, ...],
    seed: int,
    given: FileOptions,
    grid: Path | None,
    out: Path | None,
    *,
    rehearse: bool,
    as_json: bool,
) -> None:
    """Compare models by how they predict RECORDINGS that they were not fitted to.

    Pointings here and there, bands of elevation and sectors of azimuth are left
    out in turn. The model with waves is the model and smooth waves over the sky, all of
    them, shrunk as far as the readings that it may see say: for pointing, not for
    naming. A model of more terms also meets as many terms that are
    picked automatically, held and picked anew: what that costs is what picking costs.
    """
    from pyport.formats.models import load
    from pyport.prediction import compare, rehearsal, words
    from pyport.recordings import read
    from pyport.runs.stages import working

    if rehearse and not against:
        raise click.UsageError("--rehearse: name a model to rehearse with, --against MODEL")
    measured, names = read(recordings, given), [model, *against]
    loaded = [load(one).on(measured.at.mount) for one in names]
    first, *rivals = compare.distinct(loaded, names)
    with working("comparing") as tell:
        done = compare.compare(
            measured, first, rivals, [read(one, given) for one in nights], seed=seed, tell=tell
        )
        rehearsals: list[rehearsal.Rehearsal] = []
        for one in rivals if rehearse else ():
            tell(f"rehearsing with {one.name}")
            rehearsals += rehearsal.rehearse(measured, first, one, seed=seed)
        if grid is not None:
            from pyport.prediction.grid import write_grid

            write_grid(measured, first, grid)
    text = words.text(done) + ("\n" + words.of_rehearsals(rehearsals) if rehearsals else "")
    say(
        text, words.as_json(done, rehearsals), as_json=as_json, file=out and out / "prediction.json"
    )


@click.command(
    "plot", epilog="Example: pyport plot offsets.csv --panel sky --panel against-el --out figures"
)
@click.argument("recordings", shell_complete=named)
@beside_model
@option(
    "--of what", "Draw what a diagnosis finds, or a fit alone.", "diagnosis", of="diagnosis fit"
)
@option(
    "--panel names",
    "A panel such as sky, azel, against-el, against-time, distributions; repeat for more. "
    "Without it, all of them.",
    multiple=True,
    metavar="NAME",
)
@option("--format kinds", "Repeat for more than one.", ("pdf",), of="pdf png svg", multiple=True)
@option("--seed", "Seed of everything random.", 0)
@about_file
@option("--out", "Folder to write to.", type=PATH, required=True)
@flag("--quiet", "Print nothing but errors.")
@flag("--json as_json", "Print the files' names as JSON.")
def plot(
    recordings: str,
    model: str,
    what: str,
    names: tuple[str, ...],
    kinds: tuple[str, ...],
    seed: int,
    given: FileOptions,
    out: Path,
    *,
    quiet: bool,
    as_json: bool,
) -> None:
    """Draw the panels of a diagnosis or fit of RECORDINGS, each as a file for print.

    Axes bear their units; colours can be distinguished by every eye, also in grey.
    """
    from pyport import page, plots
    from pyport.formats.models import load
    from pyport.recordings import read
    from pyport.runs.stages import track, working

    measured, wanted = read(recordings, given), load(model)
    if what == "fit":
        from pyport.fitting.fit import fit

        picture, story = page.of_fit(fit(measured, wanted))
    else:
        from pyport.diagnosis.diagnose import diagnose

        with working("diagnosing") as tell:
            found_out = diagnose(measured, wanted, seed=seed, tell=tell)
        picture, story = page.of_diagnosis(found_out)
    found = plots.panels(picture, story)
    for name in names:
        if name not in found:
            raise click.UsageError(f"--panel: no panel {name!r}, there are {', '.join(found)}")
    paths = []
    for name in track(names or list(found), "drawing"):
        figure = found[name]()
        paths += [plots.write(figure, out / f"{name}.{kind}") for kind in dict.fromkeys(kinds)]
    if as_json:
        click.echo(json.dumps([str(path) for path in paths]))
    elif not quiet:
        click.echo("\n".join(map(str, paths)))
