"""Commands that say what to observe next, and what recordings can distinguish."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import (
    FILE,
    PATH,
    about_file,
    beside_model,
    flag,
    in_json,
    option,
    say,
    warn,
)
from pyport.cli.manners import recordings as named
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


def _proposed(name: str, given: FileOptions) -> tuple[dict[str, str], list[str]]:
    """Return a map of columns for a table that is none of the contract, and what is doubtful of it.

    Empty for one that is.
    """
    from pyport.columns import angle_of
    from pyport.files import is_file
    from pyport.recordings.formats import mapped
    from pyport.recordings.formats import registry as tables
    from pyport.recordings.formats.sheet import sheet
    from pyport.recordings.mounted import OFFSETS

    path = Path(name)
    known = path.suffix.lower() in tables.BY_SUFFIX and path.suffix.lower() != ".csv"
    if not is_file(path) or given.format or given.columns or known:
        return {}, []
    if path.suffix.lower() == ".csv" and tables.katpoint_csv.looks_like(path):
        return {}, []
    table = sheet(path)
    offsets = {one[0] for one in map(angle_of, table.names) if one is not None}
    if offsets & OFFSETS:
        return {}, []
    doubts: list[str] = []
    found = mapped.propose(table, doubts)
    return found, doubts + _trial(name, given, found)


def _trial(name: str, given: FileOptions, found: dict[str, str]) -> list[str]:
    """Return what is doubtful of a file that is read by a map: it is refused, or has notes."""
    from dataclasses import replace

    from pyport.recordings import read

    if not found or _lacking(found):
        return []
    try:
        return list(read(name, replace(given, mapping=found)).notes)
    except BadInput as error:
        return [f"refused as it stands: {error}"]


def _lacking(found: Iterable[str]) -> str:
    """Return in words which columns a map must have and has not; empty where it has them."""
    from pyport.columns import angle_of
    from pyport.recordings.mounted import OFFSETS

    angles = {one[0] for one in map(angle_of, found) if one is not None}
    directions = [one for one in angles - OFFSETS if not one.startswith("sigma_")]
    wanted = {"a direction (az_deg and el_deg)": len(directions) > 1}
    wanted["an offset (d_xel or d_az, d_el)"] = bool(angles & OFFSETS)
    return " and ".join(name for name, there in wanted.items() if not there)


def _say_map(
    name: str, found: dict[str, str], doubts: list[str], kept: Path | None, *, as_json: bool
) -> None:
    if as_json:
        click.echo(json.dumps({"columns": found, "doubts": doubts}, indent=1))
        return
    click.echo(f"{name}: columns by other names; proposed, to be checked (units, signs):")
    for ours, theirs in found.items():
        click.echo(f"  {ours:22s} {theirs}")
    for one in doubts:
        click.echo(f"to be settled: {one}")
    pairs = ", ".join(f"{ours}={theirs}" for ours, theirs in found.items())
    lacking = _lacking(found)
    command = shlex.join(["pyport", "look", name, "--columns", str(kept) if kept else pairs])
    click.echo(f"not found: {lacking}; add it to {command}" if lacking else command)


@click.command("look", epilog="Example: pyport look offsets.csv --model altaz --next 8")
@click.argument("recordings", shell_complete=named)
@beside_model
@option(
    "--noise noise_arcsec",
    "One-sigma error of an offset, instead of the estimate from the scatter.",
    type=click.FloatRange(min=0, min_open=True),
    metavar="ARCSEC",
)
@option("--next count", "Number of directions to suggest.", 6, type=click.IntRange(0, 100))
@flag("--sources", "Suggest the recorded sources, not directions.")
@option(
    "--elevations",
    "Limits of the suggested elevations [deg].",
    type=click.FloatRange(0, 90),
    nargs=2,
    metavar="LOW HIGH",
)
@option(
    "--save-columns",
    "Keep the map of columns, given or proposed, for --columns of any command.",
    type=FILE,
    metavar="MAP.toml",
)
@about_file
@option("--out", "Folder for look.json.", type=PATH)
@flag("--quiet", "Print nothing but errors.")
@flag("--json as_json", "Print JSON.")
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
    from pyport.files import write_file
    from pyport.formats.models import load
    from pyport.planning import look
    from pyport.planning.summary import as_json as for_programs
    from pyport.planning.summary import text
    from pyport.recordings import read
    from pyport.recordings.formats import mapped
    from pyport.runs.stages import working

    proposed, doubts = ({}, []) if given.mapping else _proposed(recordings, given)
    columns = given.mapping or proposed
    if save_columns is not None and columns:
        mapped.save(columns, save_columns)
    elif save_columns is not None and not quiet:
        said = "not written: the columns are read under the names that they have"
        click.echo(f"{save_columns}: {said}", err=True)
    if proposed:
        if not quiet:
            _say_map(recordings, proposed, doubts, save_columns, as_json=as_json)
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
        write_file(out / "look.json", whole + "\n")
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
@option("--start", "ISO 8601 UTC; now by default.", metavar="TIME")
@option("--hours", "Time left; until sunrise if not.", type=click.FloatRange(min=0, min_open=True))
@option(
    "--catalogue",
    "Sources: radio, stars, or a CSV file name,ra_deg,dec_deg; without, directions.",
    metavar="NAME",
)
@option(
    "--elevations",
    "Nothing outside these [deg].",
    (15.0, 80.0),
    type=click.FloatRange(0, 90),
    nargs=2,
    metavar="LOW HIGH",
)
@option(
    "--slew",
    "Rates [deg/s].",
    (0.5, 0.5),
    type=click.FloatRange(min=0, min_open=True),
    nargs=2,
    metavar="AZ EL",
)
@option(
    "--dwell dwell_s",
    "What a pointing takes.",
    180.0,
    type=click.FloatRange(min=0),
    metavar="SECONDS",
)
@option("--sun sun_deg", "No nearer to the Sun.", 0.0, metavar="DEG")
@option(
    "--format form",
    "CSV; Field System; TPOINT's grid; names and places.",
    "csv",
    of="csv snap tpoint radec",
)
@option("-o --out", "File to write.", type=FILE)
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
    from pyport.files import write_file
    from pyport.formats.models import load
    from pyport.planning.target_lists import EPOCH, FORMATS, read_catalogue
    from pyport.planning.targets import Limits, sunrise, targets
    from pyport.recordings import read
    from pyport.recordings.schema import as_input, counted

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
    if len(found) < count:
        warn(f"{len(found)} of {count} targets: no more are within the limits in the time left")
    text = FORMATS[form](found)
    heading = f"{counted(as_input(rows))}, model {model}"
    click.echo(heading, err=out is None or as_json)
    if out is not None:
        write_file(out, text)
        text = f"{out}: {len(found)} targets"
    say(text.rstrip("\n"), found, as_json=as_json)


def _seconds(start: str | None) -> float:
    """Return a time as seconds since 1970."""
    from pyport.recordings.raw import seconds_of

    if start is None:
        return datetime.now(UTC).timestamp()
    try:
        moment = seconds_of(start)
    except ValueError:
        wrong = f"--start: {start!r}, expected ISO 8601 such as 2026-03-01T18:00:00Z"
        raise BadInput(wrong) from None
    if not seconds_of("1900-01-01") <= moment < seconds_of("2100-01-01"):
        raise BadInput(f"--start: {start!r}, expected a date between 1900 and 2100")
    return moment
