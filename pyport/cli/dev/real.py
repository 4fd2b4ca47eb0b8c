"""`pyport dev real`: public recordings of other telescopes, beside what was published of them."""

from __future__ import annotations

import json
from pathlib import Path

import click

from pyport.cli.manners import resumable
from pyport.errors import BadInput


@click.command("real", epilog="Example: pyport dev real --data ../shared/data --jobs 2")
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("../shared/data"),
    show_default=True,
    help="Folder of public recordings; missing sets are listed.",
)
@click.option("--sets", help="Sets whose names begin so, separated by commas; all by default.")
@click.option("--subsets", default=200, show_default=True, help="Subsets of few rows of each set.")
@click.option("--jobs", default=1, show_default=True, help="Sets at the same time.")
@resumable("out/real")
@click.option("--markdown", type=click.Path(path_type=Path), help="Write the table as a page.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON line a set.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
def command(
    data: Path,
    sets: str | None,
    subsets: int,
    jobs: int,
    out: Path,
    markdown: Path | None,
    *,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run fit and diagnose on public recordings, beside what was published of them.

    A row a set: scatter of the fit over Huber least squares of the same terms, sigmas and
    findings against halves of the nights, what predicts worse, and in how many of SUBSETS
    random subsets of 15 to 40 rows.
    """
    import dataclasses

    from pyport.examiner.real import run, table
    from pyport.files import write_whole

    try:
        entries = run.chosen([one.strip() for one in (sets or "").split(",") if one.strip()])
    except KeyError as error:
        raise BadInput(f"no set of recordings is called {error.args[0]!r}") from None
    rows, absent = [], []
    for one in run.rows(entries, data, subsets, out / "real.jsonl", jobs):
        if isinstance(one, str):
            absent.append(one)
            continue
        rows.append(one)
        if as_json:
            click.echo(json.dumps(dataclasses.asdict(one)))
        elif not quiet:
            click.echo(table.of_set(one) + "\n")
    order = [one["name"] for one in entries]
    rows.sort(key=lambda row: order.index(row.name))
    if markdown is not None:
        with write_whole(markdown) as file:
            file.write(table.markdown(rows, absent))
    if not quiet and not as_json:
        click.echo(table.text(rows, absent))
