"""`pyport convert`: recordings and models from one program's format into another's."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import in_json, say

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


def _signs(context: click.Context, _: click.Parameter, value: bool) -> None:  # noqa: FBT001 - click's
    """Print the table of signs and leave."""
    if value:
        from pyport.formats.conventions import table

        click.echo("\n".join(table()))
        context.exit()


@click.command(
    "convert",
    epilog="Example: pyport convert night.dat night.csv; pyport convert old.mod mdlpo.ctl",
)
@click.argument("source")
@click.argument("target", type=click.Path(path_type=Path, dir_okay=False))
@about_file
@click.option("--to", default="", metavar="FORMAT", help="Write this format, whatever the suffix.")
@click.option("--model", default="", help="For the Field System's err: the mdlpo.ctl to fit.")
@click.option("--leave-out", is_flag=True, help="Leave out terms that the target cannot name.")
@click.option(
    "--rest-as",
    type=click.Path(path_type=Path, dir_okay=False),
    help="CSV file for the corrections, on a grid, by terms that the target cannot name.",
)
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@click.option(
    "--signs",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_signs,
    help="Print the terms of every program, with their signs, and exit.",
)
@in_json
def command(
    source: str,
    target: Path,
    given: FileOptions,
    to: str,
    model: str,
    rest_as: Path | None,
    *,
    leave_out: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Convert SOURCE to TARGET; the suffixes say which formats.

    Recordings: .csv .ecsv .parquet, TPOINT .dat, Field System .xtr .err,
    katpoint CSV (--to katpoint-csv). Models: .toml, TPOINT .mod, Field System
    .ctl, katpoint .txt, SKA-Mid .json, DISCOS .xml (SOURCE.xml#RECEIVER).

    Names for --from and --to: csv, ecsv, parquet, tpoint-dat, fs-xtr, fs-err,
    katpoint-csv, tpoint-mod, fs-ctl, fs-err-model, katpoint, ska-mid, discos,
    toml.
    """
    from pyport.formats.convert import FORMATS, convert

    for option, name in (("--from", given.format), ("--to", to)):
        if name and name not in FORMATS:
            raise click.UsageError(f"{option}: no format {name!r}, known: {', '.join(FORMATS)}")
    done = convert(
        source, target, to=to, given=given, model=model, leave_out=leave_out, rest_as=rest_as
    )
    if quiet:
        return
    if as_json:
        say("", {"file": target, **vars(done)}, as_json=True)
        return
    what = "recordings" if done.kind == "recordings" else "terms"
    click.echo(f"{target}: {done.number} {what} as {done.format}")
    if done.waves:
        click.echo(done.waves)
    if done.left_out:
        where = "left out" if rest_as is None else f"in {rest_as}"
        size = (
            "" if done.lost_arcsec is None else f" ({done.lost_arcsec:.3g} arcsec rms of the sky)"
        )
        click.echo(f"{where}, for {done.format} has no place: {', '.join(done.left_out)}{size}")
