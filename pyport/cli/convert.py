"""`pyport convert`: recordings and models from one program's format into another's."""

from __future__ import annotations

from pathlib import Path

import click

from pyport.cli.about import about_file
from pyport.cli.manners import in_json, say


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
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@in_json
def command(
    source: str,
    target: Path,
    about: dict[str, str],
    columns: tuple[str, ...],
    read_as: str,
    to: str,
    model: str,
    *,
    leave_out: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Convert SOURCE to TARGET; the suffixes say which formats.

    Recordings: .csv .ecsv .parquet, TPOINT .dat, Field System .xtr .err,
    katpoint CSV (--to katpoint-csv). Models: .toml, TPOINT .mod, Field System
    .ctl, katpoint .txt, SKA-Mid .json, DISCOS .xml (SOURCE.xml#RECEIVER).
    """
    from pyport.formats.convert import FORMATS, convert
    from pyport.recordings.given import Given

    for option, name in (("--from", read_as), ("--to", to)):
        if name and name not in FORMATS:
            raise click.UsageError(f"{option}: no format {name!r}, known: {', '.join(FORMATS)}")
    given = Given(about, columns, read_as)
    done = convert(source, target, to=to, given=given, model=model, leave_out=leave_out)
    if quiet:
        return
    if as_json:
        say("", {"file": target, **vars(done)}, as_json=True)
        return
    what = "recordings" if done.kind == "recordings" else "terms"
    click.echo(f"{target}: {done.number} {what} as {done.format}")
    if done.left_out:
        click.echo(f"left out, for {done.format} has no place: {', '.join(done.left_out)}")
