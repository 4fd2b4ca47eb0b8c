"""Public recordings replayed to the watch in the order of time, beside what is known of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pyport.examiner.real import sets

#: Pointings that stand for the past; of shorter recordings this share.
PAST, PAST_SHARE = 80, 0.6
#: What is known to have changed, and when. [UTC]
KNOWN = {
    "GMRT Cygnus A": (
        ("2003-06-02T06:00:00", "time tag of the scans: 5.9 s, then 1.5 s"),
        ("2003-06-05T06:00:00", "time tag of the scans: 1.5 s, then -6.0 s"),
    ),
    "IRAM 2015-03": (("2015-03-01T12:00:00", "vibration dampers softened"),),
    "MMT together": (
        ("2023-07-01T12:00:00", "another epoch: tilt, azimuth zero, sag"),
        ("2023-09-23T12:00:00", "another epoch: tilt"),
        ("2025-03-25T12:00:00", "another epoch: tilt"),
    ),
}
#: More alarms than this are counted, not listed.
MOST_LISTED = 10
#: Sets that repeat others without times or sessions.
REPEATED = ("MMT together, ", "MMT 20", "RT32", "GMRT 2003")
GMRT = {"name": "GMRT Cygnus A", "format": "shipped", "files": ["gmrt-cyg-a"]}


@dataclass
class Replay:
    """What a watch made of a set."""

    name: str  #: the set
    #: `past`, `pointings`: how many pointings stood for the past, and how many were watched, of all
    #: antennas.
    past: int = 0
    pointings: int = 0
    #: As they were when they were raised, and in the end.
    alarms: list[dict[str, Any]] = field(default_factory=list)
    #: What is known to have changed, and how many pointings after it an alarm was raised; None
    #: where none was.
    known: list[tuple[str, int | None]] = field(default_factory=list)
    refused: str = ""  #: why the set was not watched


def replays(data: Path | None, pointings_per_false_alarm: float) -> Iterator[Replay]:
    """Yield what a watch makes of each set."""
    for entry in [*sets.catalogue(), GMRT]:
        if entry["name"].startswith(REPEATED):
            continue
        found = sets.read(entry, data)
        if isinstance(found, str):
            yield Replay(entry["name"], refused=found)
        else:
            yield _replayed(found, pointings_per_false_alarm)


def _replayed(found: sets.Recordings, pointings_per_false_alarm: float) -> Replay:
    import pyport
    from pyport.errors import BadInput

    time = found.table.get("time_utc")
    clock = np.arange(len(found)) if time is None else np.array(time, "datetime64[s]").astype(float)
    order = np.argsort(clock, kind="stable")
    past = min(PAST, int(PAST_SHARE * len(found)))
    if len(np.unique(found.table.get("antenna", np.array([""])))) > 1:
        past = int(np.sum(found.night == found.night[order[0]]))
    table = {name: np.asarray(cells)[order] for name, cells in found.table.items()}
    out = Replay(found.name, past, len(found) - past)
    try:
        watch = pyport.Watch(
            {name: cells[:past] for name, cells in table.items()},
            found.model,
            header=found.header,
            pointings_per_false_alarm=pointings_per_false_alarm,
        )
        seen = list(watch.replay({name: cells[past:] for name, cells in table.items()}))
    except BadInput as error:
        out.refused = str(error)
        return out
    raised = {}
    for one in seen:
        for event in one.events:
            if event.event == "raised":
                raised[event.alarm["number"]] = one.row
    last = {number: one.as_json(timed=time is not None) for number, one in watch.alarms.items()}
    out.alarms = [{"row": row, **last.get(number, {})} for number, row in raised.items()]
    for moment, what in KNOWN.get(found.name, ()):
        first = int(np.searchsorted(clock[order], np.datetime64(moment, "s").astype(float))) - past
        after = [row for row in raised.values() if row > first]
        out.known.append((what, after[0] - first if after else None))
    return out


def text(found: Replay) -> str:
    """Return a replay as text."""
    if found.refused:
        return f"{found.name}: not watched: {found.refused}"
    lines = [f"{found.name}: {found.pointings} pointings after {found.past}"]
    many = Counter(one["effect"] for one in found.alarms)
    if len(found.alarms) > MOST_LISTED:
        antennas = len({one["antenna"] for one in found.alarms})
        told = ", ".join(f"{count} {effect}" for effect, count in many.most_common())
        lines.append(f"  {len(found.alarms)} alarms of {antennas} antennas: {told}")
    for one in found.alarms if len(found.alarms) <= MOST_LISTED else ():
        whose = f", antenna {one['antenna']}" if one["antenna"] else ""
        lines.append(f"  alarm at {one['row']}{whose}, {one['state']}, since {one['since']}:")
        lines.append(f"    {one['sentence']}")
    for what, delay in found.known:
        when = "no alarm" if delay is None else f"an alarm within {delay} pointings"
        lines.append(f"  known: {what}: {when}")
    return "\n".join(lines)
