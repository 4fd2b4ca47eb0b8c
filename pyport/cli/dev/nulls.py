"""`pyport dev nulls`: false claims, and how often sigmas hold, in simulated noise."""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import click

from pyport.cli.manners import resumable
from pyport.errors import BadInput


@click.command("nulls", epilog="Example: pyport dev nulls --cases 100 --jobs 2")
@click.option("--cases", default=100, show_default=True, help="Cases of each kind and part.")
@click.option("--kinds", help="Kinds of noise, separated by commas; all by default.")
@click.option("--seed", default=1, show_default=True, help="Seed of everything random.")
@click.option("--jobs", default=1, show_default=True, help="Cases at the same time.")
@click.option(
    "--part",
    type=click.Choice(["all", "null", "cause"]),
    default="all",
    show_default=True,
    help="Nothing hidden, one cause, or both.",
)
@click.option(
    "--by",
    type=click.Choice(["rows", "sessions", "sky", "cause"]),
    help="Another table: one line for each of these, over all kinds.",
)
@resumable("out/nulls")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON lines.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
def command(
    cases: int,
    kinds: str | None,
    seed: int,
    jobs: int,
    part: str,
    by: str | None,
    out: Path,
    *,
    as_json: bool,
    quiet: bool,
) -> None:
    """Count claims where nothing is hidden, and how often sigmas hold, in twenty kinds of noise.

    At most 3 % of the cases with nothing hidden may claim something; 64 to 72 % of the
    coefficients lie within one sigma of the truth, 93 to 97 % within two. Outcomes are kept in
    OUT/nulls.jsonl, and count for the program that they came from alone.
    """
    from pyport.examiner import outcomes
    from pyport.examiner.nulls import noises, nulls, nulls_table

    chosen = kinds.split(",") if kinds else list(noises.KINDS)
    for one in chosen:
        if one not in noises.KINDS:
            known = ", ".join(noises.KINDS)
            raise BadInput(f"no kind of noise is called {one!r}; there are {known}")
    parts = (nulls.NULL, nulls.CAUSE) if part == "all" else (part,)
    wanted = nulls.cases(chosen, cases, seed, parts)
    found: dict[str, dict[Any, list[dict[str, Any]]]] = {
        "kind": {kind: [] for kind in chosen},
        "by": defaultdict(list),
    }
    for done, outcome in enumerate(
        outcomes.run(wanted, nulls.examine, out / "nulls.jsonl", jobs), 1
    ):
        found["kind"][outcome["kind"]].append(outcome)
        if by is not None:
            found["by"][outcome[by]].append(outcome)
        if as_json:
            click.echo(json.dumps(outcome))
        if not quiet and sys.stderr.isatty():
            click.echo(f"\r{done} of {len(wanted)} cases", err=True, nl=done == len(wanted))
    if quiet or as_json:
        return
    click.echo(nulls_table.text([nulls_table.line(*one) for one in found["kind"].items()]))
    if by is not None:
        lines = sorted(found["by"].items(), key=lambda one: (str(type(one[0])), one[0] or 0))
        click.echo("")
        click.echo(nulls_table.text([nulls_table.line(f"{by} {n}", all_) for n, all_ in lines]))
