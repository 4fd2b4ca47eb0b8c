"""The watch as a process: a log followed, the state kept, others notified; killed, it goes on."""

from __future__ import annotations

import contextlib
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

from pyport.effects.circumstances import NIGHT_GAP_S
from pyport.effects.mounts import MOUNT
from pyport.errors import BadInput
from pyport.mounts import ALTAZ
from pyport.recordings import read
from pyport.recordings import write as write_recordings
from pyport.recordings.notes import FEWEST_ROWS, KEY
from pyport.recordings.raw import NOTHING, FileOptions
from pyport.recordings.schema import Recordings
from pyport.watch import follow, state
from pyport.watch.alarms import moment
from pyport.watch.detection.composite import FEWEST_IN_NIGHT, FEWEST_NIGHTS
from pyport.watch.follow import Batch, Cursor
from pyport.watch.state import Outputs
from pyport.watch.watch import POINTINGS_PER_FALSE_ALARM, Event, Seen, Watch

STATE, HISTORY, LOCK = "state.npz", "history.csv", "lock"
#: So often the state is kept while nothing happens [s]: what came since is read from the log again
#: after a kill. It waits for the disk longer than all else takes; an event waits for it, always.
KEPT_EVERY_S = 30.0
#: Header keys without which rows mean something else, and what no line stands for.
STATED = {"azimuth_zero": "north", MOUNT: ALTAZ.id, "latitude_deg": "", "longitude_deg": ""}
#: Times further ahead of this machine's clock are said to be in the future [s]: a day, so that no
#: time zone is taken for it.
DAY_S = 86400.0


@dataclass(frozen=True)
class Options:
    """What to watch, and how."""

    log: Path  #: A file that grows, or a folder of files
    model: str  #: A name or a file
    out: Path  #: folder of the state, the events, the status and the metrics
    given: FileOptions = NOTHING  #: what the log itself does not say
    #: Past recordings; None for the first ones of the log, `burn_in` of them, or `enough`.
    history: str | None = None
    burn_in: int | None = None
    pointings_per_false_alarm: float = POINTINGS_PER_FALSE_ALARM
    command: str = ""  #: run for each event


