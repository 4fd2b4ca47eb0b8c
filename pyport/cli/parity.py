"""`pyport parity`: hold the ports to the published Fortran and say how far apart they are."""

from __future__ import annotations

import json

import click


@click.command("parity")
@click.option(
    "--points",
    type=click.IntRange(min=0),
    default=20_000,
    show_default=True,
    help="Random points, beside the table's 51,395 and the pinned edges (with the oracle).",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the random points.")
@click.option("--jobs", type=click.IntRange(min=1), help="Processes; all cores by default.")
@click.option("--report", type=click.Path(dir_okay=False), help="Write the text here as well.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of text.")
def command(points: int, seed: int, jobs: int | None, report: str | None, as_json: bool) -> None:  # noqa: FBT001 - click passes flags by keyword
    """Hold the Python ports to the published Fortran routines, in ulp of REAL*4.

    With the compiled routines installed (pip install ./legacy_fortran) they are asked anew at every
    point; without them the ports are held to their stored answers.
    """
    from pyport.files import write_whole
    from pyport.parity import report as reporting
    from pyport.parity.run import run

    parity = run(points, seed, jobs)
    text = reporting.text(parity)
    if report:
        with write_whole(report) as file:
            file.write(text)
    click.echo(json.dumps(reporting.as_json(parity), indent=2) if as_json else text, nl=False)
