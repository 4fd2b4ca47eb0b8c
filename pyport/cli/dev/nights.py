"""`pyport dev nights`: false alarms and delays of the watch on simulated nights."""

from __future__ import annotations

import json
from pathlib import Path

import click

from pyport.cli.manners import as_promised, counted, in_json, resumable


@click.command("nights", epilog="Example: pyport dev nights --nulls 1000 --steps 1000")
@click.option("--nulls", default=1000, show_default=True, help="Nights without any change.")
@click.option("--steps", default=1000, show_default=True, help="Steps of one to five sigmas.")
@click.option("--seed", default=1, show_default=True, help="Seed of everything random.")
@as_promised
@resumable("out/nights")
@in_json
def command(nulls: int, steps: int, seed: int, rarity: float, out: Path, *, as_json: bool) -> None:
    """Count false alarms in twenty kinds of noise, and measure delays beside the best possible.

    Five nights of each case are the past, five are watched. The best possible delay is that of
    a CUSUM that knows the step's shape and size, the noise and the model, with as few false alarms.
    """
    from pyport.examiner.nights import nights, summary

    cases = [*nights.null_cases(nulls, seed), *nights.step_cases(steps, seed)]
    some = summary.outcomes(cases, out / "nights.jsonl", rarity)
    found = list(counted(some, len(cases)))
    if as_json:
        click.echo(json.dumps(found))
        return
    if nulls:
        click.echo(summary.of_nulls((one for one in found if not one["step"]), rarity))
    if steps:
        click.echo("\n" + summary.of_steps(one for one in found if one["step"]))
