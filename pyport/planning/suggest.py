"""What to observe next: the directions that best distinguish what cannot be distinguished yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import DEG, HOUR, Array, separation
from pyport.effects.base import Circumstances, Effect, MissingColumn
from pyport.mounts import ALTAZ
from pyport.planning.design import Design, cells
from pyport.planning.separate import Pair
from pyport.recordings import sky
from pyport.recordings.mounted import axes_of
from pyport.recordings.schema import Recordings

#: What is known before any recording, as a share of what the recordings tell of a column.
PRIOR = 1e-9
#: How much a coefficient of the model counts beside a pair that cannot be distinguished.
MODEL_SHARE = 0.1
MOST_PAIRS = 40
#: Directions that are suggested together lie at least so far from each other [rad].
APART = 12 * DEG


@dataclass(frozen=True)
class Direction:
    """A direction to observe [deg], the source that is there, and what it decides.

    `gain` is how much smaller it makes, beside the directions before it, the
    error of what distinguishes the pairs: the mean logarithm.
    """

    az_deg: float
    el_deg: float
    source: str
    hour_angle_h: float | None
    decides: tuple[str, str] | None
    gain: float
    time_s: float | None = None  #: when the source is there [s since 1970], None for at any time


@dataclass(frozen=True)
class Promise:
    """A pair, and how well its first is known beside its second, now and after the directions.

    Errors are those of the worst coefficient [unit].
    """

    one: str
    other: str
    before: float
    after: float
    unit: str


@dataclass(frozen=True)
class Targets:
    """Directions that could be observed [rad], the source at each, "" for none, and when [s]."""

    az: Array
    el: Array
    source: tuple[str, ...]
    time_s: Array | None = None  #: None for at any time


def suggest(
    design: Design, pairs: Sequence[Pair], targets: Targets, count: int
) -> tuple[tuple[Direction, ...], tuple[Promise, ...]]:
    """Return the directions that decide most, one after the other, and what they promise.

    Each direction is the one that adds most to the logarithm of the information
    on the first of a pair beside the second and the model, summed over the
    pairs (D_s-optimal, Atkinson & Donev 1992), and to that on the model itself.
    """
    pairs = sorted(pairs, key=lambda one: -one.share)[:MOST_PAIRS]
    asked = [_Question(design, one, targets) for one in pairs]
    questions = [_Question(design, None, targets), *asked]
    weights = [MODEL_SHARE if pairs else 1.0, *([1 / max(len(pairs), 1)] * len(pairs))]
    found: list[Direction] = []
    free = np.ones(len(targets.az), bool)
    for _ in range(count):
        if not free.any():
            break
        gains = np.array([question.gains() for question in questions])
        total = np.where(free, np.array(weights) @ gains, -np.inf)
        best = int(np.argmax(total))
        near = separation(targets.az[best], targets.el[best], targets.az, targets.el)
        free &= near >= APART
        which = int(np.argmax(gains[1:, best])) if pairs else -1
        decides = None
        if which >= 0:
            decides = (pairs[which].one.effect.id, pairs[which].other.effect.id)
        found.append(_direction(targets, best, decides, float(total[best]), design.recordings))
        for question in questions:
            question.add(best)
    promises = (question.promise(pair) for pair, question in zip(pairs, asked, strict=True))
    return tuple(found), tuple(promises)


def _direction(
    targets: Targets, n: int, decides: tuple[str, str] | None, gain: float, recordings: Recordings
) -> Direction:
    hour_angle = None
    site = recordings.at.site
    if targets.source[n] and site is not None:
        angle, _ = sky.equator(targets.az[n : n + 1], targets.el[n : n + 1], site.latitude)
        hour_angle = float(angle[0] / HOUR)
    az, el = float(targets.az[n] / DEG) % 360, float(targets.el[n] / DEG)
    moment = None if targets.time_s is None else float(targets.time_s[n])
    return Direction(az, el, targets.source[n], hour_angle, decides, gain, moment)


class _Information:
    """The information of recordings on some columns, to which directions are added."""

    def __init__(self, recorded: Array, ahead: Array):
        length = np.linalg.norm(recorded, axis=0)
        self.length = np.where(length > 0, length, 1.0)
        scaled = recorded / self.length
        self.matrix = scaled.T @ scaled + PRIOR * np.eye(scaled.shape[1])
        self.ahead = ahead / self.length

    def gains(self) -> Array:
        """Return how much the log-determinant grows by each direction, shape (targets,)."""
        seen = self.ahead @ self._inverse() @ self.ahead.transpose(0, 2, 1)
        return np.linalg.slogdet(np.eye(seen.shape[1]) + seen)[1]

    def add(self, n: int) -> None:
        """Add a direction."""
        self.matrix = self.matrix + self.ahead[n].T @ self.ahead[n]

    def sigmas(self) -> Array:
        """Return the errors of the coefficients of the columns."""
        return np.sqrt(np.diag(self._inverse())) / self.length

    def _inverse(self) -> Array:
        """Return the inverse; what was known before is not lost by rounding."""
        power, vectors = np.linalg.eigh(self.matrix)
        return (vectors / np.maximum(power, PRIOR)) @ vectors.T


class _Question:
    """How well the first of a pair is known beside its second and the model; if none, the model."""

    def __init__(self, design: Design, pair: Pair | None, targets: Targets):
        self.less: _Information | None = None
        if pair is None:
            ahead = _ahead(design, [], targets)
            self.size = max(1, ahead.shape[2])
            self.whole = _Information(design.model, ahead)
            return
        other, one = design.of(pair.other), design.of(pair.one)
        ahead = _ahead(design, [(pair.other.effect, pair.other.coefficients)], targets)
        own = _columns(design, pair.one.effect, pair.one.coefficients, targets)
        self.size = one.shape[1]
        self.less = _Information(np.concatenate([design.model, other], axis=1), ahead)
        self.whole = _Information(
            np.concatenate([design.model, other, one], axis=1), np.concatenate([ahead, own], axis=2)
        )
        self.first = self.whole.sigmas()[-self.size :]

    def gains(self) -> Array:
        """Return the gain of each direction for a coefficient of what is asked for."""
        return (self.whole.gains() - (self.less.gains() if self.less else 0.0)) / self.size

    def add(self, n: int) -> None:
        """Add a direction."""
        for one in filter(None, (self.whole, self.less)):
            one.add(n)

    def promise(self, pair: Pair) -> Promise:
        """Return what the directions so far promise."""
        worst = int(np.argmax(self.first))
        coefficient = pair.one.effect.coefficients[pair.one.coefficients[worst]]
        now = self.whole.sigmas()[-self.size :]
        return Promise(
            pair.one.effect.id,
            pair.other.effect.id,
            float(self.first[worst] / abs(coefficient.scale)),
            float(now[worst] / abs(coefficient.scale)),
            coefficient.unit,
        )


def _ahead(
    design: Design, more: Sequence[tuple[Effect, tuple[int, ...]]], targets: Targets
) -> Array:
    """Return the model's and other columns at the targets over the noise, (targets, axes, P)."""
    usual = {
        label: str(values[0])
        for label in ("antenna", "session")
        if len(values := np.unique(design.recordings.label(label).astype(str)))
    }
    parts = []
    for column in design.columns:
        shown = _columns(design, column.term.effect, (column.coefficient,), targets)
        held = all(
            usual.get(label, "") == value
            for label, value in zip(column.term.per, column.labels, strict=True)
        )
        parts.append(shown if held else np.zeros_like(shown))
    parts += [_columns(design, effect, kept, targets) for effect, kept in more]
    axes = len(_noise_of_axes(design))
    return np.concatenate([np.zeros((len(targets.az), axes, 0)), *parts], axis=2)


