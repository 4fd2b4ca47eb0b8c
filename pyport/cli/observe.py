"""Commands that say what to observe next, and what recordings can distinguish."""

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
from datetime import UTC, datetime

from pyport.cli.manners import in_json, say
from pyport.errors import BadInput


def _proposed(name: str, given: FileOptions) -> dict[str, str]:
    """Return a map of columns for a table that is none of the contract; empty for one that is."""
    from pyport.columns import angle_of
    from pyport.files import is_file
    from pyport.recordings.formats import mapped
    from pyport.recordings.formats import registry as tables
    from pyport.recordings.mounted import OFFSETS

    path = Path(name)
    known = path.suffix.lower() in tables.BY_SUFFIX and path.suffix.lower() != ".csv"
    if not is_file(path) or given.format or given.columns or known:
        return {}
    if path.suffix.lower() == ".csv" and tables.katpoint_csv.looks_like(path):
        return {}
    table = mapped.sheet(path)
    offsets = {one[0] for one in map(angle_of, table.names) if one is not None}
    if offsets & OFFSETS:
        return {}
    return mapped.propose(table)


def _say_map(name: str, found: dict[str, str], kept: Path | None, *, as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps({"columns": found}, indent=1))
        return
    click.echo(f"{name}: columns by other names; proposed, to be checked (units, signs):")
    for ours, theirs in found.items():
        click.echo(f"  {ours:22s} {theirs}")
    told = ", ".join(f"{ours}={theirs}" for ours, theirs in found.items())
    click.echo(f"pyport look {name} --columns {str(kept) if kept else repr(told)}")


