"""`pyport offsets`: pointing offsets out of scans across a source."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import in_json, say

if TYPE_CHECKING:
    from pyport.recordings.scans import Average


@click.command("offsets", epilog="Example: pyport offsets scans.csv -o offsets.csv")
@click.argument("scans", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="File for the recordings: .csv, .ecsv or .parquet.",
)
@in_json
def command(scans: Path, out: Path | None, *, as_json: bool) -> None:
    """Fit the beam in each of SCANS, print the averages to load, write the recordings."""
    from pyport.recordings import resolve, write
    from pyport.recordings.scans import averages, measure, text

    recordings = measure(resolve(scans))
    found = averages(recordings)
    if out is not None:
        write(recordings, out)
    if as_json:
        told = {"averages": [_told(one) for one in found], "set_aside": recordings.set_aside}
        say("", told, as_json=True)
        return
    click.echo(text(found))
    for aside in recordings.set_aside:
        click.echo(f"{scans}:{aside.line}: excluded: {aside.reason}")
    if out is not None:
        click.echo(f"{len(recordings)} recordings in {out}, {len(recordings.set_aside)} excluded")


def _told(one: Average) -> dict[str, object]:
    """Return an average for other programs, in arcminutes."""
    from pyport.angles import ARCMIN

    return {
        "antenna": one.antenna,
        "axis": one.axis,
        "round": one.round,
        "offset_arcmin": one.offset / ARCMIN,
        "sigma_arcmin": one.sigma / ARCMIN,
        "half_difference_arcmin": one.half_difference / ARCMIN,
        "scans": one.scans,
        "near_zero": one.near_zero,
    }
