"""`pyport dev calibrate`: what thresholds mean where nothing is hidden, in all kinds of noise."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from pyport.cli.manners import in_json, resumable, say


@click.command("calibrate", epilog="Example: pyport dev calibrate FAMILY_ERROR --cases 10")
@click.argument(
    "names",
    nargs=-1,
    type=click.Choice(["FAMILY_ERROR", "CONVINCING", "coverage"]),
    metavar="[NAME]...",
)
@click.option("--cases", default=20, show_default=True, help="Cases of each kind of noise.")
@click.option("--seed", default=7, show_default=True, help="Seed of everything random.")
@click.option("--jobs", default=1, show_default=True, help="Cases at the same time.")
@click.option("--into", type=click.Path(exists=True, dir_okay=False), help="The page to rewrite.")
@resumable("out/calibrate")
@in_json
def command(
    *,
    names: tuple[str, ...],
    cases: int,
    seed: int,
    jobs: int,
    into: str | None,
    out: Path,
    as_json: bool,
) -> None:
    """Draw noise with nothing in it; count false alarms against each threshold, and coverage.

    NAME is FAMILY_ERROR, CONVINCING or coverage, all three by default; one run of cases serves
    them all. With --into the tables of that page are written anew.
    """
    from pyport.cli.dev.thresholds import put_between
    from pyport.examiner import outcomes
    from pyport.examiner.acceptance import calibrate
    from pyport.examiner.nulls import noises, nulls
    from pyport.files import write_whole

    wanted = nulls.cases(noises.KINDS, cases, seed, (nulls.NULL,))
    found = []
    for one in outcomes.run(wanted, calibrate.examine, out / "calibrate.jsonl", jobs):
        found.append(one)
        if sys.stderr.isatty():
            click.echo(f"\r{len(found)} of {len(wanted)} cases", err=True, nl=False)
    order = {kind: n for n, kind in enumerate(noises.KINDS)}
    found.sort(key=lambda one: (order[one["kind"]], one["number"]))
    tables = [calibrate.text(name, found) for name in names or calibrate.LEVELS]
    if into is None:
        say("\n\n".join(tables), found, as_json=as_json)
        return
    text = "".join(f"```text\n{one}\n```\n\n" for one in tables)
    page = put_between(Path(into).read_text(encoding="utf-8"), "calibration", text)
    with write_whole(into) as file:
        file.write(page)
