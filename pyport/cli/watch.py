"""`pyport watch`: alarms while the telescope observes."""

from __future__ import annotations

import contextlib
import shlex
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import about_file, beside_model, flag, in_json, option
from pyport.errors import BadInput

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pyport.recordings.raw import FileOptions
    from pyport.watch.run import Process
    from pyport.watch.watch import Event, Seen

#: Exit status of --exit-on-alarm.
ALARMED = 3


@click.command(
    "watch", epilog="Example: pyport watch tonight.csv --history past.csv --model altaz --out watch"
)
@click.argument("log", type=click.Path(path_type=Path))
@beside_model
@option(
    "--history",
    "Past recordings to compare with; without, the first ones of LOG.",
    metavar="RECORDINGS",
)
@option(
    "--burn-in",
    "So many at the beginning of LOG stand for the past; ten for each coefficient if not.",
    type=click.IntRange(min=1),
    metavar="POINTINGS",
)
@option(
    "--false-alarm-every rarity",
    "At most one false alarm in so many, on average.",
    10_000,
    type=click.FloatRange(min=1, min_open=True),
    metavar="POINTINGS",
)
@option(
    "--out",
    "Folder of the state, events.jsonl, status.json and metrics.prom.",
    Path("watch"),
    type=click.Path(path_type=Path, file_okay=False),
)
@option(
    "--every every_s",
    "Look at LOG so often.",
    2.0,
    type=click.FloatRange(min=0.05),
    metavar="SECONDS",
)
@flag("--once", "Stop at the end of LOG instead of waiting for more.")
@option(
    "--on-alarm command_line",
    "Run for whatever happens to an alarm; gets it as JSON on standard input.",
    metavar="COMMAND",
    default="",
)
@flag("--exit-on-alarm", "Stop at the first alarm, with exit status 3.")
@flag("--serve served", "Serve a live page.")
@option("--host", "Serve it there.", "127.0.0.1")
@option("--port", "On this port.", 8765, type=click.IntRange(0, 65535))
@about_file
@in_json
def command(
    log: Path,
    model: str,
    history: str | None,
    burn_in: int | None,
    rarity: float,
    out: Path,
    every_s: float,
    command_line: str,
    host: str,
    port: int,
    given: FileOptions,
    *,
    as_json: bool,
    once: bool,
    exit_on_alarm: bool,
    served: bool,
) -> None:
    """Watch LOG, a file of recordings that grows or a folder of them, and raise alarms.

    Each new pointing is compared with what the model and the noise of the past let expect. An
    alarm says what changed, since when, how large, how sure and what to do next; events are
    printed, with --json as JSON lines. Called again after a kill, it goes on where it was.
    """
    from pyport.watch.run import Options, Process, alone, forever
    from pyport.watch.state import line, words

    def say(event: Event) -> None:
        click.echo(line(event) if as_json else words(event))

    if no_command := _no_command(command_line):
        click.echo(f"warning: --on-alarm: {no_command}, events are printed only", err=True)
    options = Options(log, model, out, given, history, burn_in, rarity, command_line)
    with alone(out):
        process = Process(options, say, lambda text: click.echo(text, err=True))
        with _page(process, host, port) if served else contextlib.nullcontext():
            seen = process.step() if once else forever(process, every_s)
            with contextlib.closing(process):
                alarmed = _through(seen, stop=exit_on_alarm)
        if once:
            if process.watch is not None and not process.watch.row and process.left_out:
                reason, _ = process.left_out.most_common(1)[0]
                wrong = f"none of {process.left_out.total()} rows can be read, most: {reason}"
                raise BadInput(wrong, log)
            click.echo(f"{log}: {_so_far(process)}", err=True)
    if alarmed and exit_on_alarm:
        click.get_current_context().exit(ALARMED)


def _no_command(words: str) -> str:
    """Say that there is no such command, "" where there is: before the night, not in it.

    Raises `BadInput`: a quotation has no end.
    """
    try:
        program = shlex.split(words)[:1]
    except ValueError as error:
        raise BadInput(f"--on-alarm {words!r}: {error}, expected a command") from None
    return "" if not program or shutil.which(program[0]) else f"no command {program[0]!r}"


def _so_far(process: Process) -> str:
    """Return how much was watched, and how many alarms stand."""
    if process.watch is None:
        return f"fewer than {process.needed} recordings to begin with: give --history"
    alarms = len(process.watch.standing)
    stand = f"{alarms} alarm{'s stand' if alarms > 1 else ' stands'}" if alarms else "no alarm"
    return f"{process.watch.row} pointings read, {stand}"


@contextlib.contextmanager
def _page(process: Process, host: str, port: int) -> Iterator[None]:
    """Serve the page of a watch, and show on it whatever the watch keeps."""
    from pyport.watch.live import live
    from pyport.watch.serve import Live, serve

    shown = Live()
    process.show = lambda watch: shown.show(live(watch))
    if process.watch is not None:
        process.show(process.watch)
    page = serve(shown, host, port)
    click.echo(f"serving {page.address}", err=True)
    try:
        yield
    finally:
        page.stop()


def _through(seen: Iterator[Seen], *, stop: bool) -> bool:
    """Go through what comes; tell whether an alarm was raised, at once if `stop`."""
    alarmed = False
    for one in seen:
        alarmed |= any(event.event == "raised" for event in one.events)
        if alarmed and stop:
            break
    return alarmed
