"""What every command shares: --quiet, --json, completion of names."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

#: Exit statuses, as `pyport --help` tells them.
STATUSES = (
    "Exit status: 0 when the job was done, whatever it found (1 when parity breaks a promise); 2 "
    "for bad input, with one line on standard error; 70 for a fault of the program, with a report "
    "to send; 130 when interrupted."
)


def in_json(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--json` (as `as_json`) to a command."""
    return click.option("--json", "as_json", is_flag=True, help="Print JSON.")(command)


def resumable(folder: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return what adds `--out` to a long command: where its results so far are, `folder` if not."""
    return click.option(
        "--out",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path(folder),
        show_default=True,
        help="Folder of the results so far; an interrupted run continues there.",
    )


def counted(outcomes: Iterable[dict[str, Any]], total: int) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of a long command's cases; on a terminal say how many are there."""
    for done, one in enumerate(outcomes, 1):
        yield one
        if sys.stderr.isatty():
            click.echo(f"\r{done} of {total} cases", err=True, nl=done == total)


def say(text: str | Callable[[], str], told: object, *, as_json: bool) -> None:
    """Print an answer: as text, or what `told` holds as JSON."""
    if as_json:
        click.echo(json.dumps(plain(told), indent=1, allow_nan=False))
    else:
        click.echo(text if isinstance(text, str) else text())


def plain(value: object) -> Any:  # noqa: ANN401 - whatever JSON holds
    """Return a value as JSON can spell it: dataclasses as dictionaries, no NaN, no infinity."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {one.name: getattr(value, one.name) for one in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def with_quiet(command: click.Command) -> click.Command:
    """Return a command with `--quiet`, added where it and its own commands have none."""
    if isinstance(command, click.Group):
        for one in command.commands.values():
            with_quiet(one)
    calls = not isinstance(command, click.Group) or command.invoke_without_command
    if calls and not any(parameter.name == "quiet" for parameter in command.params):
        command.params.append(
            click.Option(
                ["--quiet"],
                is_flag=True,
                expose_value=False,
                callback=_hush,
                help="Print nothing but errors.",
            )
        )
    return command


def _hush(context: click.Context, _: click.Parameter, quiet: bool) -> None:  # noqa: FBT001 - click's
    """Let what the command prints go nowhere."""
    if quiet:
        context.with_resource(contextlib.redirect_stdout(io.StringIO()))


def models(_: click.Context, __: click.Parameter, typed: str) -> list[CompletionItem]:
    """Complete the name of a built-in model, or of a file."""
    from pyport.models.model import BUILT_IN

    return _completed(sorted(BUILT_IN), typed)


def recordings(_: click.Context, __: click.Parameter, typed: str) -> list[CompletionItem]:
    """Complete the name of recordings shipped with pyport, or of a file."""
    from pyport.recordings.files import NAMES

    return _completed(sorted(NAMES), typed)


def effects(_: click.Context, __: click.Parameter, typed: str) -> list[CompletionItem]:
    """Complete the id of an effect."""
    from pyport.effects import CATALOGUE

    return [CompletionItem(name) for name in CATALOGUE if name.startswith(typed)]


def _completed(names: list[str], typed: str) -> list[CompletionItem]:
    found = [CompletionItem(name) for name in names if name.startswith(typed)]
    return [*found, CompletionItem(typed, type="file")]


#: The model beside which recordings are looked at.
beside_model = click.option(
    "--model",
    default="altaz",
    show_default=True,
    shell_complete=models,
    help="A built-in model or a file.",
)
#: How rare the watch's false alarms are to be, where it is examined.
as_promised = click.option(
    "--false-alarm-every",
    "rarity",
    default=10_000.0,
    show_default=True,
    metavar="POINTINGS",
    help="What the watch promises.",
)
