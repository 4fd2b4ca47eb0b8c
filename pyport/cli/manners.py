"""What commands share: --quiet, --json, completion of names, options on a file of recordings."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import importlib
import io
import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from pyport.errors import BadInput

#: Where a command's context says that --quiet was given.
_HUSHED = "pyport.quiet"
#: Exit statuses, as `pyport --help` tells them.
STATUSES = (
    "Exit status: 0 when the job was done, whatever it found (1 when parity breaks a promise, 3 "
    "when an alarm ended --exit-on-alarm); 2 for bad input, with one line on standard error; 70 "
    "for a fault of the program, with a report to send; 130 when interrupted."
)


PATH = click.Path(path_type=Path)
FILE = click.Path(path_type=Path, dir_okay=False)


def option(
    names: str,
    says: str,
    default: object = None,
    *,
    of: str = "",
    **settings: Any,  # noqa: ANN401 - click's
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return click's option of some names; help shows its default, `of` are all it may be.

    Jobs, cases and seeds are counted.
    """
    if of:
        settings["type"] = click.Choice(of.split())
    if names in ("--jobs", "--cases", "--seed"):
        settings["type"] = click.IntRange(min=0 if names == "--seed" else 1)
    if default is not None:
        settings = {"show_default": default != ""} | settings | {"default": default}
    return click.option(*names.split(), help=says, **settings)


