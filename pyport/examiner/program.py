"""The program under examination, called through its public API and nothing else."""

from __future__ import annotations

import contextlib
import csv
import functools
import hashlib
import signal
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

#: A file of recordings or its columns, as the public API takes them.
Table = str | Path | Mapping[str, Any]
Header = Mapping[str, float | str]


@dataclass(frozen=True)
class Refused:
    """What the program said of recordings that it could not use."""

    why: str


#: No answer within this time is none. [s]
PATIENCE_S = 300.0


def diagnosed(
    table: Table,
    header: Header | None = None,
    model: str = "altaz",
    patience_s: float = PATIENCE_S,
) -> dict[str, Any] | Refused:
    """Return the report of a diagnosis, as report.json holds it."""
    import pyport
    from pyport.errors import BadInput

    try:
        with _no_longer_than(patience_s):
            return pyport.diagnose(_given(table), model, header=header).report
    except BadInput as error:
        return Refused(str(error))
    except TimeoutError:
        return Refused(f"no answer within {patience_s:.0f} s")


def residuals(
    table: Table, header: Header | None = None, model: str = "altaz"
) -> dict[tuple[int, str], float] | Refused:
    """Return what model and findings leave of each reading [arcsec], by row and "xel" or "el"."""
    import pyport
    from pyport.errors import BadInput

    with tempfile.TemporaryDirectory() as folder:
        try:
            pyport.diagnose(_given(table), model, header=header).save(folder)
        except BadInput as error:
            return Refused(str(error))
        with (Path(folder) / "rows.csv").open(encoding="utf-8", newline="") as file:
            return {
                (int(row["line"]) - 2, row["axis"]): float(row["residual_after_arcsec"])
                for row in csv.DictReader(file)
                if row["residual_after_arcsec"]
            }


def fitted(
    table: Table, header: Header | None = None, model: str = "altaz", weights: str = "robust"
) -> dict[str, Any] | Refused:
    """Return a fit, as fit.json holds it."""
    import pyport
    from pyport.errors import BadInput

    try:
        return pyport.fit(_given(table), model, header=header, weights=weights).report
    except BadInput as error:
        return Refused(str(error))


@contextlib.contextmanager
def _no_longer_than(patience_s: float) -> Iterator[None]:
    """Raise `TimeoutError` after some seconds, where the system can interrupt a thread."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def stop(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, patience_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _given(table: Table) -> Table:
    return str(table) if isinstance(table, Path) else table


@functools.cache
def version() -> str:
    """Return a hash of every source file of the program: another program, other answers."""
    import pyport

    root = Path(pyport.__file__).parent
    text = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        text.update(str(file.relative_to(root)).encode())
        text.update(file.read_bytes())
    return text.hexdigest()[:16]


def shipped(name: str) -> Path:
    """Return the file of recordings that come with the program."""
    import pyport

    return Path(pyport.__file__).parent / "recordings" / "data" / f"{name}.csv"
