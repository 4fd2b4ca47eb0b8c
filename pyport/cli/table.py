"""`pyport table`: write the steering table of a model, hold it to the published one or another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pyport.cli.manners import flag, in_json, option, say

if TYPE_CHECKING:
    from pyport.steering import Grid, Table
    from pyport.steering.tabulate import Conditions


def under_conditions(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options `azimuth_zero` and `conditions` to a command."""
    for one in (
        option(
            "--set conditions",
            "A condition of the whole table, where the model depends on it: temperature_c=8.",
            multiple=True,
            metavar="COLUMN=VALUE",
        ),
        option(
            "--azimuth-zero",
            "Zero of the table's azimuth.  [default: south for the RT32's models]",
            of="north south",
        ),
    ):
        command = one(command)
    return command


def conditions_of(
    azimuth_zero: str | None, conditions: tuple[str, ...], model: str | None
) -> Conditions:
    """Return what both options say of a model, COLUMN=VALUE as columns inside the program."""
    from pyport.formats.models import load
    from pyport.models.conditions import columns_of
    from pyport.recordings.naming import SITE, site_of
    from pyport.steering.tabulate import Conditions

    named: dict[str, str] = {}
    for one in conditions:
        name, equals, value = one.partition("=")
        if not equals:
            raise click.UsageError(f"--set {one}: expected COLUMN=VALUE")
        named[name.strip()] = value.strip()
    site = site_of(named)
    beside = {key: one for key, one in named.items() if key not in SITE}
    if not beside:
        return Conditions(azimuth_zero, site=site)
    known = load(model).needs() if model else ()
    return Conditions(azimuth_zero, columns_of(beside, known), site)


@click.command(
    "table",
    epilog="Examples: pyport table -o 3model.txt; pyport table --check; "
    "pyport table --model rt32-approximate --against 3model.txt --picture difference.png",
)
@option("--model", "A model, or a TOML file.", "rt32-3model")
@option("--refraction", "A formula of mean refraction; see --refractions.")
@option("-o --output", "The file to write.", type=click.Path(dir_okay=False))
@option("--format layout", "Layout of the file.", "ascii", of="ascii binary")
@option(
    "--reading",
    "How an RT32 table is computed: as the published one was, by the printed routines with "
    "azimuth as the cable has it, or in double precision.",
    "as-written",
    of="as-written routine float64",
)
@under_conditions
@option("--az", "Azimuths, FIRST:LAST:STEP [deg].  [default: -270:270:1]")
@option("--zd", "Zenith distances, FIRST:LAST:STEP [deg].  [default: -5:89:1]")
@flag("--check", "Compare with every published number of 3model.")
@option("--against", "Compare with another table or model.", metavar="OLD")
@option("--picture", "Draw the comparison (PNG).", type=click.Path(dir_okay=False))
@option(
    "--recordings",
    "Write the published extracts as recordings (CSV), for pyport diagnose.",
    type=click.Path(dir_okay=False),
)
@flag("--refractions", "Compare every refraction with the published digits.")
@in_json
def command(
    model: str,
    refraction: str | None,
    output: str | None,
    layout: str,
    reading: str,
    azimuth_zero: str | None,
    conditions: tuple[str, ...],
    az: str | None,
    zd: str | None,
    check: bool,  # noqa: FBT001 - click's
    against: str | None,
    picture: str | None,
    recordings: str | None,
    refractions: bool,  # noqa: FBT001 - click's
    as_json: bool,  # noqa: FBT001 - click's
) -> None:
    """Write the steering table of a pointing model, refraction included."""
    from pyport import steering
    from pyport.runs.stages import working
    from pyport.steering.grid import span

    if not (output or check or against or recordings or refractions):
        raise click.UsageError("nothing to do: give -o FILE, --check, --against or --refractions")
    if picture and not against:
        raise click.UsageError("--picture draws a comparison: give --against OLD")
    answer: dict[str, object] = {}
    lines: list[str] = []
    if check and model != "rt32-3model":
        raise click.UsageError(f"--check is of rt32-3model, the published table, not of {model}")
    if check:
        lines += _checked(refraction or steering.DEFAULT_REFRACTION, reading, answer)
    if refractions:
        lines += _refractions(answer)
    if recordings:
        from pyport.steering.published import write_recordings

        write_recordings(recordings)
        answer["recordings"] = recordings
        lines.append(f"{recordings}: the published extracts as recordings")
    if output or against:
        grid = steering.Grid(
            span(az) if az else steering.RT32_GRID.az_deg,
            span(zd) if zd else steering.RT32_GRID.zd_deg,
        )
        beside = conditions_of(azimuth_zero, conditions, model)
        with working("tabulating"):
            table = steering.tabulate(model, refraction, grid, reading, beside)
        lines += _twice(model, table.refraction)
        if output:
            write = steering.write_binary if layout == "binary" else steering.write_ascii
            write(table, output)
            answer["table"] = {
                "file": output,
                "rows": len(grid),
                "model": model,
                "refraction": table.refraction,
            }
            lines.append(
                f"{output}: {len(grid)} rows, model {model}, refraction {table.refraction}"
            )
        if against:
            old = _old(against, grid, refraction, reading, beside)
            lines += _difference(table, old, against, picture, answer)
    say("\n".join(lines), answer, as_json=as_json)


