"""A fault of the program: one line on the terminal, and a file that can be sent to its makers."""

from __future__ import annotations

import platform
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from pyport import __version__
from pyport.files import write_whole

#: EX_SOFTWARE of sysexits.h: an internal error, whatever the input was.
STATUS = 70

_LIBRARIES = ("numpy", "scipy", "astropy", "pyerfa", "pyarrow", "matplotlib", "click")


def keep(error: BaseException, words: Sequence[str]) -> str:
    """Write what is needed to find a fault; return the line for the terminal.

    The file holds the command, the traceback and the versions, and nothing of the recordings. It
    goes to the current folder, or to the temporary one where that cannot be written.
    """
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
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