def _columns(design: Design, effect: Effect, kept: tuple[int, ...], targets: Targets) -> Array:
    """Return some columns of an effect at the targets, over the noise, (targets, axes, k)."""
    noise = _noise_of_axes(design)
    at = ahead_of(design.recordings, targets.az, targets.el)
    try:
        both = effect.columns(at)
    except MissingColumn:
        both = (np.zeros((len(at), max(kept) + 1)),) * 2
    shown = [both[axis][:, list(kept)] / sigma for axis, sigma in noise]
    return np.stack(shown, axis=1)


def _noise_of_axes(design: Design) -> list[tuple[int, float]]:
    """Return the axes that were measured and the typical noise on each [rad]."""
    is_y = design.stack.is_y
    return [
        (axis, float(np.median(design.noise[rows])))
        for axis, rows in ((0, ~is_y), (1, is_y))
        if rows.any()
    ]


def ahead_of(recordings: Recordings, az: Array, el: Array) -> Circumstances:
    """Return circumstances at other directions: the usual ones of the recordings."""
    at = recordings.at
    columns = {}
    for name, values in at.columns.items():
        if values.dtype.kind == "U":
            names, codes = np.unique(values, return_inverse=True)
            columns[name] = np.full(len(az), names[np.argmax(np.bincount(codes))])
        else:
            known = np.asarray(values, float)
            known = known[np.isfinite(known)]
            usual = float(np.median(known)) if len(known) else np.nan
            columns[name] = np.full(len(az), usual)
    if at.site is not None:
        columns["hour_angle"], columns["dec"] = sky.equator(az, el, at.site.latitude)
    return Circumstances(az, el, at.site, columns, mount=at.mount)