def flag(names: str, says: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return click's option that is given or not."""
    return click.option(*names.split(), is_flag=True, help=says)


def in_json(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--json` (as `as_json`) to a command."""
    return flag("--json as_json", "Print JSON.")(command)


def resumable(folder: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return what adds `--out` to a long command: where its results so far are, `folder` if not."""
    return option(
        "--out",
        "Folder of the results so far; an interrupted run continues there.",
        Path(folder),
        type=click.Path(path_type=Path, file_okay=False),
    )


def counted(outcomes: Iterable[dict[str, Any]], total: int) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of a long command's cases; on a terminal say how many are there."""
    shown = sys.stderr.isatty() and _HUSHED not in click.get_current_context().meta
    for done, one in enumerate(outcomes, 1):
        yield one
        if shown:
            click.echo(f"\r{done} of {total} cases", err=True, nl=done == total)


def say(
    text: str | Callable[[], str], answer: object, *, as_json: bool, file: Path | None = None
) -> None:
    """Print an answer as text, or as JSON what `answer` holds; in `file` too.

    Both may be functions that make it.
    """
    if as_json or file is not None:
        answer = answer() if callable(answer) else answer
        whole = json.dumps(plain(answer), indent=1, allow_nan=False)
    if file is not None:
        from pyport.files import write_file

        write_file(file, whole + "\n")
    click.echo(whole if as_json else text if isinstance(text, str) else text())


def warn(text: str) -> None:
    """Print a line on standard error, beside an answer; nothing with `--quiet`."""
    if _HUSHED not in click.get_current_context().meta:
        click.echo(text, err=True)


def refuse_without_columns(out: Path | None) -> None:
    """Refuse to write to a format of stars, which has no place for further columns.

    Raises `BadInput`: `out` is TPOINT's or the Field System's by its suffix.
    """
    if out is not None and out.suffix.lower() in (".dat", ".xtr"):
        wrong = f"{out.suffix} has no place for these columns, expected .csv, .ecsv or .parquet"
        raise BadInput(wrong, out)


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
        context.meta[_HUSHED] = True
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


#: How many cases a command works at.
many_jobs = option("--jobs", "Cases at the same time.", 1)
#: The model that is fitted to recordings, or beside which they are looked at.
beside_model = option("--model", "A built-in model or a file.", "altaz", shell_complete=models)
#: How rare the watch's false alarms are to be, where it is examined.
as_promised = option(
    "--false-alarm-every rarity", "What the watch promises.", 10_000.0, metavar="POINTINGS"
)


def _pairs(_: click.Context, option: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Return KEY=VALUE arguments as a dictionary."""
    pairs = {}
    for one in given:
        key, equals, value = one.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise click.BadParameter(f"{one!r}, expected KEY=VALUE", param=option)
        pairs[key.strip()] = value.strip()
    return pairs


def _columns(
    _: click.Context, __: click.Parameter, given: str | None
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return names that commas separate, and the map of columns that stands in their place."""
    if given is None:
        return (), {}
    if "=" in given or given.endswith(".toml") or given.strip() == "...":
        from pyport.recordings.formats.mapped import parse

        return (), parse(given)
    return tuple(name.strip() for name in given.split(",")), {}


def about_file(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add options on a file of recordings; the command gets them as `given`, a `FileOptions`."""

    @functools.wraps(command)
    def bundled(
        about: dict[str, str],
        columns: tuple[tuple[str, ...], dict[str, str]],
        read_as: str,
        where: str,
        mount: str | None,
        **others: Any,  # noqa: ANN401 - whatever the command takes
    ) -> Any:  # noqa: ANN401 - whatever the command returns
        from pyport.recordings.raw import FileOptions

        names, mapping = columns
        if mount is not None:
            about = about | {"mount": mount}
        return command(given=FileOptions(about, names, read_as, where, mapping), **others)

    for add in reversed(_OPTIONS):
        bundled = add(bundled)
    return bundled


_OPTIONS = (
    option(
        "--set about",
        "A header key that the file lacks, such as latitude_deg=53.0955; repeat for more.",
        multiple=True,
        callback=_pairs,
        metavar="KEY=VALUE",
    ),
    option(
        "--columns",
        "Columns by other names: 'az_deg=AZd, d_el_arcsec=-dEl, session=id|date', by number "
        "(az_deg=8), ... for all others as they are called; or a MAP.toml of `pyport look`; or "
        "NAME,NAME for a CSV without a header.",
        callback=_columns,
        metavar="MAP",
    ),
    option(
        "--from read_as",
        "The file's format, where its suffix does not say it: see `pyport convert`.",
        metavar="FORMAT",
        default="",
    ),
    option(
        "--mount",
        "What the mount is: wheel-and-track, bearing, ...; as '# mount:' in the file.",
        metavar="KIND,KIND",
    ),
    option(
        "--where",
        'Use only these: --where "wind_speed_m_s < 5 and sun_el_deg < 0".',
        metavar="EXPRESSION",
        default="",
    ),
)


class Lazy(click.Group):
    """A group that imports a command's module only when the command is asked for.

    `name`: the group's name on the command line.
    `package`: the package whose modules define a `command` each, or several by their names.
    `sentences`: command -> the sentence that `--help` shows without importing it.
    `former`: name of a former version -> the words that stand for it now.
    `shared`: module -> the commands that it defines by their names.
    """

    def __init__(
        self,
        name: str,
        package: str,
        sentences: Mapping[str, str],
        former: Mapping[str, str] | None = None,
        shared: Mapping[str, str] | None = None,
        **attributes: Any,  # noqa: ANN401 - click's
    ) -> None:
        settings = {"help_option_names": ["-h", "--help"]}
        super().__init__(name, context_settings=settings, **attributes)
        self.package = package
        self.sentences = dict(sorted(sentences.items()))
        self.former = former or {}
        self.shared = {
            one: module for module, some in (shared or {}).items() for one in some.split()
        }

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click's signature
        """Return the names of all commands."""
        return list(self.sentences)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import the module of a command and return its `command`."""
        if name in self.former:
            return self._former(ctx, name)
        if name not in self.sentences:
            return None
        spelled = name.replace("-", "_")
        module = importlib.import_module(f"{self.package}.{self.shared.get(name, spelled)}")
        return with_quiet(getattr(module, spelled if name in self.shared else "command"))

    def _former(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return the command that a former name stands for; its new name goes to standard error."""
        *groups, last = self.former[name].split()
        command: click.Command | None = self
        for word in (*groups, last):
            command = command.get_command(ctx, word) if isinstance(command, click.Group) else None
        if not ctx.resilient_parsing:
            click.echo(f"pyport: `pyport {name}` is `pyport {self.former[name]}` now", err=True)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """List the commands, importing none."""
        with formatter.section("Commands"):
            formatter.write_dl(list(self.sentences.items()))
