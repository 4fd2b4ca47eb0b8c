"""Public recordings replayed to the watch in the order of time, beside what is known of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner import program, scores
from pyport.examiner.acceptance.best_delay import Best, best
from pyport.examiner.nights import nights
from pyport.examiner.nights.nights import Case
from pyport.examiner.real import sets


def outcomes(
    cases: list[Case], file: Path, pointings_per_false_alarm: float
) -> Iterator[dict[str, Any]]:
    """Yield what comes out of every case, those first that the file has of this program."""
    made_by = {"program": [program.version(), pointings_per_false_alarm]}
    return scores.run(
        cases,
        lambda case: nights.examine(case, pointings_per_false_alarm) | made_by,
        file,
        made_by=made_by["program"],
    )


def of_nulls(found: Iterable[dict[str, Any]], pointings_per_false_alarm: float) -> str:
    """Return the table of nights without change: pointings and alarms in each kind of noise."""
    some = list(found)
    lines = ["noise                   pointings  alarms  of what"]
    for kind, wilder in dict.fromkeys((one["kind"], one["wilder"]) for one in some):
        own = [one for one in some if (one["kind"], one["wilder"]) == (kind, wilder)]
        pointings = sum(one["pointings"] for one in own)
        raised = [each["is"]["effect"] for one in own for each in one["raised"]]
        name = kind if wilder == 1 else f"{kind}, {wilder:.0f} times"
        lines.append(f"{name:22} {pointings:10d} {len(raised):7d}  {', '.join(raised)}")
    total = sum(one["pointings"] for one in some)
    raised_all = sum(len(one["raised"]) for one in some)
    count = len(some) * (nights.NIGHTS - nights.NIGHTS // 2)
    lines.append(f"{'all':22} {total:10d} {raised_all:7d}")
    promised = total / pointings_per_false_alarm
    lines.append(f"{count} nights; {promised:.1f} false alarms are promised at most, on average")
    return "\n".join(lines)


def of_steps(found: Iterable[dict[str, Any]]) -> str:
    """Return the table of steps: delays beside the best possible ones, names and dates."""
    some = list(found)
    lines = [
        "                 delay [pointings]      best possible     named  dated    before",
        "sigma   seen  median  mean  90 %   median  mean  90 %    right  +-1      the step",
    ]
    for size in [*sorted({one["size"] for one in some}), None]:
        own = [one for one in some if size in (None, one["size"])]
        seen = [one for one in own if one["delay"] is not None and one["best"] is not None]
        delay = np.array([one["delay"] for one in seen])
        best = np.array([one["best"] for one in seen])
        right = np.mean([one["right"] for one in seen])
        dated = np.mean([abs(one["since_off"]) <= 1 for one in seen])
        before = sum(one["false"] for one in own)
        lines.append(
            f"{'all' if size is None else f'{size:3.0f}'}   {len(seen):4d}/{len(own):<4d}"
            f"{_three(delay)}    {_three(best)}   {right:6.0%} {dated:6.0%} {before:6d}"
        )
    return "\n".join(lines)


def _three(values: Any) -> str:  # noqa: ANN401 - an array
    return f"{np.median(values):5.0f} {values.mean():6.1f} {np.quantile(values, 0.9):5.0f}"


#: Of shorter recordings than a log needs without a past this share stands for it.
PAST_SHARE = 0.6
#: Nights, of so many pointings, from which on it is known how nights differ: the past goes on until
#: then where that leaves half of the recordings.
NIGHTS, IN_NIGHT = 3, 8
#: Pasts of other lengths that a known event is looked for with: none was chosen by what it shows.
PASTS = range(60, 121, 10)
#: What is known to have changed, and when [UTC], and the effect; none for all terms of the model.
KNOWN = {
    "GMRT Cygnus A": (
        ("2003-06-02T06:00:00", "time tag of the scans: 5.9 s, then 1.5 s", "scan_direction"),
        ("2003-06-05T06:00:00", "time tag of the scans: 1.5 s, then -6.0 s", "scan_direction"),
    ),
    "IRAM 2015-03": (("2015-03-01T12:00:00", "vibration dampers softened", "nasmyth"),),
    "MMT together": (
        ("2023-07-01T12:00:00", "another epoch: tilt, azimuth zero, sag", ""),
        ("2023-09-23T12:00:00", "another epoch: tilt", ""),
        ("2025-03-25T12:00:00", "another epoch: tilt", ""),
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
    #: Of each, after how many pointings a rule that knows all about it raises it; of one telescope.
    best: list[Best] = field(default_factory=list)
    #: For pasts of other lengths the delays of the known events.
    others: dict[int, list[int | None]] = field(default_factory=dict)
    nights: int = 0  #: nights in the past that tell how nights differ
    refused: str = ""  #: why the set was not watched

    @property
    def changes(self) -> int:
        """Return how many alarms were of a change, not of what may always have been so."""
        return sum(not one["stood"] for one in self.alarms)


def replays(data: Path | None, pointings_per_false_alarm: float) -> Iterator[Replay]:
    """Yield what a watch makes of each set."""
    for entry in [*sets.catalogue(), GMRT]:
        if entry["name"].startswith(REPEATED):
            continue
        found = sets.read(entry, data)
        if isinstance(found, str):
            yield Replay(entry["name"], refused=found)
        else:
            replay = _replayed(found, pointings_per_false_alarm)
            if replay.known and "antenna" not in found.table:
                for past in PASTS:
                    other = _replayed(found, pointings_per_false_alarm, past)
                    replay.others[past] = [delay for _, delay in other.known]
                moments = [(_seconds(since), what) for since, _, what in KNOWN[found.name]]
                some = found.table, found.header, found.model
                replay.best = best(*some, moments, pointings_per_false_alarm)
            yield replay


def _replayed(
    found: sets.Recordings, pointings_per_false_alarm: float, past: int | None = None
) -> Replay:
    import pyport
    from pyport.errors import BadInput

    time = found.table.get("time_utc")
    clock = np.arange(len(found)) if time is None else np.array(time, "datetime64[s]").astype(float)
    order = np.argsort(clock, kind="stable")
    past = past or max(pyport.Watch.enough(found.model), _three_nights(found.night[order]))
    past = min(past, int(PAST_SHARE * len(found)))
    if len(np.unique(found.table.get("antenna", np.array([""])))) > 1:
        past = int(np.sum(found.night == found.night[order[0]]))
    table = {name: np.asarray(cells)[order] for name, cells in found.table.items()}
    _, each = np.unique(found.night[order][:past], return_counts=True)
    out = Replay(found.name, past, len(found) - past, nights=int((each >= IN_NIGHT).sum()))
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
    for moment, what, _ in KNOWN.get(found.name, ()):
        first = int(np.searchsorted(clock[order], _seconds(moment))) - past
        after = [one["row"] for one in out.alarms if one["row"] > first and not one["stood"]]
        out.known.append((what, after[0] - first if after else None))
    return out


def _seconds(moment: str) -> float:
    return float(np.datetime64(moment, "s").astype(float))


def _three_nights(night: NDArray[Any]) -> int:
    """Return how many pointings three nights are over after, 0 where that is beyond half."""
    ends = np.flatnonzero(night[1:] != night[:-1]) + 1
    for end in ends[ends <= len(night) // 2]:
        if (np.unique(night[:end], return_counts=True)[1] >= IN_NIGHT).sum() >= NIGHTS:
            return int(end)
    return 0


def total(found: Sequence[Replay], pointings_per_false_alarm: float) -> str:
    """Return how many alarms of a change there were, and how many are promised at most."""
    some = [one for one in found if one.nights >= NIGHTS]
    pointings = sum(one.pointings for one in some)
    changes = sum(one.changes for one in some)
    known = sum(delay is not None for one in some for _, delay in one.known)
    return (
        f"after pasts of {NIGHTS} nights or more: {pointings} pointings, {changes} alarms of a"
        f" change, {known} of {sum(len(one.known) for one in some)} known events raised;"
        f" {pointings / pointings_per_false_alarm:.2f} false alarms are promised at most"
    )


def text(found: Replay) -> str:
    """Return a replay as text."""
    if found.refused:
        return f"{found.name}: not watched: {found.refused}"
    nights = f"{found.nights} night{'s' * (found.nights != 1)}"
    lines = [f"{found.name}: {found.pointings} pointings after {found.past} in {nights}"]
    many = Counter(one["effect"] for one in found.alarms)
    if len(found.alarms) > MOST_LISTED:
        antennas = len({one["antenna"] for one in found.alarms})
        each = ", ".join(f"{count} {effect}" for effect, count in many.most_common())
        stood = sum(one["stood"] for one in found.alarms)
        lines.append(
            f"  {len(found.alarms)} alarms of {antennas} antennas, {stood} as if always so: {each}"
        )
    for one in found.alarms if len(found.alarms) <= MOST_LISTED else ():
        whose = f", antenna {one['antenna']}" if one["antenna"] else ""
        since = "as if always so" if one["stood"] else f"since {one['since']}"
        lines.append(f"  alarm at {one['row']}{whose}, {one['state']}, {since}:")
        lines.append(f"    {one['sentence']}")
    for n, (what, delay) in enumerate(found.known):
        when = "no alarm" if delay is None else f"an alarm within {delay} pointings"
        lines.append(f"  known: {what}: {when}")
        if found.best:
            rule = found.best[n]
            least = "none" if rule.delay is None else f"{rule.delay} pointings"
            lines.append(f"    best possible delay: {least}; likelihood ratio 10^{rule.most:.1f}")
    for past, delays in found.others.items():
        some = ", ".join("none" if one is None else str(one) for one in delays)
        lines.append(f"  after a past of {past}: an alarm within {some} pointings")
    return "\n".join(lines)
