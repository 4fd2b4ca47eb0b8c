"""`pyport lookup`: offsets at an azimuth and zenith distance, from a steering table."""

from __future__ import annotations

import json
from typing import IO, TYPE_CHECKING

import click

from pyport.cli.manners import plain
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.steering import Table


@click.command(
    "lookup",
    epilog="Examples: pyport lookup 3model.bin --az -100.5 --zd 30.25; "
    "tail -f targets | pyport lookup 3model.bin --batch -",
)
@click.argument("table", type=click.Path(exists=True, dir_okay=False))
@click.option("--az", type=float, help="Azimuth as the table has it, unwrapped [deg].")
@click.option("--zd", type=float, help="Zenith distance [deg].")
@click.option(
    "--batch",
    type=click.File("r"),
    help="File of azimuth and zenith distance, a pair a line; - for standard input.",
)
@click.option(
    "--errors",
    is_flag=True,
    help="State the errors of interpolation against the model, all over the sky.",
)
@click.option("--json", "as_json", is_flag=True, help="Print each answer as a line of JSON.")
def command(
    table: str,
    az: float | None,
    zd: float | None,
    batch: IO[str] | None,
    errors: bool,  # noqa: FBT001 - click's
    as_json: bool,  # noqa: FBT001 - click's
) -> None:
    """Print azimuth, zenith distance and their offsets [deg], interpolated in TABLE."""
    from pyport import steering
    from pyport.steering.lookup import answers

    if (az is None) != (zd is None) or not (errors or batch or az is not None):
        raise click.UsageError("give --az and --zd, or --batch FILE, or --errors")
    read = steering.read_table(table)
    if errors:
        _print_errors(read, table, as_json=as_json)
    if az is not None:
        for answer in answers(read, [f"{az!r} {zd!r}"], table):
            click.echo(_as_json(answer) if as_json else answer)
    if batch:
        for answer in answers(read, batch, batch.name):
            print(_as_json(answer) if as_json else answer, flush=True)  # noqa: T201 - a pipe waits for every line


def _as_json(answer: str) -> str:
    """Return a line of four angles [deg] as JSON."""
    names = ("az_deg", "zd_deg", "d_az_deg", "d_zd_deg")
    return json.dumps(dict(zip(names, map(float, answer.split()), strict=True)))


def _print_errors(table: Table, file: str, *, as_json: bool) -> None:
    """Print how far interpolated offsets stray from the model in each band of zenith distance."""
    from pyport.steering.lookup import interpolation_errors
    from pyport.steering.tabulate import offsets_of

    if not table.model:
        raise BadInput("does not say what model it was made from: a binary table does", file)
    truth = offsets_of(table.model, table.refraction, table.reading)
    if as_json:
        for one in interpolation_errors(table, truth):
            click.echo(json.dumps(plain(one)))
        return
    click.echo("zenith distance    azimuth on the sky   zenith distance      across a step")
    click.echo("          [deg]     rms    most [mdeg]    rms    most [mdeg]  cells  most [mdeg]")
    for one in interpolation_errors(table, truth):
        click.echo(
            f"{one.zd_from_deg:6g} to {one.zd_to_deg:3g}{1e3 * one.az_rms_deg:12.4f}"
            f"{1e3 * one.az_max_deg:10.4f}{1e3 * one.zd_rms_deg:12.4f}{1e3 * one.zd_max_deg:10.4f}"
            f"{one.steps:9d}{1e3 * one.step_deg:12.4f}"
        )
