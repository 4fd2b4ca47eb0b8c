"""`pyport mask`: which recordings of a file are not to be used, and how that is undone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.about import about_file
from pyport.cli.manners import in_json, say

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions, Raw


@click.command(
    "mask", epilog='Example: pyport mask night.csv --where "wind_speed_m_s > 15" --reason wind'
)
@click.argument("recordings", type=click.Path(path_type=Path, exists=True, dir_okay=False))
@click.option("--lines", default="", metavar="12,40-44", help="Lines (rows) of the file.")
@click.option(
    "--outliers", default="", metavar="MODEL", help="Mask the outliers of a fit of MODEL."
)
@click.option("--reason", default="", help="Why; listed with the excluded lines.")
@click.option("--unmask", is_flag=True, help="Use the lines again instead of masking them.")
@click.option("--undo", is_flag=True, help="Undo the last step.")
@about_file
@in_json
def command(
    recordings: Path,
    lines: str,
    outliers: str,
    reason: str,
    given: FileOptions,
    *,
    unmask: bool,
    undo: bool,
    as_json: bool,
) -> None:
    """Mask RECORDINGS by lines, by --where or as outliers; without any, list what is masked.

    The mask is kept beside the file, as RECORDINGS.mask, step by step; the
    file itself is never changed. Every command that reads the file obeys it.
    """
    from dataclasses import replace

    from pyport.recordings import masks
    from pyport.recordings.formats import registry as tables

    if sum(map(bool, (lines, outliers, given.where, undo))) > 1:
        raise click.UsageError("take one of --lines, --outliers, --where and --undo")
    told: list[str] = []
    if undo:
        step = masks.undo(recordings)
        told.append(f"undone: {'masked' if step.masks else 'unmasked'} {masks.spelled(step.lines)}")
    raw = tables.read(recordings, given.format, given.columns, given.mapping)
    raw = replace(raw, meta=raw.meta | dict(given.keys))
    chosen = _chosen(raw, lines, outliers, given)
    if chosen:
        masks.add(raw, chosen, reason or given.where, masks=not unmask)
        verb = "unmasked" if unmask else "masked"
        told.append(f"{verb} {masks.spelled(chosen)} ({len(chosen)} lines)")
    elif lines or outliers or given.where:
        told.append("no such recordings: nothing was changed")
    standing = masks.standing(raw, masks.steps(recordings))
    for why in sorted(set(standing.values())):
        those = [line for line, own in standing.items() if own == why]
        told.append(f"masked{': ' + why if why else ''}: {masks.spelled(those)}")
    told.append(f"{len(standing)} of {len(raw.line)} recordings are masked")
    lines_masked = [{"line": line, "reason": why} for line, why in sorted(standing.items())]
    answer = {"recordings": len(raw.line), "changed": list(chosen), "masked": lines_masked}
    say("\n".join(told), answer, as_json=as_json)


def _chosen(raw: Raw, lines: str, outliers: str, given: FileOptions) -> tuple[int, ...]:
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
        from pyport.formats.models import load

        done = fit(interpret(masks.masked(raw)), load(outliers))
        rows = np.unique(done.stack.row[~done.noise.used])
        return tuple(done.recordings.line[rows].tolist())
    return ()
