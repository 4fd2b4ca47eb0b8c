"""`pyport dev efficiency`: detections and names over what an ideal observer could detect."""

from __future__ import annotations

import json
from pathlib import Path

import click

from pyport.cli.manners import counted, resumable
from pyport.errors import BadInput


@click.command("efficiency", epilog="Example: pyport dev efficiency --rows 100,300 --rho 0.5")
@click.option("--cases", default=1, show_default=True, help="Cases of each cause in each cell.")
@click.option("--effects", help="Causes, separated by commas; all by default.")
@click.option("--rows", help="Numbers of recordings, separated by commas; 60 to 2400 by default.")
@click.option("--rho", help="Visible rms over the noise, separated by commas; 0.25, 0.5 and 1.")
@click.option("--seed", default=4000, show_default=True, help="Where the seeds begin.")
@click.option("--jobs", default=1, show_default=True, help="Cases at the same time.")
@resumable("out/efficiency")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON lines.")
def command(
    *,
    cases: int,
    effects: str | None,
    rows: str | None,
    rho: str | None,
    seed: int,
    jobs: int,
    out: Path,
    as_json: bool,
) -> None:
    """Hide one cause in simulated recordings; hold what is found against the ideal observer.

    The observer knows the form of the cause and the noise, pays for every effect that could be
    tested, and makes false alarms as often. Efficiency is detections, or right names, over the
    detections that it would make.
    """
    from pyport.examiner import outcomes
    from pyport.examiner.ideal import efficiency
    from pyport.examiner.worlds.kinds import HIDEABLE

    names = tuple(effects.split(",")) if effects else HIDEABLE
    for name in names:
        if name not in HIDEABLE:
            raise BadInput(f"no cause is called {name!r}; there are {', '.join(HIDEABLE)}")
    try:
        sizes = [int(one) for one in rows.split(",")] if rows else list(efficiency.ROWS)
        loud = [float(one) for one in rho.split(",")] if rho else list(efficiency.RHOS)
    except ValueError as error:
        raise BadInput(f"{error}, expected numbers separated by commas") from None
    wanted = efficiency.cases(names, loud, sizes, cases, seed)
    found = []
    some = outcomes.run(wanted, efficiency.examine, out / "efficiency.jsonl", jobs)
    for one in counted(some, len(wanted)):
        found.append(one)
        if as_json:
            click.echo(json.dumps(one))
    if not as_json:
        click.echo(efficiency.text(found))
