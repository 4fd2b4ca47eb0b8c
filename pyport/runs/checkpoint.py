"""How far a long run has come, kept in a file until its output is written.

A run that is killed and called again with the same input reads the file and
goes on. What is kept is the running state itself, every number as it was, so
that the end is the same to the last digit. It belongs to the program, the
libraries and the input that made it: for any other it is as if it were not there.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import time
import zipfile
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.files import tree, write_whole

#: What is known of a state, as JSON holds it, and its arrays.
State = tuple[dict[str, Any], Mapping[str, NDArray[Any]]]

#: Runs shorter than this leave nothing behind; no more than this is lost, or a twentieth. [s]
LEAST_S = 1.0
#: Keeping the state takes no more than one part in so many of the time.
SPARING = 20
_TEXT, _KEY = "told", "key"
_LIBRARIES = ("numpy", "pyarrow")


class Checkpoint:
    """The state of one run, kept under a key.

    `path`: the file; None where nothing is to be kept.
    `what`: whatever the result depends on, as JSON holds it.
    """

    def __init__(self, path: Path | None, *what: object):
        self.path = path
        self.key = "" if path is None else key_of(*what)
        self._begun = self._last = time.monotonic()
        self._cost = 0.0

    def load(self) -> State | None:
        """Return the state that a run with the same key left; None where there is none."""
        if self.path is None or not self.path.is_file():
            return None
        try:
            with np.load(self.path, allow_pickle=False) as kept:
                if str(kept[_KEY]) != self.key:
                    return None
                arrays = {name: kept[name] for name in kept.files if name not in {_KEY, _TEXT}}
                return json.loads(str(kept[_TEXT])), arrays
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None

    def offer(self, state: Callable[[], State]) -> None:
        """Keep a state when enough time has passed since the last one was."""
        if time.monotonic() - self._last > max(LEAST_S, SPARING * self._cost):
            self.save(state)

    def close(self, state: Callable[[], State]) -> None:
        """Keep the last state, unless it came about too soon to be worth it."""
        if time.monotonic() - self._begun > LEAST_S:
            self.save(state)

    def save(self, state: Callable[[], State]) -> None:
        """Keep a state, whole or not at all; where it cannot be kept the run goes on without."""
        if self.path is None:
            return
        started = time.monotonic()
        known, arrays = state()
        with contextlib.suppress(OSError), write_whole(self.path, "wb") as file:
            texts: dict[str, Any] = {_KEY: np.array(self.key), _TEXT: np.array(json.dumps(known))}
            np.savez(file, **(texts | dict(arrays)))
        self._last = time.monotonic()
        self._cost = self._last - started


def key_of(*what: object) -> str:
    """Return the hash of the program, its libraries and whatever else a result depends on."""
    libraries = {name: version(name) for name in _LIBRARIES}
    text = json.dumps([_program(), libraries, *what], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


@functools.cache
def _program() -> str:
    return tree(Path(__file__).parents[1])


def cache_folder() -> Path:
    """Return where states are kept of runs that have no file to write."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "pyport"
