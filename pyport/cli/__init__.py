"""The command line: parse, call, print. One file a command, loaded when it is called."""

from __future__ import annotations

import importlib
import os
import sys

import click

from pyport import __version__
from pyport.cli.manners import STATUSES, with_quiet
from pyport.errors import BadInput

#: Command -> the sentence that `pyport --help` shows without importing it.
COMMANDS = {
    "apply": "Apply a model: offsets for targets, where to drive, and back to the sky.",
    "array": "Take the GMRT's recordings apart as those of one array; compare with a survey.",
    "compare": "Compare two models over the sky and on recordings, before the mount gets one.",
    "completion": "Print what a shell needs to complete commands, options and names.",
    "convert": "Convert recordings and pointing models between programs' formats.",
    "demo": "Show everything once: parity, the steering table, a diagnosis of real recordings.",
    "dev": "Hold the program to its targets on drawn and public recordings.",
    "detective": "Measure the detective: real recordings, the RT32's jump, drawn cases.",
    "diagnose": "Find, name and model what a pointing model leaves out of recordings.",
    "effects": "List the physical effects that a diagnosis may name, and what each one needs.",
    "field-system": "Compare with the VLBI Field System on its own outputs.",
    "fit": "Fit a pointing model to recordings.",
    "gmrt": "Repeat the GMRT paper's analysis on its own tables.",
    "look": "Tell what recordings could show, and what to observe next, before fitting.",
    "lookup": "Answer offsets at an azimuth and zenith distance from a steering table.",
    "mask": "Mask recordings of a file, kept beside it and undone step by step.",
    "offsets": "Measure pointing offsets in scans across a source.",
    "parity": "Hold Python ports to the Fortran they were made from, to the last bit.",
    "plot": "Draw the panels of a diagnosis or fit as PDF, PNG or SVG for print.",
    "predict": "Compare models by how they predict recordings that they were not fitted to.",
    "reduction": "Take nutation, aberration, UT1, ... out of offsets; print how large they are.",
    "rt32": "Repeat the RT32 document's fit and figures, on a simulated campaign or your own.",
    "table": "Write the steering table of a pointing model.",
    "trials": "Put causes into simulated recordings, and check whether a diagnosis finds them.",
    "verify": "Tell whether the files of a diagnosis are all of one run.",
}


class Lazy(click.Group):
    """A group that imports a command's module only when the command is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click's signature
        """Return the names of all commands."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:  # noqa: ARG002
        """Import `pyport.cli.NAME` and return its `command`."""
        if name not in COMMANDS:
            return None
        module = name.replace("-", "_")
        return with_quiet(importlib.import_module(f"pyport.cli.{module}").command)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """List the commands from the table above, importing none."""
        with formatter.section("Commands"):
            formatter.write_dl(sorted(COMMANDS.items()))


@click.group(
    cls=Lazy,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=STATUSES,
)
@click.version_option(__version__, prog_name="pyport")
def pyport() -> None:
    """Pointing models of radio telescopes: ported, tabulated, and their gaps explained."""


def main() -> None:
    """Run the command line; bad input is one line on standard error and exit status 2."""
    # The matrices here are small: threads of the linear algebra cost more than they bring.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        _refuse_what_is_no_text(sys.argv[1:])
        status = pyport.main(
            prog_name="pyport", standalone_mode=False, complete_var="_PYPORT_COMPLETE"
        )
    except (BadInput, click.ClickException) as error:
        text = error.format_message() if isinstance(error, click.ClickException) else str(error)
        click.echo(f"pyport: error: {' '.join(text.split())}", err=True)
        sys.exit(2)
    except click.Abort:
        click.echo("pyport: interrupted", err=True)
        sys.exit(130)
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        click.echo(f"pyport: error: {place}{error.strerror or error}", err=True)
        sys.exit(2)
    sys.exit(status if isinstance(status, int) else 0)


def _refuse_what_is_no_text(words: list[str]) -> None:
    """Refuse names of files that no report could spell."""
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            wrong = f"{word!r} is no UTF-8 text, expected a name that is: rename the file"
            raise BadInput(wrong) from None
