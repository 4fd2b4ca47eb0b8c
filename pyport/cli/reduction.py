"""`pyport reduction`: what astrometry leaves in pointing offsets, and how to take it out."""

from __future__ import annotations

from pathlib import Path

import click


@click.group("reduction")
def command() -> None:
    """Take nutation, aberration, UT1, polar motion, refraction out of offsets, each by its name."""


@command.command()
def sizes() -> None:
    """Print how large each step was in the RT32's campaigns, beside the document's figures."""
    from pyport.recordings.reduction_sizes import text

    click.echo(text())


@command.command(epilog="Example: pyport reduction apply raw.csv reduced.csv --steps nutation,ut1")
@click.argument("recordings")
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--steps", help="Names with commas between; the document's six when not given.")
def apply(recordings: str, out: Path, steps: str | None) -> None:
    """Write RECORDINGS to OUT with offsets free of what the steering program left out."""
    from pyport.recordings import read, resolve, write
    from pyport.recordings.reduction import DOCUMENT, reduced

    taken = DOCUMENT if steps is None else tuple(filter(None, steps.split(",")))
    done = reduced(read(resolve(recordings)), taken)
    write(done, out)
    click.echo(f"{len(done)} recordings in {out}, free of {', '.join(taken)}")
