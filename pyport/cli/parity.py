"""`pyport parity`: hold ports to the Fortran they were made from and say how far apart they are."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pyport.cli.manners import FILE, flag, in_json, option, say

if TYPE_CHECKING:
    from pyport.parity.described.description import Description

_CONFIG = option(
    "--config", "A parity.toml; that of the RT32's published routines by default.", type=FILE
)


def _described(config: Path | None) -> Description:
    """Read the description named by a command or by `pyport parity` before it."""
    from pyport.legacy import PARITY
    from pyport.parity.described.loading import load

    parent = click.get_current_context().parent
    before = parent.params.get("config") if parent is not None else None
    return load(config or before or PARITY)


@click.group(
    "parity",
    invoke_without_command=True,
    epilog="Exit status: 0 when every promise is kept, 1 when one is broken, 2 for bad input. "
    "Example: pyport parity --config parity.toml --points 100000 --report PARITY.md",
)
@_CONFIG
@option(
    "--points",
    "Random points, beside the edges and the description's own (with a compiler).",
    20_000,
    type=click.IntRange(min=0),
)
@option("--seed", "Seed of the random points.", 0)
@option("--jobs", "Processes; all cores by default.")
@flag("--stored", "Ask the stored answers even where a compiler is.")
@option("--report", "Write a page of Markdown here.", type=click.Path(dir_okay=False))
@option(
    "--summary",
    "Append a short summary in Markdown here, such as to $GITHUB_STEP_SUMMARY.",
    type=click.Path(dir_okay=False),
)
@flag("--json as_json", "Print JSON instead of text.")
@click.pass_context
def command(
    context: click.Context,
    config: Path | None,
    points: int,
    seed: int,
    jobs: int | None,
    stored: bool,  # noqa: FBT001 - click passes flags by keyword
    report: str | None,
    summary: str | None,
    as_json: bool,  # noqa: FBT001
) -> None:
    """Compare Python ports with the Fortran that a parity.toml describes, to the last bit.

    With gfortran the routines are compiled, wrapped by f2py and asked anew at every point; without
    it the ports are held to their stored answers. Killed and called again in the same words it
    goes on.
    """
    if context.invoked_subcommand is not None:
        return
    from pyport.files import write_file
    from pyport.parity import report as reporting
    from pyport.parity.document import document
    from pyport.parity.run import kept_beside, run

    description = _described(config)
    kept = kept_beside(report, description, points, seed)
    parity = run(description, points, seed, jobs, live=not stored, kept_in=kept)
    if report:
        write_file(report, document(parity))
    if summary:
        with Path(summary).open("a", encoding="utf-8") as file:
            file.write(reporting.markdown(parity))
    if as_json:
        click.echo(json.dumps(reporting.as_json(parity), indent=1))
    else:
        click.echo(reporting.text(parity), nl=False)
    kept.unlink(missing_ok=True)
    if not parity.promise_kept:
        context.exit(1)


@command.command("golden", epilog="Example: pyport parity golden --config parity.toml")
@_CONFIG
@in_json
def golden(config: Path | None, *, as_json: bool) -> None:
    """Write the oracle's answers beside the description, for machines without a compiler.

    A file whose numbers stay the same is left alone.
    """
    from pyport.errors import BadInput
    from pyport.parity.compiled import oracle, stored

    description = _described(config)
    if not oracle.available(description):
        raise BadInput(
            "no gfortran, C compiler or Python.h, or no Fortran files: expected all of them",
            description.path,
        )
    oracles = {name: oracle.of(description.path, name) for name in description.builds}
    written = {
        stored.path_of(description, group, routine).name: stored.write(
            description, group, routine, oracles
        )
        for group in description.groups
        for routine in description.routines
    }
    lines = [f"{name}: {'rewritten' if new else 'unchanged'}" for name, new in written.items()]
    say("\n".join(lines), written, as_json=as_json)


def _keep(description: Description, name: str, content: dict[str, Any]) -> None:
    """Write what a long check found beside the stored answers; the report shows it."""
    from pyport.files import write_file
    from pyport.parity.compiled.stored import one_row_a_line

    write_file(description.answers / f"{name}.json", one_row_a_line(content))


@command.command("matrix", epilog="Example: pyport parity matrix --config parity.toml")
@_CONFIG
@click.option("--points", type=click.IntRange(min=0), default=100_000, show_default=True)
@in_json
def matrix(config: Path | None, points: int, *, as_json: bool) -> None:
    """Compare builds with other flags and compilers with the reference."""
    from pyport.parity.evidence import coverage as builds

    description = _described(config)
    if not description.matrix:
        raise click.UsageError("no builds to compare: expected `matrix` in [fortran]")
    content = builds.matrix(description, points)
    say(builds.show_matrix(content), content, as_json=as_json)
    _keep(description, "matrix", content)


@command.command("mutants", epilog="Example: pyport parity mutants --config parity.toml")
@_CONFIG
@click.option("--points", type=click.IntRange(min=0), default=100_000, show_default=True)
@option(
    "--fortran",
    "Mutants of the Fortran, where the description names none.",
    40,
    type=click.IntRange(min=0),
)
@in_json
@click.pass_context
def mutants(
    context: click.Context, config: Path | None, points: int, fortran: int, *, as_json: bool
) -> None:
    """Break port and Fortran in every small way; exit 1 when one is not noticed or explained."""
    from pyport.parity.evidence import mutants as making

    description = _described(config)
    content = making.mutate(description, points, fortran)
    say(making.show(content), content, as_json=as_json)
    _keep(description, "mutants", {k: v for k, v in content.items() if k != "outdated"})
    if not making.complete(content):
        context.exit(1)


@command.command("coverage", epilog="Example: pyport parity coverage --config parity.toml")
@_CONFIG
@click.option("--points", type=click.IntRange(min=0), default=20_000, show_default=True)
@in_json
@click.pass_context
def coverage(context: click.Context, config: Path | None, points: int, *, as_json: bool) -> None:
    """Count the branches of the Fortran that the inputs take; exit 1 when one is never taken."""
    from pyport.parity.evidence import coverage as counting

    description = _described(config)
    content = counting.coverage(description, points)
    say(counting.show(content), content, as_json=as_json)
    _keep(description, "coverage", {k: v for k, v in content.items() if k != "never_reached"})
    if not counting.complete(content):
        context.exit(1)


@command.command("init", epilog="Example: pyport parity init refraction.f --out parity.toml")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@option("-o --out", "The description to write.", "parity.toml", type=FILE)
@option("--routine routines", "Only this routine; may be repeated.", multiple=True)
@flag("--force", "Write over a description that is there.")
@in_json
def init(
    files: tuple[Path, ...], out: Path, routines: tuple[str, ...], *, force: bool, as_json: bool
) -> None:
    """Write a first parity.toml from Fortran FILES; what they do not say is marked with a ?."""
    from pyport.errors import BadInput
    from pyport.files import write_file
    from pyport.parity.described.init import described

    if out.exists() and not force:
        raise BadInput("is there already: --force writes over it", out)
    text = described(list(files), out, routines)
    write_file(out, text)
    marks = sum("?" in line for line in text.splitlines() if not line.startswith("# "))
    n = text.count("[[routine]]")
    left_out = [line[2:] for line in text.splitlines() if " is left out: " in line]
    answer = {"file": out, "routines": n, "marked": marks, "left_out": left_out}
    head = f"{out}: {n} routine{'s' * (n != 1)}, {marks} lines marked with ?"
    say("\n".join([head, *left_out]), answer, as_json=as_json)
