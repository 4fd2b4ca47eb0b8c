"""`pyport predict`: how well models point where they were not fitted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import models
from pyport.cli.manners import recordings as named

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


@click.command(
    "predict",
    epilog="Example: pyport predict offsets.csv --against published.mod --on another-night.csv",
)
@click.argument("recordings", shell_complete=named)
@click.option(
    "--model",
    default="altaz",
    show_default=True,
    shell_complete=models,
    help="The model that waves over the sky are added to: built-in, or a file.",
)
@click.option(
    "--against", multiple=True, shell_complete=models, help="A model to judge; repeat for more."
)
@click.option(
    "--on",
    "nights",
    multiple=True,
    shell_complete=named,
    help="Recordings of another night to predict; repeat for more.",
)
@click.option(
    "--rehearse",
    is_flag=True,
    help="Rehearse on simulated nights of telescopes that follow each of the models exactly.",
)
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@about_file
@click.option(
    "--grid",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write the model with waves over the sky, with its errors, as CSV.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for prediction.json.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
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
    from pyport.files import write_whole
    from pyport.formats.models import load
    from pyport.prediction import rehearsal, words
    from pyport.prediction.compare import compare
    from pyport.progress import working
    from pyport.recordings import read

    if rehearse and not against:
        raise click.UsageError("--rehearse: name a model to rehearse with, --against MODEL")
    measured, first = read(recordings, given), load(model)
    rivals = [load(one) for one in against]
    with working("comparing") as tell:
        done = compare(
            measured,
            first,
            rivals,
            [read(one, given) for one in nights],
            seed=seed,
            tell=tell,
        )
        rehearsals: list[rehearsal.Rehearsal] = []
        for one in rivals if rehearse else ():
            tell(f"rehearsing with {one.name}")
            rehearsals += rehearsal.rehearse(measured, first, one, seed=seed)
        if grid is not None:
            from pyport.prediction.grid import write_grid

            write_grid(measured, first, grid)
    whole = json.dumps(words.as_json(done, rehearsals), indent=1, allow_nan=False)
    if out is not None:
        with write_whole(out / "prediction.json") as file:
            file.write(whole + "\n")
    text = words.text(done) + ("\n" + words.of_rehearsals(rehearsals) if rehearsals else "")
    click.echo(whole if as_json else text)
