"""`pyport offsets`: pointing offsets out of scans across a source."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("offsets", epilog="Example: pyport offsets scans.csv -o offsets.csv")
@click.argument("scans", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="File for the recordings: .csv, .ecsv or .parquet.",
)
def command(scans: Path, out: Path | None) -> None:
    """Fit the beam in each of SCANS, print the averages to load, write the recordings."""
    from pyport.recordings import resolve, write
    from pyport.recordings.scans.averages import averages, text
    from pyport.recordings.scans.measure import measure

    recordings = measure(resolve(scans))
    click.echo(text(averages(recordings)))
    for aside in recordings.set_aside:
        click.echo(f"{scans}:{aside.line}: set aside: {aside.reason}")
    if out is not None:
        write(recordings, out)
        click.echo(f"{len(recordings)} recordings in {out}, {len(recordings.set_aside)} set aside")
