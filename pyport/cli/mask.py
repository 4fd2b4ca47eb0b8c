"""`pyport mask`: which recordings of a file are not to be used, and how that is undone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file

if TYPE_CHECKING:
    from pyport.recordings.given import Given
    from pyport.recordings.raw import Raw


@click.command(
    "mask", epilog='Example: pyport mask night.csv --where "wind_speed_m_s > 15" --reason wind'
)
@click.argument("recordings", type=click.Path(path_type=Path, exists=True, dir_okay=False))
@click.option("--lines", default="", metavar="12,40-44", help="Lines (rows) of the file.")
@click.option("--outliers", default="", metavar="MODEL", help="What a fit of MODEL leaves far out.")
@click.option("--reason", default="", help="Why: it is told wherever these are set aside.")
@click.option("--unmask", is_flag=True, help="Use the lines again instead of masking them.")
@click.option("--undo", is_flag=True, help="Take the last step back.")
@about_file
def command(
    recordings: Path,
    lines: str,
    outliers: str,
    reason: str,
    given: Given,
    *,
    unmask: bool,
    undo: bool,
) -> None:
    """Mask RECORDINGS by lines, by --where or as outliers; without any, tell what is masked.

    The mask is kept beside the file, as RECORDINGS.mask, step by step; the
    file itself is never changed. Every command that reads the file obeys it.
    """
    from dataclasses import replace

    from pyport.formats import tables
    from pyport.recordings import masks

    if sum(map(bool, (lines, outliers, given.where, undo))) > 1:
        raise click.UsageError("take one of --lines, --outliers, --where and --undo")
    if undo:
        step = masks.undo(recordings)
        click.echo(f"undone: {'masked' if step.masks else 'unmasked'} {masks.spelled(step.lines)}")
    raw = tables.read(recordings, given.format, given.columns)
    raw = replace(raw, meta=raw.meta | dict(given.keys))
    chosen = _chosen(raw, lines, outliers, given)
    if chosen:
        masks.add(raw, chosen, reason or given.where, masks=not unmask)
        verb = "unmasked" if unmask else "masked"
        click.echo(f"{verb} {masks.spelled(chosen)} ({len(chosen)} lines)")
    elif lines or outliers or given.where:
        click.echo("no such recordings: nothing was changed")
    standing = masks.standing(raw, masks.steps(recordings))
    for why in sorted(set(standing.values())):
        those = [line for line, own in standing.items() if own == why]
        click.echo(f"masked{': ' + why if why else ''}: {masks.spelled(those)}")
    click.echo(f"{len(standing)} of {len(raw.line)} recordings are masked")


def _chosen(raw: Raw, lines: str, outliers: str, given: Given) -> tuple[int, ...]:
    """Return the lines that the options name."""
    from pyport.recordings import masks
    from pyport.recordings.interpret import interpret

    if lines:
        return masks.parse_lines(lines)
    if given.where:
        from pyport.recordings.where import parse

        recordings = interpret(raw)
        return tuple(recordings.line[parse(given.where)(recordings)].tolist())
    if outliers:
        import numpy as np

        from pyport.fitting.fit import fit
        from pyport.fitting.models import load

        done = fit(interpret(masks.masked(raw)), load(outliers))
        rows = np.unique(done.stack.row[done.weight <= 0])
        return tuple(done.recordings.line[rows].tolist())
    return ()
