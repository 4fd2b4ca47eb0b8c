"""`pyport compare`: what a new model does to commanded positions, before the mount is given it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import in_json, models, say
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


@click.command(
    "compare",
    epilog="Example: pyport compare old.mod new.toml --recordings night.dat --beam 30",
)
@click.argument("old", shell_complete=models)
@click.argument("new", shell_complete=models)
@click.option("--recordings", help="Measured offsets, by which both models are judged.")
@click.option(
    "--beam",
    "beam_arcsec",
    type=click.FloatRange(min=0, min_open=True),
    metavar="ARCSEC",
    help="Beam width: report where commanded positions move by more than this.",
)
@click.option(
    "--picture",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Draw the differences over the sky: .png, .svg or .pdf.",
)
@click.option(
    "--accept",
    is_flag=True,
    help="Accept terms without significance that move the horizon or the zenith.",
)
@about_file
@in_json
def command(
    old: str,
    new: str,
    recordings: str | None,
    beam_arcsec: float | None,
    picture: Path | None,
    given: FileOptions,
    *,
    accept: bool,
    as_json: bool,
) -> None:
    """Compare the models OLD and NEW over the sky, and on recordings.

    Tells how far commanded positions move and where, which recordings get worse, and what is
    extrapolated. Refuses a new model in which a term without significance moves the horizon
    or the zenith by more than the scatter of the data.
    """
    from pyport.api import load_model
    from pyport.correction.compare import compare
    from pyport.correction.compared import as_json as for_programs
    from pyport.correction.compared import picture as draw
    from pyport.correction.compared import text
    from pyport.models.conditions import columns_of
    from pyport.models.conditions import known as is_condition
    from pyport.recordings import read

    measured = None if recordings is None else read(recordings, given)
    told = columns_of({key: one for key, one in given.keys.items() if is_condition(key)})
    found = compare(load_model(old), load_model(new), measured, told)
    if picture is not None:
        draw(found, picture, f"{new} - {old}", beam_arcsec)
    say("\n".join(text(found, beam_arcsec)), for_programs(found, beam_arcsec), as_json=as_json)
    if found.refused and not accept:
        names = ", ".join(one.value.name for one in found.refused)
        wrong = f"{names}: a term without significance moves the horizon or the zenith"
        raise BadInput(f"{wrong}; see above, --accept takes the model as it is", new)
