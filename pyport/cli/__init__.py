"""The command line: parse, call, print. `study` and `dev` are groups of their own."""

from __future__ import annotations

import atexit
import gc
import io
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import click

from pyport import __version__
from pyport.cli.manners import STATUSES, Lazy
from pyport.errors import BadInput

#: Command -> the sentence that `pyport --help` shows without importing it.
COMMANDS = {
    "apply": "Apply a model: offsets for targets, where to drive, and back to the sky.",
    "compare": "Compare two models over the sky and on recordings, before the mount gets one.",
    "completion": "Print what a shell needs to complete commands, options and names.",
    "convert": "Convert recordings and pointing models between programs' formats.",
    "demo": "Show everything once: parity, the steering table, a diagnosis of real recordings.",
    "dev": "Check the program: its catalogue, its promises, its answers to simulated recordings.",
    "diagnose": "Find, name and model what a pointing model leaves out of recordings.",
    "fit": "Fit a pointing model to recordings.",
    "look": "Show what recordings can distinguish, and what to observe next, before fitting.",
    "lookup": "Read offsets at an azimuth and zenith distance from a steering table.",
    "mask": "Exclude recordings of a file; kept beside it and undone step by step.",
    "offsets": "Measure pointing offsets in scans across a source.",
    "parity": "Compare Python ports with the Fortran they were made from, to the last bit.",
    "plot": "Draw the panels of a diagnosis or fit as PDF, PNG or SVG for print.",
    "predict": "Compare models by how they predict recordings that they were not fitted to.",
    "study": "Repeat the analyses of the two documents that the program began with.",
    "table": "Write the steering table of a pointing model.",
    "targets": "List what to observe next, as a telescope reads it, within limits and time.",
    "watch": "Watch recordings come in all night; raise alarms with a stated false-alarm rate.",
}

#: Names of version 0.1, which work for one version more.
FORMER = {
    "array": "study gmrt-array",
    "detective": "dev acceptance",
    "effects": "dev effects",
    "field-system": "dev field-system",
    "gmrt": "study gmrt",
    "reduction": "dev reduction",
    "rt32": "study rt32",
    "trials": "dev trials",
    "verify": "dev verify",
}


#: EX_SOFTWARE of sysexits.h: an internal error, whatever the input was.
FAULT = 70

_LIBRARIES = ("numpy", "scipy", "astropy", "pyerfa", "pyarrow", "matplotlib", "click")


def _print_version(context: click.Context, _: click.Parameter, wanted: bool) -> None:  # noqa: FBT001 - click's signature
    if wanted and not context.resilient_parsing:
        from pyport.pointing import kernel

        click.echo(f"pyport, version {__version__}, computing with {kernel.path()}")
        context.exit()


pyport = click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_print_version,
    help="Show the version and what computes, numpy or the compiled kernel.",
)(
    Lazy(
        "pyport",
        "pyport.cli",
        COMMANDS,
        FORMER,
        {
            "correct": "apply compare convert",
            "explain": "diagnose plot predict",
            "files": "completion lookup mask offsets",
            "observe": "look targets",
        },
        help="Pointing models of radio telescopes: ported, tabulated, and their gaps explained.",
        epilog=STATUSES,
    )
)


def main() -> None:
    """Run the command line; what goes wrong is one line on standard error.

    Exit status 2 for bad input, 70 for a fault of the program, 130 when interrupted.
    """
    # The matrices here are small: threads of the linear algebra cost more than they bring.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Libraries make cycles that stay, pictures some that do not: of so many objects the collector
    # goes through a few pictures' at a time, not through the libraries while they are imported.
    gc.set_threshold(300_000)
    # At the end the system takes all of it at once.
    atexit.register(gc.freeze)
    _write_whole_to_standard_output()
    try:
        _refuse_what_is_no_text(sys.argv[1:])
        status = pyport.main(
            prog_name="pyport", standalone_mode=False, complete_var="_PYPORT_COMPLETE"
        )
    except (BadInput, click.ClickException) as error:
        text = error.format_message() if isinstance(error, click.ClickException) else str(error)
        click.echo(f"pyport: error: {' '.join(text.split())}", err=True)
        sys.exit(2)
    except click.Abort as error:
        if isinstance(error.__cause__, EOFError):  # click takes it for a key
            _end_with_fault(error.__cause__)
        click.echo("pyport: interrupted", err=True)
        sys.exit(130)
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        click.echo(f"pyport: error: {place}{error.strerror or error}", err=True)
        _drop_standard_output()
        sys.exit(2)
    except Exception as error:  # noqa: BLE001 - whatever it is, a traceback helps no user
        _end_with_fault(error)
    sys.exit(status if isinstance(status, int) else 0)


def _write_whole_to_standard_output() -> None:
    """Buffer a standard output that has no buffer, as PYTHONUNBUFFERED leaves it in containers.

    Without one Python passes over what the system did not take, such as all but the first 8 kB on
    a disk that is full then; with one it asks again, and the disk is said to be full.
    """
    now = sys.__stdout__
    if now is None or now is not sys.stdout:
        return
    if isinstance(now.buffer, io.RawIOBase):
        sys.stdout = open(  # noqa: SIM115 - until the program ends
            now.fileno(),
            "w",
            encoding=now.encoding,
            errors=now.errors,
            buffering=1,
            closefd=False,
        )


def _drop_standard_output() -> None:
    """Drop what a full disk did not take: written again at the end it would be status 120."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _end_with_fault(error: BaseException) -> NoReturn:
    click.echo(_kept(error, sys.argv[1:]), err=True)
    sys.exit(FAULT)


def _kept(error: BaseException, words: Sequence[str]) -> str:
    """Write what is needed to find a fault; return the line for the terminal.

    The file holds the command, the traceback and the versions, and nothing of the recordings. It
    goes to the current folder, or to the temporary one where that cannot be written.
    """
    import platform
    import shlex
    import tempfile
    import traceback
    from datetime import UTC, datetime

    from pyport.files import write_whole

    at = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(at[-1].filename).name}:{at[-1].lineno})" if at else ""
    what = " ".join(f"{type(error).__name__}{place}: {error}".split())[:300]
    now = datetime.now(UTC)
    lines = [
        f"pyport {__version__}, {now:%Y-%m-%d %H:%M:%S} UTC",
        f"command: {shlex.join(['pyport', *words])}",
        f"Python {sys.version}",
        f"machine: {platform.platform()}",
        *(f"{name} {_version(name)}" for name in _LIBRARIES),
        "",
        "".join(traceback.format_exception(error)),
    ]
    text = "\n".join(lines)
    for folder in (Path(), Path(tempfile.gettempdir())):
        path = folder / f"pyport-fault-{now:%Y%m%d-%H%M%S-%f}.txt"
        try:
            with write_whole(path) as file:
                file.write(text.encode("utf-8", "replace").decode())
        except OSError:
            continue
        return f"pyport: fault of the program: {what}; please send {path} to its makers"
    return f"pyport: fault of the program: {what}; no report could be written"


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _refuse_what_is_no_text(words: list[str]) -> None:
    """Refuse names of files that no report could spell."""
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            wrong = f"{word!r} is no UTF-8 text, expected a name that is: rename the file"
            raise BadInput(wrong) from None
