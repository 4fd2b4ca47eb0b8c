"""`pyport dev acceptance`: every figure that is promised of a diagnosis, measured anew."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from pyport.examiner.acceptance.drawn import Line


@click.command("acceptance", epilog="Example: pyport dev acceptance --jobs 2 --data ../shared/data")
@click.option("--data", type=click.Path(path_type=Path), help="Folder of others' recordings.")
@click.option("--jobs", default=1, show_default=True, help="Cases at the same time.")
@click.option("--seed", default=10_000, show_default=True, help="Where the cases' seeds begin.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
def command(data: Path | None, jobs: int, seed: int, *, as_json: bool, quiet: bool) -> None:
    """Measure what is promised of a diagnosis, on real and simulated recordings.

    Each line says what came out, what was asked for, and whether it did.
    Recordings and surveys of others are looked for in DATA; what is not there is
    said to be left out.
    """
    import json

    for line in _lines(data, jobs, seed):
        if as_json:
            click.echo(json.dumps(vars(line)))
        elif not quiet:
            mark = {True: "yes", False: "NO", None: ""}[line.passed]
            click.echo(f"{mark:3}  {line.what}: {line.value} ({line.wanted})")


def _lines(data: Path | None, jobs: int, seed: int) -> Iterator[Line]:
    from pyport.examiner.acceptance import array, drawn, jump, real
    from pyport.recordings.antennas import read_survey

    there = data is not None and data.is_dir()
    survey = read_survey(data / "gmrt" / "antennas_enu.csv") if data is not None and there else None
    yield from array.lines(survey)
    if data is not None and there:
        yield from real.lines(data)
    else:
        yield drawn.Line("others' recordings", "left out", f"no folder {data}", None)
    yield from jump.lines(seed)
    yield from drawn.lines(jobs, seed)
