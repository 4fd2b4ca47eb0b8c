"""`pyport fit`: the coefficients of a model, and what they leave."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command("fit", epilog="Example: pyport fit offsets.csv --model altaz --out fit")
@click.argument("recordings")
@click.option("--model", required=True, help="A built-in model or a file.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder for fit.json.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(recordings: str, model: str, out: Path | None, *, as_json: bool) -> None:
    """Fit a pointing model to RECORDINGS and print its coefficients with their sigmas."""
    from pyport.files import write_whole
    from pyport.fitting import table, waves
    from pyport.fitting.fit import fit
    from pyport.fitting.models import load
    from pyport.recordings import read, resolve

    done = fit(read(resolve(recordings)), load(model))
    report = json.dumps(table.as_json(done), indent=1)
    if out is not None:
        with write_whole(out / "fit.json") as file:
            file.write(report + "\n")
    if as_json:
        click.echo(report)
        return
    click.echo(table.text(done))
    if model == "gmrt-paper" and (found := waves.beside_table_18(done)):
        click.echo("\n" + waves.text(found))
