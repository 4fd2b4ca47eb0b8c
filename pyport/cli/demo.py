"""`pyport demo`: parity, the steering table and a diagnosis of real recordings, once."""

from __future__ import annotations

from pathlib import Path

import click

#: The paper left physics out of these; each is diagnosed against the paper's own model.
RECORDINGS = (
    "gmrt-2003-05-31",
    "gmrt-2003-06-01",
    "gmrt-2003-06-02",
    "gmrt-2003-06-05",
    "gmrt-cyg-a",
)


@click.command("demo", epilog="Example: pyport demo --out out")
@click.option(
    "--out",
    default="out",
    show_default=True,
    type=click.Path(path_type=Path),
    help="Folder for the table, the reports and the pictures.",
)
def command(out: Path) -> None:
    """Show everything once: parity, the steering table, a diagnosis of real recordings."""
    from pyport import parity, steering
    from pyport.diagnosis import run

    click.secho("1. Is the port the published program?\n", bold=True)
    click.echo(parity.summary())

    click.secho("\n2. The steering table, made anew\n", bold=True)
    table = out / "3model.txt"
    steering.write_ascii(steering.tabulate("rt32-3model", steering.DEFAULT_REFRACTION), table)
    click.echo(f"{table}: {len(steering.RT32_GRID)} rows")
    for result in steering.check():
        click.echo(f"  {result.block.name:<38}{result.agree:4d} of {result.total} printed cells")

    click.secho("\n3. What did the paper's model leave out of the GMRT's recordings?", bold=True)
    wanted = run.requests(RECORDINGS, model="gmrt-paper", refit="all", seed=0, out=out)
    for done in run.run_all(wanted):
        click.echo("\n" + done.summary)
    click.echo(f"\nReports, rows and pictures: {out}/gmrt-*/ (open report.html in a browser)")
