"""Small commands on one file: masks, offsets out of scans, look-ups; and completion."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable
from pathlib import Path
from typing import IO, TYPE_CHECKING

import click

from pyport.cli.manners import (
    PATH,
    about_file,
    flag,
    in_json,
    option,
    plain,
    refuse_without_columns,
    say,
    warn,
)
from pyport.cli.table import conditions_of, under_conditions
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.recordings.raw import FileOptions, Raw
    from pyport.recordings.scans import Average
    from pyport.steering import Table
    from pyport.steering.tabulate import Conditions


@click.command(
    "mask", epilog='Example: pyport mask night.csv --where "wind_speed_m_s > 15" --reason wind'
)
@click.argument("recordings", type=click.Path(path_type=Path, exists=True, dir_okay=False))
@option("--lines", "Lines (rows) of the file.", metavar="12,40-44", default="")
@option("--outliers", "Mask the outliers of a fit of MODEL.", metavar="MODEL", default="")
@option("--reason", "Why; listed with the excluded lines.", default="")
@flag("--unmask", "Use the lines again instead of masking them.")
@flag("--undo", "Undo the last step.")
@about_file
@in_json
def mask(
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
    said: list[str] = []
    if undo:
        step = masks.undo(recordings)
        said.append(f"undone: {'masked' if step.masks else 'unmasked'} {masks.spelled(step.lines)}")
    raw = tables.read(recordings, given.format, given.columns, given.mapping)
    raw = replace(raw, meta=raw.meta | dict(given.keys))
    chosen = _chosen(raw, lines, outliers, given)
    if unmask:
        masked = masks.standing(raw, masks.steps(recordings))
        chosen = tuple(line for line in chosen if line in masked)
    if chosen:
        masks.add(raw, chosen, reason or given.where, masks=not unmask)
        verb = "unmasked" if unmask else "masked"
        said.append(f"{verb} {masks.spelled(chosen)} ({len(chosen)} lines)")
    elif lines or outliers or given.where:
        none = "none of these is masked" if unmask else "no such recordings"
        said.append(f"{none}: nothing was changed")
    standing = masks.standing(raw, masks.steps(recordings))
    for why in sorted(set(standing.values())):
        those = [line for line, own in standing.items() if own == why]
        said.append(f"masked{': ' + why if why else ''}: {masks.spelled(those)}")
    said.append(f"{len(standing)} of {len(raw.line)} recordings are masked")
    lines_masked = [{"line": line, "reason": why} for line, why in sorted(standing.items())]
    answer = {"recordings": len(raw.line), "changed": list(chosen), "masked": lines_masked}
    say("\n".join(said), answer, as_json=as_json)


def _chosen(raw: Raw, lines: str, outliers: str, given: FileOptions) -> tuple[int, ...]:
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


@click.command("offsets", epilog="Example: pyport offsets scans.csv -o offsets.csv")
@click.argument("scans", type=click.Path(path_type=Path))
@option("-o --out", "File for the recordings: .csv, .ecsv or .parquet.", type=PATH)
@in_json
def offsets(scans: Path, out: Path | None, *, as_json: bool) -> None:
    """Fit the beam in each of SCANS, print the averages to load, write the recordings."""
    from pyport.recordings import resolve, write
    from pyport.recordings.scans import averages, measure, text

    refuse_without_columns(out)
    recordings = measure(resolve(scans))
    found = averages(recordings)
    if out is not None:
        write(recordings, out)
    if as_json:
        rows = [_of_average(one) for one in found]
        say("", {"averages": rows, "set_aside": recordings.set_aside}, as_json=True)
        return
    click.echo(text(found))
    for aside in recordings.set_aside:
        click.echo(f"{scans}:{aside.line}: excluded: {aside.reason}")
    if out is not None:
        click.echo(f"{len(recordings)} recordings in {out}, {len(recordings.set_aside)} excluded")


def _of_average(one: Average) -> dict[str, object]:
    from pyport.angles import ARCMIN

    return {
        "antenna": one.antenna,
        "axis": one.axis,
        "round": one.round,
        "offset_arcmin": one.offset / ARCMIN,
        "sigma_arcmin": one.sigma / ARCMIN,
        "half_difference_arcmin": one.half_difference / ARCMIN,
        "scans": one.scans,
        "near_zero": one.near_zero,
    }


@click.command(
    "lookup",
    epilog="Examples: pyport lookup 3model.bin --az -100.5 --zd 30.25; "
    "tail -f targets | pyport lookup 3model.bin --batch -",
)
@click.argument("table", type=click.Path(exists=True, dir_okay=False))
@option("--az", "Azimuth as the table has it, unwrapped [deg].", type=float)
@option("--zd", "Zenith distance [deg].", type=float)
@option(
    "--batch",
    "File of azimuth and zenith distance, a pair a line; - for standard input.",
    type=click.File("r", encoding="utf-8-sig", errors="replace"),
)
@flag("--errors", "State the errors of interpolation against the model, all over the sky.")
@under_conditions
@flag("--json as_json", "Print each answer as a line of JSON.")
def lookup(
    table: str,
    az: float | None,
    zd: float | None,
    batch: IO[str] | None,
    errors: bool,  # noqa: FBT001 - click's
    azimuth_zero: str | None,
    conditions: tuple[str, ...],
    as_json: bool,  # noqa: FBT001 - click's
) -> None:
    """Print azimuth, zenith distance and their offsets [deg], interpolated in TABLE."""
    from pyport import steering
    from pyport.steering.lookup import answers, beside_zenith

    if (az is None) != (zd is None) or not (errors or batch or az is not None):
        raise click.UsageError("give --az and --zd, or --batch FILE, or --errors")
    read = steering.read_table(table)
    beside = conditions_of(azimuth_zero, conditions, read.model)
    if errors:
        _print_errors(read, table, beside, as_json=as_json)
    one = [] if az is None else [f"{az!r} {zd!r}"]
    many: Iterable[str] = batch or ()
    low, high = beside_zenith(read)
    for answer in itertools.chain(
        answers(read, one, table), answers(read, many, getattr(batch, "name", "<stdin>"))
    ):
        print(_as_json(answer) if as_json else answer, flush=True)  # noqa: T201 - a pipe waits for every line
        away = answer.split()[1]
        if low < float(away) < high and float(away):
            low = high  # said once
            warn(
                f"warning: {table}: between the zenith and the row beside it azimuth offsets turn "
                f"over and cannot be interpolated, as at zenith distance {away} deg"
            )


def _as_json(answer: str) -> str:
    """Return a line of four angles [deg] as JSON."""
    names = ("az_deg", "zd_deg", "d_az_deg", "d_zd_deg")
    return json.dumps(dict(zip(names, map(float, answer.split()), strict=True)))


def _print_errors(table: Table, file: str, beside: Conditions, *, as_json: bool) -> None:
    """Print how far interpolated offsets stray from the model in each band of zenith distance."""
    from pyport.steering.lookup import interpolation_errors
    from pyport.steering.tabulate import offsets_of

    if not table.model:
        raise BadInput("does not say what model it was made from: a binary table does", file)
    truth = offsets_of(table.model, table.refraction, table.reading, beside)
    if as_json:
        for one in interpolation_errors(table, truth):
            click.echo(json.dumps(plain(one)))
        return
    click.echo("zenith distance    azimuth on the sky   zenith distance      across a step")
    click.echo("          [deg]     rms    most [mdeg]    rms    most [mdeg]  cells  most [mdeg]")
    for one in interpolation_errors(table, truth):
        click.echo(
            f"{one.zd_from_deg:6g} to {one.zd_to_deg:3g}{1e3 * one.az_rms_deg:12.4f}"
            f"{1e3 * one.az_max_deg:10.4f}{1e3 * one.zd_rms_deg:12.4f}{1e3 * one.zd_max_deg:10.4f}"
            f"{one.steps:9d}{1e3 * one.step_deg:12.4f}"
        )


@click.command(
    "completion",
    epilog='Examples: eval "$(pyport completion bash)" in ~/.bashrc; '
    "pyport completion fish > ~/.config/fish/completions/pyport.fish",
)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the lines that teach SHELL to complete pyport's commands, options and names."""
    from click.shell_completion import get_completion_class

    from pyport.cli import pyport

    kind = get_completion_class(shell)
    if kind is None:  # the choice above holds only what click knows
        raise click.UsageError(f"no completion for {shell}")
    click.echo(kind(pyport, {}, "pyport", "_PYPORT_COMPLETE").source())
