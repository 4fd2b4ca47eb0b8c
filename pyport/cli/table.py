"""`pyport table`: write the steering table of a model, or hold it to the published one."""

from __future__ import annotations

import click


@click.command("table")
@click.option("--model", default="rt32-3model", show_default=True, help="A built-in model.")
@click.option("--refraction", help="A formula of mean refraction, or none.")
@click.option("-o", "--output", type=click.Path(dir_okay=False), help="The file to write.")
@click.option("--check", is_flag=True, help="Compare with every published number of 3model.")
@click.option(
    "--reading",
    default="as-written",
    show_default=True,
    help="as-written, routine or float64: how the numbers of an RT32 table are computed.",
)
def command(
    model: str,
    refraction: str | None,
    output: str | None,
    check: bool,  # noqa: FBT001 - click's
    reading: str,
) -> None:
    """Write the steering table of a pointing model, refraction included."""
    from pyport import steering

    if not (output or check):
        raise click.UsageError("nothing to do: give -o FILE, or --check")
    if check:
        _print_check(refraction or steering.DEFAULT_REFRACTION, reading)
    if output:
        table = steering.tabulate(model, refraction, reading=reading)
        steering.write_ascii(table, output)
        click.echo(
            f"{output}: {len(table.grid)} rows, model {table.model}, refraction {table.refraction}"
        )


def _print_check(refraction: str, reading: str) -> None:
    """Print how many cells of each published block agree in their last digit, and the others."""
    from pyport.steering import check

    for result in check(refraction, reading):
        block = result.block
        click.echo(f"{block.name:<38}{result.agree:4d} of {result.total}")
        for i in result.misses:
            click.echo(
                f"    azimuth {block.az_deg[i]:g}, zenith distance {block.zd_deg[i]:g}: "
                f"{result.computed[i]:.2f}, printed {block.printed[i]}"
            )
