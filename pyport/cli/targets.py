"""`pyport targets`: what to observe next, as a list that a telescope reads."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import beside_model, in_json, say
from pyport.cli.manners import recordings as named
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions


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
def command(
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