@click.command("look", epilog="Example: pyport look offsets.csv --model altaz --next 8")
@click.argument("recordings", shell_complete=named)
@beside_model
@click.option(
    "--noise",
    "noise_arcsec",
    type=click.FloatRange(min=0, min_open=True),
    metavar="ARCSEC",
    help="One-sigma error of an offset, instead of the estimate from the scatter.",
)
@click.option(
    "--next",
    "count",
    type=click.IntRange(0, 100),
    default=6,
    show_default=True,
    help="Number of directions to suggest.",
)
@click.option("--sources", is_flag=True, help="Suggest the recorded sources, not directions.")
@click.option(
    "--elevations",
    nargs=2,
    type=click.FloatRange(0, 90),
    metavar="LOW HIGH",
    help="Limits of the suggested elevations [deg].",
)
@click.option(
    "--save-columns",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="MAP.toml",
    help="Keep the map of columns, given or proposed, for --columns of any command.",
)
@about_file
@click.option("--out", type=click.Path(path_type=Path), help="Folder for look.json.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def look(
    recordings: str,
    model: str,
    noise_arcsec: float | None,
    count: int,
    elevations: tuple[float, float] | None,
    save_columns: Path | None,
    given: FileOptions,
    out: Path | None,
    *,
    sources: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Show what RECORDINGS can distinguish, before anything is fitted to them.

    Coverage of the sky; which effects they could separate, from the model and
    from each other, and which not; and what to observe next to distinguish those.
    """
    from pyport.files import write_whole
    from pyport.formats.models import load
    from pyport.planning import look
    from pyport.planning.summary import as_json as for_programs
    from pyport.planning.summary import text
    from pyport.progress import working
    from pyport.recordings import read
    from pyport.recordings.formats import mapped

    if save_columns is not None and given.mapping:
        mapped.save(given.mapping, save_columns)
    if not given.mapping and (proposed := _proposed(recordings, given)):
        if save_columns is not None:
            mapped.save(proposed, save_columns)
        if not quiet:
            _say_map(recordings, proposed, save_columns, as_json=as_json)
        return
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


#: The beginning of 2000 [s since 1970], and a year [s].
_J2000_S, _YEAR_S = 946_728_000.0, 365.25 * 86400


@click.command(
    "targets",
    epilog="Example: pyport targets offsets.csv --catalogue radio --format snap -o next.snp",
)
@click.argument("recordings", shell_complete=named)
@beside_model
@click.option("--count", type=click.IntRange(1, 500), default=20, show_default=True)
@click.option("--start", metavar="TIME", help="ISO 8601 UTC; now by default.")
@click.option(
    "--hours", type=click.FloatRange(min=0, min_open=True), help="Time left; until sunrise if not."
)
@click.option(
    "--catalogue",
    metavar="NAME",
    help="Sources: radio, stars, or a CSV file name,ra_deg,dec_deg; without, directions.",
)
@click.option(
    "--elevations",
    nargs=2,
    type=click.FloatRange(0, 90),
    default=(15.0, 80.0),
    show_default=True,
    metavar="LOW HIGH",
    help="Nothing outside these [deg].",
)
@click.option(
    "--slew",
    nargs=2,
    type=click.FloatRange(min=0, min_open=True),
    default=(0.5, 0.5),
    show_default=True,
    metavar="AZ EL",
    help="Rates [deg/s].",
)
@click.option(
    "--dwell",
    "dwell_s",
    type=click.FloatRange(min=0),
    default=180.0,
    show_default=True,
    metavar="SECONDS",
    help="What a pointing takes.",
)
@click.option(
    "--sun", "sun_deg", default=0.0, show_default=True, metavar="DEG", help="No nearer to the Sun."
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["csv", "snap", "tpoint", "radec"]),
    default="csv",
    show_default=True,
    help="CSV; Field System; TPOINT's grid; names and places.",
)
@click.option("-o", "--out", type=click.Path(path_type=Path, dir_okay=False), help="File to write.")
@about_file
@in_json
def targets(
    recordings: str,
    model: str,
    count: int,
    start: str | None,
    hours: float | None,
    catalogue: str | None,
    elevations: tuple[float, float],
    slew: tuple[float, float],
    dwell_s: float,
    sun_deg: float,
    form: str,
    out: Path | None,
    given: FileOptions,
    *,
    as_json: bool,
) -> None:
    """List what to observe next: what decides most between effects that look alike in RECORDINGS.

    Within limits and the time left, in an order that saves slewing. `pyport look` says why.
    """
    from pyport.files import write_whole
    from pyport.formats.models import load
    from pyport.planning.target_lists import EPOCH, FORMATS, read_catalogue
    from pyport.planning.targets import Limits, sunrise, targets
    from pyport.recordings import read

    if not elevations[0] < elevations[1]:
        raise click.UsageError(f"--elevations: {elevations[0]} is not below {elevations[1]}")
    rows = read(recordings, given)
    start_s = _seconds(start)
    if hours is not None:
        ends = start_s + 3600 * hours
    elif rows.at.site is not None:
        ends = sunrise(rows.at.site, start_s)
    else:
        raise BadInput("no latitude_deg, expected one: --set latitude_deg=...", rows.file)
    limits = Limits(*elevations, start_s, ends, dwell_s, *slew, sun_deg)
    year = EPOCH + (start_s - _J2000_S) / _YEAR_S
    sources = [] if catalogue is None else read_catalogue(catalogue, year)
    found = targets(rows, load(model), limits, count, sources)
    text = FORMATS[form](found)
    if out is not None:
        with write_whole(out) as file:
            file.write(text)
        text = f"{out}: {len(found)} targets"
    say(text.rstrip("\n"), found, as_json=as_json)


def _seconds(start: str | None) -> float:
    """Return a time as seconds since 1970."""
    if start is None:
        return datetime.now(UTC).timestamp()
    try:
        moment = datetime.fromisoformat(start)
    except ValueError:
        wrong = f"--start: {start!r}, expected ISO 8601 such as 2026-03-01T18:00:00Z"
        raise BadInput(wrong) from None
    if not 1900 <= moment.year < 2100:
        raise BadInput(f"--start: {start!r}, expected a date between 1900 and 2100")
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