def _twice(model: str, refraction: str) -> list[str]:
    """Return a warning where a model and the table both hold refraction."""
    from pyport.steering.tabulate import base_of

    if refraction == "none" or base_of(model) == model:
        return []
    from pyport.formats.models import load
    from pyport.models.model import BUILT_IN

    if model in BUILT_IN:
        return []
    held = [term for term in load(model).terms if term.effect.id == "refraction"]
    if not any(term.has_values for term in held):
        return []
    said = f"warning: the model has a term of refraction, and the table adds {refraction}"
    return [f"{said}: if the recordings hold all refraction, take --refraction none"]


def _checked(refraction: str, reading: str, answer: dict[str, object]) -> list[str]:
    """Return how many cells of each published block agree in their last digit, and the others."""
    from pyport.steering import check

    lines, blocks = [], []
    for result in check(refraction, reading):
        block = result.block
        lines.append(f"{block.name:<38}{result.agree:4d} of {result.total}")
        misses = [
            {
                "az_deg": block.az_deg[i],
                "zd_deg": block.zd_deg[i],
                "computed": result.computed[i],
                "printed": block.printed[i],
            }
            for i in result.misses
        ]
        lines += [
            f"    azimuth {one['az_deg']:g}, zenith distance {one['zd_deg']:g}: "
            f"{one['computed']:.2f}, printed {one['printed']}"
            for one in misses
        ]
        blocks.append(
            {"name": block.name, "agree": result.agree, "total": result.total, "misses": misses}
        )
    answer["check"] = blocks
    return lines


def _refractions(answer: dict[str, object]) -> list[str]:
    """Return how far each formula stays from the refraction that the published digits tell."""
    from pyport.steering.check import candidates

    lines = ["formula             iterated   farthest off   rms off [mdeg]   cells that agree"]
    found = []
    for one in candidates():
        worst, rms = 1e3 * one.outside_deg.max(), 1e3 * (one.outside_deg**2).mean() ** 0.5
        lines.append(
            f"{one.name:<20}{one.iterations:8d}{worst:15.4f}{rms:17.4f}"
            f"{one.agree:12d} of {one.total}"
        )
        found.append(
            {
                "name": one.name,
                "iterations": one.iterations,
                "worst_mdeg": worst,
                "rms_mdeg": rms,
                "agree": one.agree,
                "total": one.total,
            }
        )
    answer["refractions"] = found
    return lines


def _old(
    against: str, grid: Grid, refraction: str | None, reading: str, beside: Conditions
) -> Table:
    """Return the table of a file, or that of a model under the same conditions."""
    from pyport import steering

    if Path(against).is_file() and not against.endswith(".toml"):
        return steering.read_table(against)
    return steering.tabulate(against, refraction, grid, reading, beside)


def _difference(
    table: Table, old: Table, against: str, picture: str | None, answer: dict[str, object]
) -> list[str]:
    """Return where `table` differs from another, called `against`, and draw it."""
    from pyport import steering
    from pyport.steering.grid import describe
    from pyport.steering.grid import picture as draw

    difference = steering.compare(table, old)
    lines = describe(difference)
    answer["against"] = {
        "old": against,
        "points": len(difference.grid),
        **{
            f"{name}_deg": {
                "rms": float((values**2).mean() ** 0.5),
                "largest": float(abs(values).max()),
            }
            for name, values in (
                ("azimuth", difference.az_deg),
                ("azimuth_on_the_sky", difference.on_sky_deg),
                ("zenith_distance", difference.zd_deg),
            )
        },
    }
    if picture:
        draw(difference, picture, f"{table.model} - {old.model or Path(against).name}")
        answer["picture"] = picture
        lines.append(f"picture: {picture}")
    return lines
