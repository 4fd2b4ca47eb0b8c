"""The state of a watch, kept whole after every pointing and taken up again; what it writes."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import subprocess
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.files import write_file, write_whole
from pyport.runs.checkpoint import key_of
from pyport.watch.alarms import Alarm
from pyport.watch.detection.antenna import Antenna, Slot
from pyport.watch.detection.composite import Composite
from pyport.watch.detection.detector import Detector
from pyport.watch.detection.null import Null
from pyport.watch.watch import Event, Seen, Watch

#: What reading an archive raises that is none, or is spoilt.
_NO_ARCHIVE = (zipfile.BadZipFile, zlib.error, NotImplementedError, tokenize.TokenError)
_TEXT, _KEY = "told", "key"
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
    kept: dict[str, Any] = {name: getattr(watch, name) for name in _OF_WATCH}
    kept["beside"] = beside
    kept["alarms"] = [asdict(one) for one in watch.alarms.values()]
    kept["events"] = [asdict(one) for one in watch.events]
    kept["recent"] = [list(vars(one).values())[:-1] for one in watch.recent]
    kept["antennas"] = {}
    arrays: dict[str, NDArray[Any]] = {}
    for n, (name, own) in enumerate(watch.antennas.items()):
        kept["antennas"][name] = {"slots": [asdict(one) for one in own.slots]}
        for part, one in _parts(own).items():
            values = {each: getattr(one, each) for each in _KEPT[type(one)]}
            some = {each: value for each, value in values.items() if isinstance(value, np.ndarray)}
            arrays |= {f"{n}/{part}/{each}": value for each, value in some.items()}
            kept["antennas"][name][part] = {k: v for k, v in values.items() if k not in some}
    texts: dict[str, Any] = {_KEY: np.array(key(watch)), _TEXT: np.array(json.dumps(kept))}
    with write_whole(path, "wb") as file:
        np.savez(file, **(texts | arrays))


def load(watch: Watch, path: Path) -> Any:  # noqa: ANN401 - whatever was kept beside it
    """Take up a state; return what was kept beside it.

    Raises `BadInput`: it is of another program, past or model, or no state at all.
    """
    try:
        with np.load(path, allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in kept.files}
        whose, kept = str(arrays[_KEY]), json.loads(str(arrays[_TEXT]))
    except (OSError, ValueError, KeyError, EOFError, *_NO_ARCHIVE) as error:
        raise BadInput(f"no state of a watch: {error}", path) from None
    if whose != key(watch):
        wrong = "the state of a watch with another past, model or program"
        raise BadInput(f"{wrong}: move the folder away to begin anew", path)
    try:
        for name in _OF_WATCH:
            setattr(watch, name, kept[name])
        watch.events = [Event(**one) for one in kept["events"]]
        watch.recent = [Seen(*one) for one in kept["recent"]]
        watch.alarms = {one["number"]: Alarm(**one) for one in kept["alarms"]}
        for alarm in watch.alarms.values():
            alarm.members = [(tuple(alike), chance) for alike, chance in alarm.members]
        for n, (name, own) in enumerate(watch.antennas.items()):
            _restore(own, kept["antennas"][name], arrays, n)
    except KeyError as error:
        raise BadInput(f"no state of a watch: it lacks {error}", path) from None
    return kept["beside"]


def _restore(own: Antenna, kept: dict[str, Any], arrays: dict[str, NDArray[Any]], n: int) -> None:
    own.slots = [Slot(**one) for one in kept["slots"]]
    for part, one in _parts(own).items():
        for name in _KEPT[type(one)]:
            value = kept[part].get(name, arrays.get(f"{n}/{part}/{name}"))
            if name not in kept[part] and value is None:
                raise KeyError(name)
            setattr(one, name, tuple(value) if isinstance(value, list) else value)


EVENTS, STATUS, METRICS, ACTED = "events.jsonl", "status.json", "metrics.prom", "acted"
#: A command that has not ended by then is given up [s].
PATIENCE_S = 60.0


class Outputs:
    """The files in a watch's folder, and the command that is run for each event.

    The state of the watch is kept first and holds the last events. What was kept and not reported
    is reported at the next start, once. A command that was killed is run again.

    `command` is run for each event, its JSON on standard input; "" is none. `say` prints an event.
    """

    def __init__(self, folder: Path, command: str, say: Callable[[Event], None]):
        self.folder, self.command, self.say = folder, shlex.split(command), say
        self.reported = _last(folder / EVENTS)
        self.acted = self.reported
        if self.command and (folder / ACTED).is_file():
            self.acted = int((folder / ACTED).read_text(encoding="ascii") or 0)

    def begin(self) -> None:
        """Forget what an earlier watch reported: this one begins without a state."""
        for name in (EVENTS, ACTED):
            (self.folder / name).unlink(missing_ok=True)
        self.reported = self.acted = 0

    def tell(self, watch: Watch) -> list[str]:
        """Tell what happened since the last time; return what went wrong with the command."""
        new = [one for one in watch.events if one.number > self.reported]
        if new:
            if self.command and not (self.folder / ACTED).exists():
                self._has_acted(self.acted)
            with (self.folder / EVENTS).open("a", encoding="utf-8") as file:
                for one in new:
                    file.write(line(one) + "\n")
                file.flush()
                os.fsync(file.fileno())
            self.reported = new[-1].number
            for one in new:
                self.say(one)
        wrong = list(self._act(watch)) if self.command else []
        write_file(self.folder / STATUS, json.dumps(watch.status(), indent=1) + "\n")
        write_file(self.folder / METRICS, metrics(watch))
        return wrong

    def _act(self, watch: Watch) -> Iterator[str]:
        for one in watch.events:
            if one.number <= self.acted:
                continue
            name = self.command[0]
            said = {"PYPORT_EVENT": one.event, "PYPORT_ALARM": str(one.alarm["number"])}
            how: dict[str, Any] = {"env": os.environ | said, "timeout": PATIENCE_S}
            try:
                done = subprocess.run(  # noqa: S603 - the user's command
                    self.command, input=line(one), text=True, check=False, **how
                )
                if done.returncode:
                    yield f"{name}: exit status {done.returncode} at event {one.number}"
            except (OSError, subprocess.TimeoutExpired) as error:
                yield f"{name}: {error}"
            self._has_acted(one.number)

    def _has_acted(self, number: int) -> None:
        """Keep up to which event the command was run."""
        self.acted = number
        write_file(self.folder / ACTED, str(number))


def line(one: Event) -> str:
    """Return an event as a line of JSON."""
    return json.dumps(asdict(one))


def words(one: Event) -> str:
    """Return an event as an observer reads it."""
    alarm = one.alarm
    whose = f" of {alarm['antenna']}" if alarm["antenna"] else ""
    dated = alarm["since"] is not None and one.event not in ("withdrawn", "over")
    when = f", since {alarm['since']}" if dated else ""
    end = alarm["back"] or alarm["ended"]
    if one.event == "over" and alarm["since"] is not None and end is not None:
        when = f", from {alarm['since']} to {end}"
    said = f"alarm {alarm['number']}{whose} {one.event}{when}: {alarm['sentence']}"
    rarity = f"{10 ** min(alarm['log10_likelihood_ratio'], 99):.2g}"
    if one.event in ("withdrawn", "over"):
        return said
    return f"{said}; {rarity} times likelier than no change; next: {alarm['next']}"


def _last(path: Path) -> int:
    """Return the number of the last event in a file; a line that was cut short is taken off."""
    if not path.is_file():
        return 0
    content = path.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    if whole != content:
        with path.open("r+b") as file:
            file.truncate(len(whole))
    lines = whole.splitlines()
    return int(json.loads(lines[-1])["number"]) if lines else 0


def metrics(watch: Watch) -> str:
    """Return the status as OpenMetrics text (openmetrics.io, version 1.0.0)."""
    status: dict[str, Any] = watch.status()
    lines: list[str] = []

    def add(name: str, kind: str, text: str, values: dict[str, float | None]) -> None:
        lines.extend([f"# TYPE pyport_watch_{name} {kind}", f"# HELP pyport_watch_{name} {text}"])
        suffix = "_total" if kind == "counter" else ""
        for labels, value in values.items():
            if value is not None:
                lines.append(f"pyport_watch_{name}{suffix}{labels} {value!r}")

    add("recordings", "counter", "Recordings taken in.", {"": status["rows"]})
    add("alarms", "counter", "Alarms raised.", {"": status["alarms_raised"]})
    add("standing", "gauge", "Alarms that stand.", {"": len(status["standing"])})
    last = watch.recent[-1].time if watch.recent and watch.timed else None
    add("last_recording_seconds", "gauge", "Time of the last recording.", {"": last})
    each = {f'{{antenna="{_escaped(name)}"}}': one for name, one in status["antennas"].items()}
    for key, text in (
        ("log10_evidence", "Likelihood ratio of a change to none."),
        ("log10_threshold", "What that ratio must reach for an alarm."),
        ("scatter_xel_arcsec", "Scatter in cross-elevation."),
        ("scatter_el_arcsec", "Scatter in elevation."),
        ("outliers", "Share of outliers."),
    ):
        add(key, "gauge", text, {labels: one[key] for labels, one in each.items()})
    return "\n".join([*lines, "# EOF", ""])


def _escaped(label: str) -> str:
    return label.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
