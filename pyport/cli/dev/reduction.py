"""`pyport dev reduction`: what astrometry leaves in pointing offsets, and how to take it out."""

from __future__ import annotations

from pathlib import Path

import click

from pyport.cli.manners import in_json, say


@click.group("reduction")
def command() -> None:
    """Take nutation, aberration, UT1, polar motion, refraction out of offsets, each by its name."""


@command.command(epilog="Example: pyport dev reduction sizes")
@in_json
def sizes(*, as_json: bool) -> None:
    """Print how large each step was in the RT32's campaigns, beside the document's figures."""
    from pyport.progress import working
    from pyport.studies.rt32 import reduction_sizes as all_of_them

    told: dict[str, object] = {}
    with working("sizing each step"):
        if as_json:
            told["sizes_arcsec"] = all_of_them.sizes()
            told["orientations"] = all_of_them.orientations()
            told["against_astropy_arcsec"] = all_of_them.against_astropy()
        else:
            text = all_of_them.text()
    say(text if not as_json else "", told, as_json=as_json)


@command.command(epilog="Example: pyport dev reduction apply raw.csv out.csv --steps nutation,ut1")
@click.argument("recordings")
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--steps", help="Names with commas between; the document's six when not given.")
@in_json
def apply(recordings: str, out: Path, steps: str | None, *, as_json: bool) -> None:
    """Write RECORDINGS to OUT with offsets free of what the steering program left out."""
    from pyport.recordings import read, resolve, write
    from pyport.recordings.reduction import DOCUMENT, reduced

    taken = DOCUMENT if steps is None else tuple(filter(None, steps.split(",")))
    done = reduced(read(resolve(recordings)), taken)
    write(done, out)
    told = {"file": out, "recordings": len(done), "taken_out": taken}
    say(f"{len(done)} recordings in {out}, free of {', '.join(taken)}", told, as_json=as_json)
