"""Commands that apply models to recordings and tables, compare them, and convert files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import (
    FILE,
    about_file,
    flag,
    in_json,
    models,
    option,
    refuse_without_columns,
    say,
)
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.correction.apply import Applied
    from pyport.recordings.raw import FileOptions


@click.command(
    "apply",
    epilog="Examples: pyport apply new.toml targets.csv -o commands.csv; "
    "pyport apply new.toml night.csv --residuals",
)
@click.argument("model", shell_complete=models)
@click.argument("targets")
@option(
    "-o --out",
    "File to write: .csv, .ecsv or .parquet.  [default: CSV on standard output]",
    type=FILE,
)
@flag("--inverse", "From the mount's az_deg, el_deg to the sky's.")
@flag("--residuals", "TARGETS are recordings: add their residuals.")
@about_file
@in_json
def apply(
    model: str,
    targets: str,
    given: FileOptions,
    out: Path | None,
    *,
    inverse: bool,
    residuals: bool,
    as_json: bool,
) -> None:
    """Add the offsets of MODEL to TARGETS, and where to drive.

    TARGETS is any file with the columns of recordings, offsets or not; a condition that the
    model follows is a column, or one value for all: --set temperature_c=8.
    """
    from pyport.api import load_model
    from pyport.correction.apply import applied, with_conditions
    from pyport.recordings.files import read_raw, resolve
    from pyport.recordings.formats import registry as tables

    refuse_without_columns(out)
    raw = read_raw(resolve(targets), given)
    asked = load_model(model)
    raw = with_conditions(raw, given.keys, asked)
    done = applied(asked, raw, inverse=inverse, residuals=residuals, where=given.where)
    if out is not None:
        tables.write(done.table, out)
    if as_json:
        columns = {name: done.table.columns[name] for name in done.added}
        counts = {"rows": done.rows, "skipped": done.skipped, "unknown": done.unknown}
        answer = {
            "file": out,
            **counts,
            "low": done.low,
            "rms_arcsec": done.rms,
            "columns": columns,
            "notes": done.notes,
        }
        say("", answer, as_json=True)
        return
    if out is None:
        click.echo(_csv(done), nl=False)
    else:
        click.echo(f"{out}: {done.rows} rows with {', '.join(done.added)}")
    for line in _words(done):
        click.echo(line, err=out is None)


def _csv(done: Applied) -> str:
    import csv
    import io

    out = io.StringIO()
    out.writelines(f"# {key}: {value}\n" for key, value in done.table.meta.items())
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(done.table.columns)
    cells = [_spelled(name, one.tolist(), done) for name, one in done.table.columns.items()]
    writer.writerows(zip(*cells, strict=True))
    return out.getvalue()


def _spelled(name: str, cells: list[object], done: Applied) -> list[object]:
    """Return cells as text, new ones with as many decimals as a mount can use."""
    if name not in done.added:
        return cells
    decimals = 4 if name.endswith("_arcsec") else 7
    return ["" if one != one else f"{one:.{decimals}f}" for one in cells]  # noqa: PLR0124


def _words(done: Applied) -> list[str]:
    found = [*done.notes]
    if done.skipped:
        found.append(f"{done.skipped} rows tell no direction")
    found += [
        f"{count} rows do not tell {name}: what follows it counts as zero there"
        for name, count in done.unknown.items()
    ]
    if done.low:
        lowest = "below 0.5 deg of elevation, where refraction is that of 0.5 deg"
        found.append(f"{done.low} rows lie {lowest}")
    if done.rms:
        parts = ", ".join(f"{done.axes[name]} {value:.2f}" for name, value in done.rms.items())
        found.append(f"rms of what is left [arcsec]: {parts} (sky: both axes, by the row)")
    return found


@click.command(
    "compare", epilog="Example: pyport compare old.mod new.toml --recordings night.dat --beam 30"
)
@click.argument("old", shell_complete=models)
@click.argument("new", shell_complete=models)
@option("--recordings", "Measured offsets, by which both models are judged.")
@option(
    "--beam beam_arcsec",
    "Beam width: report where commanded positions move by more than this.",
    type=click.FloatRange(min=0, min_open=True),
    metavar="ARCSEC",
)
@option("--picture", "Draw the differences over the sky: .png, .svg or .pdf.", type=FILE)
@flag("--in-use", "OLD was correcting the telescope when RECORDINGS were made.")
@flag("--accept", "Accept terms without significance that move the horizon or the zenith.")
@about_file
@in_json
def compare(
    old: str,
    new: str,
    recordings: str | None,
    beam_arcsec: float | None,
    picture: Path | None,
    given: FileOptions,
    *,
    in_use: bool,
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
    from pyport.models.conditions import columns_of, refuse_slips
    from pyport.models.conditions import known as is_condition
    from pyport.mounts import ALTAZ
    from pyport.plots.pictures import FORMATS
    from pyport.recordings import read
    from pyport.recordings.naming import KEYS, site_of

    if in_use and recordings is None:
        raise click.UsageError("--in-use is said of recordings: give them by --recordings")
    if picture is not None and picture.suffix[1:] not in FORMATS:
        raise BadInput(f"expected a suffix of {', '.join(FORMATS)}", picture)
    measured = None if recordings is None else read(recordings, given)
    about_mount = given.keys.get("mount", "")
    if not about_mount and measured is not None and measured.at.mount is not ALTAZ:
        about_mount = measured.at.mount.id
    both = load_model(old, about_mount), load_model(new, about_mount)
    if in_use and measured is not None:
        measured = both[0].model.added_to(measured)
    needs = {*both[0].needs(), *both[1].needs()} - KEYS
    about = {key: one for key, one in given.keys.items() if is_condition(key) or key in needs}
    refuse_slips(set(given.keys) - set(about) - KEYS, needs)
    found = compare(*both, measured, columns_of(about, needs), site_of(given.keys))
    if picture is not None:
        draw(found, picture, f"{new} - {old}", beam_arcsec)
    say("\n".join(text(found, beam_arcsec)), for_programs(found, beam_arcsec), as_json=as_json)
    if found.refused and not accept:
        names = ", ".join(one.value.name for one in found.refused)
        wrong = f"{names}: a term without significance moves the horizon or the zenith"
        raise BadInput(f"{wrong}; see above, --accept takes the model as it is", new)


def _signs(context: click.Context, _: click.Parameter, value: bool) -> None:  # noqa: FBT001 - click's
    if value:
        from pyport.formats.convert import table

        click.echo("\n".join(table()))
        context.exit()


@click.command(
    "convert",
    epilog="Example: pyport convert night.dat night.csv; pyport convert old.mod mdlpo.ctl",
)
@click.argument("source")
@click.argument("target", type=click.Path(path_type=Path, dir_okay=False))
@about_file
@option("--to", "Write this format, whatever the suffix.", metavar="FORMAT", default="")
@option("--model", "For the Field System's err: the mdlpo.ctl to fit.", default="")
@flag("--leave-out", "Leave out terms that the target cannot name.")
@option(
    "--rest-as",
    "CSV file for the corrections, on a grid, by terms that the target cannot name.",
    type=FILE,
)
@flag("--quiet", "Print nothing but errors.")
@option(
    "--signs",
    "Print the terms of every program, with their signs, and exit.",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_signs,
)
@in_json
def convert(
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

    for asked, name in (("--from", given.format), ("--to", to)):
        if name and name not in FORMATS:
            raise click.UsageError(f"{asked}: no format {name!r}, known: {', '.join(FORMATS)}")
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
    if done.masked:
        click.echo(f"{done.masked} of them masked: an angle or an offset is not there")
    if done.waves:
        click.echo(done.waves)
    if done.left_out:
        where = "left out" if rest_as is None else f"in {rest_as}"
        size = f" ({done.lost_size})" if done.lost_size else ""
        click.echo(f"{where}, for {done.format} has no place: {', '.join(done.left_out)}{size}")
    elif rest_as is not None:
        click.echo(f"{rest_as}: not written, for {done.format} has a place for every term")
