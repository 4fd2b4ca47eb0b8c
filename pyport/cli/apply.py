"""`pyport apply`: a model's offsets for targets, where to drive, and back to the sky."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import in_json, models, say

if TYPE_CHECKING:
    from pyport.correction.apply import Applied
    from pyport.recordings.raw import FileOptions


@click.command(
    "apply",
    epilog="Examples: pyport apply new.toml targets.csv -o commands.csv; "
    "pyport apply new.toml night.csv --residuals",
)
@click.argument("model", shell_complete=models)
@click.argument("targets")
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File to write: .csv, .ecsv or .parquet.  [default: CSV on standard output]",
)
@click.option("--inverse", is_flag=True, help="From the mount's az_deg, el_deg to the sky's.")
@click.option("--residuals", is_flag=True, help="TARGETS are recordings: add their residuals.")
@about_file
@in_json
def command(
    model: str,
    targets: str,
    given: FileOptions,
    out: Path | None,
    *,
    inverse: bool,
    residuals: bool,
    as_json: bool,
) -> None:
    """Add the offsets of MODEL to TARGETS, and where to drive.

    TARGETS is any file with the columns of recordings, offsets or not; a condition that the
    model follows is a column, or one value for all: --set temperature_c=8.
    """
    from pyport.api import load_model
    from pyport.correction.apply import applied, with_conditions
    from pyport.recordings.files import read_raw, resolve
    from pyport.recordings.formats import registry as tables

    raw = read_raw(resolve(targets), given)
    raw = with_conditions(raw, given.keys)
    asked = load_model(model)
    done = applied(asked, raw, inverse=inverse, residuals=residuals, where=given.where)
    if out is not None:
        tables.write(done.table, out)
    if as_json:
        columns = {name: done.table.columns[name] for name in done.added}
        told = {"file": out, "rows": done.rows, "skipped": done.skipped, "unknown": done.unknown}
        say("", told | {"rms_arcsec": done.rms, "columns": columns}, as_json=True)
        return
    if out is None:
        click.echo(_csv(done), nl=False)
        for line in _words(done):
            click.echo(line, err=True)
        return
    click.echo(f"{out}: {done.rows} rows with {', '.join(done.added)}")
    for line in _words(done):
        click.echo(line)


def _csv(done: Applied) -> str:
    """Return a table as CSV text."""
    import csv
    import io

    out = io.StringIO()
    out.writelines(f"# {key}: {value}\n" for key, value in done.table.meta.items())
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(done.table.columns)
    cells = [_spelled(name, one.tolist(), done) for name, one in done.table.columns.items()]
    writer.writerows(zip(*cells, strict=True))
    return out.getvalue()


def _spelled(name: str, cells: list[object], done: Applied) -> list[object]:
    """Return cells as text, new ones with as many decimals as a mount can use."""
    if name not in done.added:
        return cells
    decimals = 4 if name.endswith("_arcsec") else 7
    return ["" if one != one else f"{one:.{decimals}f}" for one in cells]  # noqa: PLR0124


def _words(done: Applied) -> list[str]:
    """Return what there is to say beside the table."""
    found = []
    if done.skipped:
        found.append(f"{done.skipped} rows tell no direction")
    found += [
        f"{count} rows do not tell {name}: what follows it counts as zero there"
        for name, count in done.unknown.items()
    ]
    if done.rms:
        parts = ", ".join(f"{name} {value:.2f}" for name, value in done.rms.items())
        found.append(f"rms of what is left [arcsec]: {parts} (sky: both axes, by the row)")
    return found
