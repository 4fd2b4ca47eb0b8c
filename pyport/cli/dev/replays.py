"""`pyport dev replays`: public recordings put to the watch in the order of time."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import click

from pyport.cli.manners import as_promised, in_json, plain


@click.command("replays", epilog="Example: pyport dev replays --data ../shared/data")
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("../shared/data"),
    show_default=True,
    help="Folder of public recordings; what is not there is said to be.",
)
@as_promised
@in_json
def command(data: Path, rarity: float, *, as_json: bool) -> None:
    """Replay public recordings in the order of time; say what is raised, and what is known.

    The first ten pointings for each coefficient stand for the past, and three nights where that
    leaves half; of an array its first day.
    """
    from pyport.examiner.nights import replays

    found = []
    for one in replays.replays(data, rarity):
        found.append(one)
        if as_json:
            click.echo(json.dumps(plain(dataclasses.asdict(one))))
        else:
            click.echo(replays.text(one) + "\n")
    if not as_json:
        click.echo(replays.total(found, rarity))
