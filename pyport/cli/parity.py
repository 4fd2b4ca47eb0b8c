"""`pyport parity`: hold the ports to the published Fortran and say how far apart they are."""

from __future__ import annotations

import json

import click


@click.command("parity", epilog="Example: pyport parity --points 100000 --report PARITY.md")
@click.option(
    "--points",
    type=click.IntRange(min=0),
    default=20_000,
    show_default=True,
    help="Random points, beside the table's 51,395 and the pinned edges (with the oracle).",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the random points.")
@click.option("--jobs", type=click.IntRange(min=1), help="Processes; all cores by default.")
@click.option("--stored", is_flag=True, help="Ask the stored answers even where the oracle is.")
@click.option("--report", type=click.Path(dir_okay=False), help="Write a page of Markdown here.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of text.")
def command(
    points: int,
    seed: int,
    jobs: int | None,
    stored: bool,  # noqa: FBT001 - click passes flags by keyword
    report: str | None,
    as_json: bool,  # noqa: FBT001
) -> None:
    """Hold the Python ports to the published Fortran routines, in ulp of REAL*4.

    With the compiled routines installed (pip install ./legacy_fortran) they are asked anew at every
    point; without them the ports are held to their stored answers. Killed and called again in the
    same words it goes on.
    """
    from pyport.files import write_whole
    from pyport.parity import report as reporting
    from pyport.parity.document import document
    from pyport.parity.progress import kept_beside
    from pyport.parity.run import run

    kept = kept_beside(report, points, seed)
    parity = run(points, seed, jobs, live=not stored, kept=kept)
    if report:
        with write_whole(report) as file:
            file.write(document(parity))
    if as_json:
        click.echo(json.dumps(reporting.as_json(parity), indent=1))
    else:
        click.echo(reporting.text(parity), nl=False)
    kept.unlink(missing_ok=True)
