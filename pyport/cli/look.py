"""`pyport look`: what recordings could show, before anything is fitted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import models
from pyport.cli.manners import recordings as named

if TYPE_CHECKING:
    from pyport.recordings.given import Given


@click.command("look", epilog="Example: pyport look offsets.csv --model altaz --next 8")
@click.argument("recordings", shell_complete=named)
@click.option(
    "--model",
    default="altaz",
    show_default=True,
    shell_complete=models,
    help="A built-in model or a file.",
)
@click.option(
    "--noise",
    "noise_arcsec",
    type=click.FloatRange(min=0, min_open=True),
    metavar="ARCSEC",
    help="One-sigma error of an offset, where the scatter would not tell.",
)
@click.option(
    "--next",
    "count",
    type=click.IntRange(0, 100),
    default=6,
    show_default=True,
    help="So many directions to observe next.",
)
@click.option("--sources", is_flag=True, help="Suggest the recorded sources, not directions.")
@click.option(
    "--elevations",
    nargs=2,
    type=click.FloatRange(0, 90),
    metavar="LOW HIGH",
    help="Suggest nothing outside these [deg].",
)
@about_file
@click.option("--out", type=click.Path(path_type=Path), help="Folder for look.json.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    recordings: str,
    model: str,
    noise_arcsec: float | None,
    count: int,
    elevations: tuple[float, float] | None,
    given: Given,
    out: Path | None,
    *,
    sources: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Tell what RECORDINGS could show, before anything is fitted to them.

    Coverage of the sky; which effects they could separate, from the model and
    from each other, and which not; and what to observe next to distinguish those.
    """
    from pyport.files import write_whole
    from pyport.fitting.models import load
    from pyport.planning import look
    from pyport.planning.summary import as_json as for_programs
    from pyport.planning.summary import text
    from pyport.progress import working
    from pyport.recordings import read

    if elevations is not None and not elevations[0] < elevations[1]:
        raise click.UsageError(f"--elevations: {elevations[0]} is not below {elevations[1]}")
    with working("looking"):
        done = look(
            read(recordings, given),
            load(model),
            noise_arcsec=noise_arcsec,
            count=count,
            elevations=elevations,
            sources=sources,
        )
    whole = json.dumps(for_programs(done), indent=1, allow_nan=False)
    if out is not None:
        with write_whole(out / "look.json") as file:
            file.write(whole + "\n")
    if not quiet:
        click.echo(whole if as_json else text(done))
