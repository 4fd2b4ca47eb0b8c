"""The state of a watch, kept whole after every pointing, and taken up again."""

from __future__ import annotations

import hashlib
import json
import tokenize
import zipfile
import zlib
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.checkpoint import key_of
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.watch.alarms import Alarm
from pyport.watch.antenna import Antenna, Slot
from pyport.watch.composite import Composite
from pyport.watch.detector import Detector
from pyport.watch.null import Null
from pyport.watch.watch import Event, Seen, Watch

#: What reading an archive raises that is none, or is spoilt.
_NO_ARCHIVE = (zipfile.BadZipFile, zlib.error, NotImplementedError, tokenize.TokenError)
_TOLD, _KEY = "told", "key"
_OF_WATCH = ("row", "raised", "happened", "last", "session")
#: What is kept of each part of an antenna's watch.
_KEPT: dict[type, tuple[str, ...]] = {
    Antenna: ("pending", "rows", "unchanged_mean", "unchanged_covariance"),
    Composite: ("log_weight", "log_ratio", "nights"),
    Null: tuple(one.name for one in fields(Null)),
    Detector: tuple(one.name for one in fields(Detector)),
}


def _parts(own: Antenna) -> dict[str, Any]:
    """Return the parts of an antenna's watch that change, by name."""
    found: dict[str, Any] = {"antenna": own, "nulls": own.nulls, "detector": own.detector}
    for k, level in enumerate(own.nulls.levels):
        found |= {f"null {k}": level.null, f"standing {k}": level.standing}
    return found


def key(watch: Watch) -> str:
    """Return the hash of the program, the past and the model: of what a state belongs to."""
    past = hashlib.sha256()
    history = watch.history
    if watch.key:
        return watch.key
    for one in (history.at.az, history.at.el, history.x, history.y, history.line):
        past.update(np.ascontiguousarray(one).tobytes())
    for name in sorted(history.at.columns):
        past.update(repr((name, history.at.columns[name].tolist())).encode())
    model = [
        (term.effect.id, term.effect.variant, term.per, term.values, sorted(term.by.items()))
        for term in watch.model.terms
    ]
    rarity = watch.pointings_per_false_alarm
    watch.key = key_of(past.hexdigest(), watch.model.name, repr(model), rarity)
    return watch.key


def save(watch: Watch, path: Path, beside: object = None) -> None:
    """Write the state of a watch, whole or not at all; with it what must be of the same moment."""
    told: dict[str, Any] = {name: getattr(watch, name) for name in _OF_WATCH}
    told["beside"] = beside
    told["alarms"] = [asdict(one) for one in watch.alarms.values()]
    told["events"] = [asdict(one) for one in watch.events]
    told["recent"] = [list(vars(one).values())[:-1] for one in watch.recent]
    told["antennas"] = {}
    arrays: dict[str, NDArray[Any]] = {}
    for n, (name, own) in enumerate(watch.antennas.items()):
        told["antennas"][name] = {"slots": [asdict(one) for one in own.slots]}
        for part, one in _parts(own).items():
            values = {each: getattr(one, each) for each in _KEPT[type(one)]}
            some = {each: value for each, value in values.items() if isinstance(value, np.ndarray)}
            arrays |= {f"{n}/{part}/{each}": value for each, value in some.items()}
            told["antennas"][name][part] = {k: v for k, v in values.items() if k not in some}
    texts: dict[str, Any] = {_KEY: np.array(key(watch)), _TOLD: np.array(json.dumps(told))}
    with write_whole(path, "wb") as file:
        np.savez(file, **(texts | arrays))


def load(watch: Watch, path: Path) -> Any:  # noqa: ANN401 - whatever was kept beside it
    """Take up a state; return what was kept beside it.

    Raises
    ------
    BadInput
        It is of another program, past or model, or no state at all.
    """
    try:
        with np.load(path, allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in kept.files}
        whose, told = str(arrays[_KEY]), json.loads(str(arrays[_TOLD]))
    except (OSError, ValueError, KeyError, EOFError, *_NO_ARCHIVE) as error:
        raise BadInput(f"no state of a watch: {error}", path) from None
    if whose != key(watch):
        wrong = "the state of a watch with another past, model or program"
        raise BadInput(f"{wrong}: move the folder away to begin anew", path)
    try:
        for name in _OF_WATCH:
            setattr(watch, name, told[name])
        watch.events = [Event(**one) for one in told["events"]]
        watch.recent = [Seen(*one) for one in told["recent"]]
        watch.alarms = {one["number"]: Alarm(**one) for one in told["alarms"]}
        for alarm in watch.alarms.values():
            alarm.members = [(tuple(alike), chance) for alike, chance in alarm.members]
        for n, (name, own) in enumerate(watch.antennas.items()):
            _restore(own, told["antennas"][name], arrays, n)
    except KeyError as error:
        raise BadInput(f"no state of a watch: it lacks {error}", path) from None
    return told["beside"]


def _restore(own: Antenna, told: dict[str, Any], arrays: dict[str, NDArray[Any]], n: int) -> None:
    own.slots = [Slot(**one) for one in told["slots"]]
    for part, one in _parts(own).items():
        for name in _KEPT[type(one)]:
            value = told[part].get(name, arrays.get(f"{n}/{part}/{name}"))
            if name not in told[part] and value is None:
                raise KeyError(name)
            setattr(one, name, tuple(value) if isinstance(value, list) else value)