def directions(lowest_deg: float, highest_deg: float) -> Targets:
    """Return directions all over the sky between two elevations, rings at both among them."""
    grid = cells(lowest_deg)
    rings = [
        np.stack([np.arange(0, 360, 15.0) * DEG, np.full(24, el * DEG)], axis=1)
        for el in (lowest_deg, highest_deg)
    ]
    whole = np.concatenate([grid[grid[:, 1] <= highest_deg * DEG], *rings])
    return Targets(whole[:, 0], whole[:, 1], ("",) * len(whole))


def within_reach(at: Circumstances, targets: Targets) -> Targets:
    """Return the targets that a mount reaches; an alt-azimuth one those between elevations."""
    if at.mount is ALTAZ:
        return targets
    reached = at.mount.reaches(*axes_of(replace(at, az=targets.az, el=targets.el)))
    source = tuple(name for name, there in zip(targets.source, reached, strict=True) if there)
    time_s = None if targets.time_s is None else targets.time_s[reached]
    return Targets(targets.az[reached], targets.el[reached], source, time_s)


def on_axes(at: Circumstances, az_deg: float, el_deg: float) -> Mapping[str, float] | None:
    """Return the angles of the axes by their columns, None where the mount does not reach them."""
    mount = at.mount
    if mount is ALTAZ:
        return {}
    there = replace(at, az=np.array([az_deg * DEG]), el=np.array([el_deg * DEG]))
    angles = axes_of(there)
    if not mount.reaches(*angles)[0]:
        return None
    # a declination of date is none of the catalogue's
    of_date = "_of_date" if mount.second.column == "dec" else ""
    names = f"{mount.first.column}_deg", f"{mount.second.column}{of_date}_deg"
    return {name: float(one[0] / DEG) for name, one in zip(names, angles, strict=True)}


def of_sources(recordings: Recordings, lowest_deg: float, highest_deg: float) -> Targets | None:
    """Return where the recorded sources stand, hour by hour; None where they are not known."""
    at = recordings.at
    if at.site is None or "source" not in at or "dec" not in at:
        return None
    names, first = np.unique(at.column("source").astype(str), return_index=True)
    dec = np.asarray(at.column("dec"), float)[first]
    hours = np.arange(-11.5, 12, 0.5) * HOUR
    source = np.repeat(np.arange(len(names)), len(hours))
    az, el = sky.horizon(np.tile(hours, len(names)), dec[source], at.site.latitude)
    up = (el >= lowest_deg * DEG) & (el <= highest_deg * DEG) & (names[source] != "")
    if not up.any():
        return None
    return Targets(az[up], el[up], tuple(str(names[n]) for n in source[up]))
