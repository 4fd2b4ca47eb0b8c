"""`pyport dev mounts`: causes by name, and silence, on mounts that are not alt-azimuth."""

from __future__ import annotations

import json
from pathlib import Path

import click

from pyport.cli.manners import counted, resumable
from pyport.errors import BadInput


@click.command("mounts", epilog="Example: pyport dev mounts --cases 60 --jobs 2")
@click.option("--cases", default=60, show_default=True, help="Cases of each mount and part.")
@click.option("--mounts", "named", help="Mounts, separated by commas; all by default.")
@click.option("--parts", help="empty, one, two, unknown, separated by commas; all by default.")
@click.option("--seed", default=1, show_default=True, help="Seed of everything random.")
@click.option("--jobs", default=1, show_default=True, help="Cases at the same time.")
@resumable("out/mounts")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON lines.")
def command(
    *,
    cases: int,
    named: str | None,
    parts: str | None,
    seed: int,
    jobs: int,
    out: Path,
    as_json: bool,
) -> None:
    """Hide causes in drawn sessions of German, fork and X-Y mounts, and count what is found.

    A model of five terms is fitted; one cause, or two, or one without a name, shows half of the
    noise beside it, or nothing is hidden. 98 % of the empty sessions are to stay silent, 95 % of
    the single causes to be named.
    """
    from pyport.examiner import outcomes
    from pyport.examiner.mounts import examine

    chosen = _among(named, examine.MOUNTS, "mount"), _among(parts, examine.PARTS, "part")
    wanted = examine.cases(*chosen, cases, seed)
    found = []
    some = outcomes.run(wanted, examine.examine, out / "mounts.jsonl", jobs)
    for one in counted(some, len(wanted)):
        found.append(one)
        if as_json:
            click.echo(json.dumps(one))
    if not as_json:
        click.echo(examine.text(found))


def _among(given: str | None, known: tuple[str, ...], what: str) -> tuple[str, ...]:
    """Return the names given, separated by commas, all of them for none."""
    names = tuple(given.split(",")) if given else known
    for name in names:
        if name not in known:
            raise BadInput(f"no {what} is called {name!r}; there are {', '.join(known)}")
    return names
