"""`pyport plot`: the panels of the page as figures for print."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import beside_model
from pyport.cli.manners import recordings as named

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


@click.command(
    "plot",
    epilog="Example: pyport plot offsets.csv --panel sky --panel against-el --out figures",
)
@click.argument("recordings", shell_complete=named)
@beside_model
@click.option(
    "--of",
    "what",
    type=click.Choice(["diagnosis", "fit"]),
    default="diagnosis",
    show_default=True,
    help="Draw what a diagnosis finds, or a fit alone.",
)
@click.option(
    "--panel",
    "names",
    multiple=True,
    metavar="NAME",
    help="A panel such as sky, azel, against-el, against-time, distributions; repeat for more. "
    "Without it, all of them.",
)
@click.option(
    "--format",
    "kinds",
    type=click.Choice(["pdf", "png", "svg"]),
    multiple=True,
    default=("pdf",),
    show_default=True,
    help="Repeat for more than one.",
)
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@about_file
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder to write to.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print the files' names as JSON.")
def command(
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
    from pyport.progress import track, working
    from pyport.recordings import read

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
