"""The watch: recordings in, one by one, alarms out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.arguments import mapping, number
from pyport.correction.use import PointingModel, model_of
from pyport.effects.circumstances import NIGHT_GAP_S
from pyport.errors import BadInput
from pyport.fitting.fit import in_sessions
from pyport.models.model import Model
from pyport.recordings.from_table import Header, Table, from_table, raw_table
from pyport.recordings.interpret import interpret
from pyport.recordings.schema import Recordings
from pyport.recordings.sky import SHORT, night_of
from pyport.runs.workers import one_thread
from pyport.watch import steps
from pyport.watch.alarms import Alarm, moment
from pyport.watch.detection import antenna as one_antenna
from pyport.watch.detection.antenna import Antenna
from pyport.watch.detection.baseline import TooFew, enough, past
from pyport.watch.detection.composite import FEWEST_IN_NIGHT, calibrated
from pyport.watch.detection.prepare import prepare

#: One false alarm in so many pointings or more, on average, unless another number is asked for.
POINTINGS_PER_FALSE_ALARM = 10_000
#: Alarms that no longer stand, and events, of which so many are remembered.
REMEMBERED = 100
#: Pointings of tonight that a page or a picture is drawn from.
SHOWN = 500


@dataclass(frozen=True)
class Event:
    """Something that happened to an alarm."""

    number: int  #: of the event, from 1, without gaps
    event: str  #: `raised`, `renamed`, `confirmed`, `withdrawn` or `over`
    row: int  #: the recording that brought it, from 1
    alarm: dict[str, Any]  #: as it then was


@dataclass(frozen=True)
class Seen:
    """A recording as the watch saw it.

    `time` is in seconds since 1970, or the recording's number; `xel_arcsec` and `el_arcsec` are
    its offsets against the model of the past, NaN where an axis was not measured, and the sigmas
    the white scatter.
    """

    row: int
    time: float
    antenna: str
    az_deg: float
    el_deg: float
    xel_arcsec: float
    el_arcsec: float
    sigma_xel_arcsec: float
    sigma_el_arcsec: float
    evidence: float
    events: tuple[Event, ...] = ()


class Watch:
    """A watch over pointings that come one after the other.

    >>> import pyport
    >>> watch = pyport.Watch("past.csv", "altaz")
    >>> seen = watch.update({"az_deg": 41.2, "el_deg": 33.0, "d_el_arcsec": 4.0, ...})
    >>> [alarm.sentence for alarm in watch.standing]

    Parameters
    ----------
    history
        Recordings, as `pyport.diagnose` takes them: later ones are compared with their model and
        noise.
    model
        A name, a file or a model; its terms that are not fixed are fitted to the history.
    pointings_per_false_alarm
        How many pointings there are on average, or more, before an alarm that nothing caused, all
        antennas taken together. In n pointings there is one with a probability of n over this
        number, or less.
    header
        What holds for all rows of the history and of what comes: `latitude_deg`, ...

    Raises
    ------
    BadInput
        There are too few past recordings, or the model lacks something.
    """

    @one_thread
    def __init__(
        self,
        history: Table,
        model: str | Path | Model | PointingModel = "altaz",
        *,
        pointings_per_false_alarm: float = POINTINGS_PER_FALSE_ALARM,
        header: Header | None = None,
    ):
        per = number("pointings_per_false_alarm", pointings_per_false_alarm, 1)
        self.model = model_of(model)
        history = in_sessions(from_table(history, header), self.model.fitted())
        self.history = history
        self.pointings_per_false_alarm = per
        names = np.unique(history.label("antenna").astype(str))
        self.antennas: dict[str, Antenna] = {}
        #: Antennas with too short a past, and what is said of them; their rows are passed over.
        self.unwatched: dict[str, str] = {}
        for name in names:
            try:
                of_it = past(history, self.model, str(name) if len(names) > 1 else None)
            except TooFew as few:
                self.unwatched[str(name)] = few.message
                continue
            placed, nulls = calibrated(of_it)
            each = per * len(names)
            self.antennas[str(name)] = one_antenna.begin(of_it.baseline, placed, nulls, each)
        if not self.antennas:
            raise BadInput(next(iter(self.unwatched.values())), history.file)
        time = np.asarray(history.at.columns.get("time", np.full(len(history), np.nan)), float)
        self.timed = bool(np.isfinite(time).all())
        self.last = float(time.max()) if self.timed else np.nan
        sessions = history.label("session").astype(str)
        self.session = str(sessions[-1]) if len(sessions) else ""
        _, in_night = np.unique(sessions, return_counts=True)
        #: Nights of the past that tell how nights differ; with fewer than three the promise holds
        #: within a night.
        self.past_nights = int((in_night >= FEWEST_IN_NIGHT).sum())
        self.first_row = len(history)
        self.row = 0
        #: What the state belongs to, once it was asked for: see `pyport.watch.state`.
        self.key = ""
        self.alarms: dict[int, Alarm] = {}
        self.raised = 0
        self.events: list[Event] = []
        self.happened = 0
        self.recent: list[Seen] = []

    @staticmethod
    def enough(model: str | Path | Model | PointingModel = "altaz") -> int:
        """Return how many pointings make a past for a model, where it may be chosen."""
        return enough(model_of(model))

    @property
    def standing(self) -> list[Alarm]:
        """Return the alarms that are neither withdrawn nor over."""
        return [one for one in self.alarms.values() if one.stands]

    def update(self, row: Mapping[str, Any]) -> Seen:
        """Take in one recording; its keys are the columns of a file of recordings.

        Raises
        ------
        BadInput
            The row lacks something or tells no offset; the watch is as it was.
        """
        cells = {name: [value] for name, value in mapping("row", row).items()}
        recordings = interpret(raw_table(cells, self.history.meta))
        if not len(recordings):
            raise BadInput(recordings.set_aside[0].reason)
        seen = next(self.replay(recordings), None)
        if seen is None:
            raise BadInput("row: its antenna has no past, or too short a one")
        return seen

    def replay(self, table: Table) -> Iterator[Seen]:
        """Take in recordings in the order of time, and yield each as it was seen.

        Raises
        ------
        BadInput
            None is of an antenna with a past, or one has no time where the past has.
        """
        recordings = from_table(table, self.history.meta)
        who = recordings.label("antenna").astype(str)
        watched = np.isin(who, list(self.antennas))
        if len(who) and not watched.any() and not np.isin(who, list(self.unwatched)).any():
            known = ", ".join(self.antennas)
            wrong = f"antenna {str(who[0])!r} has no past recordings; there are those of {known!r}"
            raise BadInput(wrong, recordings.file, int(recordings.line[0]))
        for name in dict.fromkeys(who[~watched].tolist()):
            self.unwatched.setdefault(name, "no past recordings")
        before = self.last, self.session
        try:
            order, turns = self._turns(self._ordered(recordings.take(watched)))
        except BadInput:
            self.last, self.session = before
            raise
        for name in order:
            yield self._taken(*next(turns[name]))

    def _turns(
        self, recordings: Recordings
    ) -> tuple[list[str], dict[str, Iterator[tuple[Antenna, Any, int]]]]:
        """Return the antenna of each recording, and of each antenna the prepared rows in turn."""
        who = recordings.label("antenna").astype(str).tolist()
        places = {
            name: [n for n, one in enumerate(who) if one == name] for name in dict.fromkeys(who)
        }
        turns = {}
        for name, own in places.items():
            one = self.antennas[name]
            rows = prepare(one.baseline, recordings.take(np.array(own)), one.home)
            turns[name] = iter([(one, rows, n) for n in range(len(rows))])
        return who, turns

    def _taken(self, own: Antenna, rows: Any, n: int) -> Seen:  # noqa: ANN401 - prepared rows
        self.row += 1
        happened = steps.take(own, rows, n, self.alarms, self.raised + 1)
        if happened and happened[0].startswith("raised"):
            self.raised += 1
        az_deg, el_deg = float(rows.az[n] / DEG) % 360, float(rows.el[n] / DEG)
        where = self.row, float(rows.clock[n]), own.baseline.antenna, az_deg, el_deg
        off = (own.left.T / ARCSEC).ravel().tolist()
        events = tuple(self._event(one) for one in happened)
        seen = Seen(*where, off[0], off[1], off[2], off[3], own.evidence, events)
        self.recent = [*self.recent, seen][-SHOWN:]
        return seen

    def _event(self, what: str) -> Event:
        kind, number = what.split()
        self.happened += 1
        alarm = self.alarms[int(number)].as_json(timed=self.timed)
        event = Event(self.happened, kind, self.row, alarm)
        self.events = [*self.events, event][-REMEMBERED:]
        ended = [one.number for one in self.alarms.values() if not one.stands]
        for old in ended[:-REMEMBERED]:
            del self.alarms[old]
        return event

    def _ordered(self, recordings: Recordings) -> Recordings:
        """Return recordings in the order of time, with sessions, numbered on from the past."""
        at = recordings.at
        time = np.asarray(at.columns.get("time", np.full(len(at), np.nan)), float)
        if self.timed and not np.isfinite(time).all():
            row = int(np.argmax(~np.isfinite(time)))
            wrong = "no time, expected one as in the past recordings"
            raise BadInput(wrong, recordings.file, int(recordings.line[row]))
        if self.timed:
            recordings = recordings.take(np.argsort(time, kind="stable"))
        at, columns = recordings.at, dict(recordings.at.columns)
        if SHORT in self.history.meta:
            columns.pop("session", None)
        if "session" not in columns and self.timed:
            columns["session"] = self._nights(np.asarray(at.column("time"), float))
        numbers = self.first_row + self.row + 1 + np.arange(len(at))
        return replace(recordings, at=replace(at, columns=columns), line=numbers)

    def _nights(self, time: Array) -> NDArray[np.str_]:
        """Return the night of each row: another one begins after a long gap.

        So it does where the clock goes back as far: after a row of a wrong year nights go on.
        """
        found = []
        for one in time.tolist():
            if abs(one - self.last) > NIGHT_GAP_S:
                self.session, self.last = night_of(one), one
            self.last = max(self.last, one)
            found.append(self.session)
        return np.array(found, np.str_)

    def status(self) -> dict[str, Any]:
        """Return what there is to know at a glance, as JSON holds it."""
        last = self.recent[-1] if self.recent else None
        return {
            "schema": "pyport.watch/1",
            "model": self.model.name,
            "history": str(Path(self.history.file)),
            "pointings_per_false_alarm": self.pointings_per_false_alarm,
            "past_nights": self.past_nights,
            "rows": self.row,
            "last": None if last is None else moment(last.time, timed=self.timed),
            "alarms_raised": self.raised,
            "events": self.happened,
            "unwatched": self.unwatched,
            "standing": [one.as_json(timed=self.timed) for one in self.standing],
            "antennas": {
                name: {
                    "pointings": own.rows,
                    "log10_evidence": own.evidence / float(np.log(10))
                    if len(own.detector.row)
                    else None,
                    "log10_threshold": own.threshold / float(np.log(10)),
                    "scatter_xel_arcsec": float(own.white[0]) / ARCSEC,
                    "scatter_el_arcsec": float(own.white[1]) / ARCSEC,
                    "outliers": own.null.share,
                }
                for name, own in self.antennas.items()
            },
        }