@dataclass
class Process:
    """A watch that follows a log.

    `complain` is given what cannot be used, `show` the watch whenever it was kept.
    """

    options: Options
    say: Callable[[Event], None]
    complain: Callable[[str], None]
    watch: Watch | None = None
    show: Callable[[Watch], None] = lambda _: None
    cursor: Cursor = field(default_factory=Cursor)
    outputs: Outputs = field(init=False)
    left_out: Counter[str] = field(default_factory=Counter)  #: rows that cannot be read, by reason
    _kept: float = -math.inf
    _behind: bool = False
    _early: list[Recordings] = field(default_factory=list)
    #: Rows of the log that came with each kind of note.
    _noted: Counter[str] = field(default_factory=Counter)
    _compared: bool = False

    def __post_init__(self) -> None:
        """Take up the state that an earlier process left."""
        out = self.options.out
        out.mkdir(parents=True, exist_ok=True)
        if not self.options.log.exists():
            wrong = "no such log, expected a file or a folder of recordings"
            raise BadInput(wrong, self.options.log)
        self.outputs = Outputs(out, self.options.command, self.say)
        if (out / STATE).is_file():
            past = self.options.history or str(out / HISTORY)
            self._begin(past)
            assert self.watch is not None  # noqa: S101 - begun above
            self.cursor = Cursor(**state.load(self.watch, out / STATE))
            self._tell()
        else:
            self.outputs.begin()
            if self.options.history is not None:
                self._begin(self.options.history)

    @property
    def needed(self) -> int:
        """Return how many pointings of the log stand for the past where no past is given."""
        return self.options.burn_in or Watch.enough(self.options.model)

    def _begin(self, past: str) -> None:
        given = self.options.given if self.options.history is not None else NOTHING
        self.watch = Watch(
            read(past, given),
            self.options.model,
            pointings_per_false_alarm=self.options.pointings_per_false_alarm,
        )
        for one in self.watch.history.notes:
            self.complain(f"warning: {past}: {one}")
        if self.watch.past_nights < FEWEST_NIGHTS:
            self.complain(
                f"nights of {FEWEST_IN_NIGHT} pointings or more in the past:"
                f" {self.watch.past_nights}; from {FEWEST_NIGHTS} on it is known how nights differ,"
                " until then a night that does is an alarm"
            )

    def step(self) -> Iterator[Seen]:
        """Take in what the log has by now; yield each recording when it is kept."""
        if self.watch is None and not self._burnt_in():
            return
        assert self.watch is not None  # noqa: S101 - begun above
        for batch in follow.new(self.options.log, self.options.given, self.cursor):
            seen = self._taken(self.watch, batch)
            before, self.cursor = self.cursor, batch.cursor
            # another file, or less of it: what was read cannot be read again
            gone = before.inode != self.cursor.inode or before.offset > self.cursor.offset
            self._keep(at_once=gone or any(one.events for one in seen))
            yield from seen

    def _burnt_in(self) -> bool:
        """Collect the past from the log; tell whether there is enough of it, and begin."""
        needed = self.needed - sum(map(len, self._early))
        for batch in follow.new(self.options.log, self.options.given, self.cursor, size=1):
            self._complain(batch)
            self.cursor = batch.cursor
            if batch.recordings is not None:
                self._early.append(batch.recordings)
                needed -= len(batch.recordings)
            if needed <= 0:
                break
        if needed > 0:
            return False
        path = self.options.out / HISTORY
        write_recordings(follow.joined(self._early), path)
        self._early = []
        self._begin(str(path))
        self._keep(at_once=True)
        return True

    def _taken(self, watch: Watch, batch: Batch) -> list[Seen]:
        """Take in a batch, rows that cannot be used one by one left out."""
        self._complain(batch)
        if batch.recordings is None:
            return []
        self._complain_of_header(watch, batch.recordings)
        self._complain_of_times(watch, batch.recordings)
        try:
            return list(watch.replay(batch.recordings))
        except BadInput:
            seen = []
            for n in range(len(batch.recordings)):
                try:
                    seen += list(watch.replay(batch.recordings.take(slice(n, n + 1))))
                except BadInput as error:
                    self.complain(str(error))
            return seen

    def _complain(self, batch: Batch) -> None:
        """Say what is left out, and once of each kind what the log says against itself."""
        rows = 0 if batch.recordings is None else len(batch.recordings)
        for kind, text in batch.notes.items():
            enough = 1 if kind.startswith(KEY) else FEWEST_ROWS
            before = self._noted[kind]
            self._noted[kind] += rows
            if before < enough <= self._noted[kind]:
                self.complain(f"warning: {self.options.log}: {text}")
        for one in batch.skipped:
            self.left_out[one.reason] += 1
            self.complain(f"{self.options.log}:{one.line}: {one.reason}: left out")

    def _complain_of_header(self, watch: Watch, recordings: Recordings) -> None:
        """Say once what the past states of how its rows are read, and the log does not."""
        if self._compared:
            return
        self._compared = True
        for key, nothing in STATED.items():
            past, now = (one.meta.get(key, nothing) for one in (watch.history, recordings))
            if past and now != past:
                wrong = (
                    f"'# {key}: {past}' in the past, {f'{now!r}' if now else 'nothing'} in the log"
                )
                self.complain(f"warning: {self.options.log}: {wrong}")

    def _complain_of_times(self, watch: Watch, recordings: Recordings) -> None:
        """Say which rows come from the future or begin to be of another night before.

        They are taken as they stand: whether the clock or the order is wrong the log cannot tell.
        """
        if not watch.timed or "time" not in recordings.at.columns:
            return
        last, now = watch.last, time.time()
        for one, line in zip(recordings.at.column("time"), recordings.line, strict=True):
            wrong = ""
            if one > now + DAY_S:
                wrong = f"{moment(one, timed=True)} is in the future"
            elif one < last - NIGHT_GAP_S:
                was = moment(last, timed=True)
                wrong = f"{moment(one, timed=True)} comes after {was}"
            if wrong:
                self.complain(f"{self.options.log}:{line}: {wrong}: taken as it stands")
            last = one if abs(one - last) > NIGHT_GAP_S else max(last, one)

    def _keep(self, *, at_once: bool) -> None:
        """Keep the state, at the latest before anything is reported."""
        assert self.watch is not None  # noqa: S101 - kept only once begun
        now = time.monotonic()
        self._behind = not at_once and now - self._kept < KEPT_EVERY_S
        if not self._behind:
            state.save(self.watch, self.options.out / STATE, asdict(self.cursor))
            self._kept = now
        self._tell()

    def close(self) -> None:
        """Keep what was not kept yet."""
        if self._behind:
            self._keep(at_once=True)

    def _tell(self) -> None:
        assert self.watch is not None  # noqa: S101 - asked only once begun
        for wrong in self.outputs.tell(self.watch):
            self.complain(wrong)
        self.show(self.watch)


@contextlib.contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Keep other processes from watching with the same folder.

    Raises `BadInput`: one does.
    """
    folder.mkdir(parents=True, exist_ok=True)
    try:
        import fcntl
    except ImportError:  # no such locks on this system
        yield
        return
    with (folder / LOCK).open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            wrong = "another process watches with this folder, expected one of its own"
            raise BadInput(wrong, folder) from None
        yield


def forever(process: Process, every_s: float) -> Iterator[Seen]:
    """Yield what comes, looking at the log every so many seconds."""
    while True:
        yield from process.step()
        time.sleep(every_s)
