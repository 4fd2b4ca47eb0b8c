"""The structure: a part that is loose, and jumps when the load turns over."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.angles import DEG, Array
from pyport.effects.base import (
    AXES,
    SKY,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.effects.mounts import on
from pyport.mounts import ALTAZ

Edge = Callable[[Array], Array]

#: So many straight edges are tried in elevation, and in azimuth: a first guess of the curve.
MOST_EDGES = 7
#: A file tells an edge on at most so many levels of elevation: a degree each, and some more.
MOST_LEVELS = 1000
#: What steps: by the axis of a member, elevation without one.
STEPS = {"": "elevation", "first": "azimuth", "second": "elevation"}
_FORMULAE = ("", "j above a curve in the sky"), ("j cos E above a curve in the sky", "")
#: How far the leaning edges that are tried rise and fall with azimuth. [rad]
LEAN = 10 * DEG


def subreflector_jump(
    edge: Edge,
    name: str,
    parameter: float | None = None,
    member: Mapping[str, Any] | None = None,
    share: Callable[[Array, Array], Array] | None = None,
    axis: str = "",
) -> Effect:
    """Return a step in elevation above a curve in the sky.

    `edge`: azimuth (from north through east, unwrapped) -> elevation of the curve [rad].
    `name`: what to call this curve in a report.
    `parameter`: where a straight edge stands [rad].
    `member`: the curve as a file holds it: see `Effect`.
    `share`: azimuth, elevation -> how much of the step is there, for an edge that is known only so
      well; by default all of it at the curve and above.
    `axis`: which axis of the mount steps, "first" or "second", at a curve in the angles of both;
      the curve is in azimuth and elevation without it.
    """
    if axis not in STEPS:
        raise ValueError(f"no axis is called {axis!r}")

    def basis(at: Circumstances) -> tuple[Array, Array]:
        there = np.where(at.el >= edge(at.az), 1.0, 0.0) if share is None else share(at.az, at.el)
        return stack(at, (there * np.cos(at.el), 0) if axis == "first" else (0, there))

    return Effect(
        "subreflector_jump",
        "something gives way where the telescope crosses a curve in the sky",
        "Borkowski, RT32 Pointing Model (2004), eq. 19 and routine Hjump",
        (Coefficient("jump"),),
        basis,
        variant=f"in {STEPS[axis]}, {name}" if axis else name,
        profile=_edges_tried,
        acts_in=AXES if axis else SKY,
        pattern=f"a step in {STEPS[axis]} at a curve in the sky",
        means={"secondary": "a loose secondary mirror"},
        formula=_FORMULAE[axis == "first"],
        parameter=parameter,
        edge=edge,
        member={**(member or {}), **({"axis": axis} if axis else {})},
        make=_jump,
    )


def _jump(
    above_el_rad: float | None = None,
    beyond_az_rad: float | None = None,
    wave_rad: Sequence[float] = (),
    edge_az_rad: Sequence[float] = (),
    edge_el_rad: Sequence[float] = (),
    share: Mapping[str, Any] | None = None,
    axis: str = "",
) -> Effect:
    """Return a jump at the edge that a file tells: a straight one, a wave, or one of any form."""
    if beyond_az_rad is not None:
        return _beyond(beyond_az_rad, axis)
    if wave_rad:
        return curved_jump(tuple(wave_rad), axis)
    if edge_az_rad:
        edge = FreeEdge(tuple(edge_az_rad), tuple(edge_el_rad))
        return jump_above(edge, None if share is None else SoftEdge.of(**share), axis)
    return _above(60 * DEG if above_el_rad is None else above_el_rad, axis)


def elsewhere(effect: Effect, **where: Any) -> Effect:  # noqa: ANN401 - what a file may hold
    """Return a jump at another edge: of the same axis, in the words of the same mount."""
    return (effect.make or _jump)(**where, axis=effect.member.get("axis", ""))


def jump_at(member: Mapping[str, Any]) -> Callable[[float, float], tuple[float, float]]:
    """Return the offsets of a jump of one in one direction [rad], as arrays of one have them."""
    above = _above_at(member)
    if member.get("axis") == "first":
        return lambda az, el: (above(az, el) * math.cos(el), 0.0)
    return lambda az, el: (0.0, above(az, el))


def _above_at(member: Mapping[str, Any]) -> Callable[[float, float], float]:
    """Return how much of a jump there is in one direction [rad]."""
    if "beyond_az_rad" in member:
        az_edge = float(member["beyond_az_rad"])
        return lambda az, _: 1.0 if az >= az_edge else 0.0
    if "wave_rad" in member:
        height, *waves = map(float, member["wave_rad"])

        def above_wave(az: float, el: float) -> float:
            curve = height + waves[0] * math.cos(az) + waves[1] * math.sin(az)
            curve += waves[2] * math.cos(2 * az) + waves[3] * math.sin(2 * az)
            return 1.0 if el >= curve else 0.0

        return above_wave
    if "edge_az_rad" in member:
        basis = _jump(**{**member, "axis": ""}).basis

        def above_edge(az: float, el: float) -> float:
            return float(basis(Circumstances(np.array([az]), np.array([el])))[1][0, 0])

        return above_edge
    el_edge = float(member.get("above_el_rad", 60 * DEG))
    return lambda _, el: 1.0 if el >= el_edge else 0.0


def _nearest_turn(az: Array, low: float, high: float) -> Array:
    """Return azimuths [rad], those outside a span brought by whole turns to where they are nearest.

    A curve is known between the azimuths of the recordings that it was found in, counted as the
    cable was; other programs count 0 to 360 deg.
    """
    turns = np.round((az - (low + high) / 2) / (2 * np.pi))
    return np.where((az < low) | (az > high), az - 2 * np.pi * turns, az)


@dataclass(frozen=True)
class FreeEdge:
    """A curve of any form: straight pieces between elevations given at azimuths."""

    #: `az`, `el`: azimuths (unwrapped, growing) and elevations of its corners [rad].
    az: tuple[float, ...]
    el: tuple[float, ...]

    def __call__(self, az: Array) -> Array:
        """Return the elevation of the curve at some azimuths [rad]."""
        return np.interp(_nearest_turn(az, *self.span), self.az, self.el)

    @property
    def span(self) -> tuple[float, float]:
        """Return the azimuths between which it is known [rad]."""
        return self.az[0], self.az[-1]


@dataclass(frozen=True)
class SoftEdge:
    """How much of a step is there, where its edge is known only so well."""

    #: `start`, `width`: azimuth at which the first column begins, and how wide each is [rad].
    start: float
    width: float
    #: For each column and degree of elevation the share of the step, shape (columns, levels): level
    #: n holds elevations from n - 1 to n degrees above the lowest.
    share: Array
    lowest_deg: float = 0.0

    @classmethod
    def of(
        cls,
        start_rad: float,
        width_rad: float,
        levels: int,
        rows: Sequence[Any],
        lowest_deg: float = 0.0,
    ) -> SoftEdge:
        """Return it from what a file holds: see `member`."""
        if not 0 < levels <= MOST_LEVELS:
            raise ValueError(f"an edge of {levels} levels of elevation")
        share = np.zeros((len(rows), levels))
        for column, (first, *values) in zip(share, rows, strict=True):
            column[first : first + len(values)] = values
            column[first + len(values) :] = values[-1] if values else 0.0
        return cls(start_rad, width_rad, share, lowest_deg)

    def __call__(self, az: Array, el: Array) -> Array:
        """Return the share of the step at some places [rad]."""
        columns, levels = self.share.shape
        near = _nearest_turn(az, self.start, self.start + columns * self.width)
        first = round(self.start / self.width)
        column = np.clip(np.floor(near / self.width).astype(int) - first, 0, columns - 1)
        level = np.clip((el / DEG - self.lowest_deg).astype(int) + 1, 0, levels - 1)
        return np.asarray(self.share[column, level])

    @property
    def member(self) -> dict[str, Any]:
        """Return it as a file holds it, a row for each column.

        First comes the first level at which the share is not zero, then the shares from there
        on, the last of which holds on.
        """
        rows = []
        for column in self.share:
            first = int(np.argmax(column > 0)) if column.any() else 0
            changes = np.flatnonzero(np.diff(column[first:]))
            last = first + (int(changes[-1]) + 1 if len(changes) else 0)
            rows.append([first, *column[first : last + 1].tolist()])
        return {
            "start_rad": self.start,
            "width_rad": self.width,
            "levels": self.share.shape[1],
            "rows": rows,
        } | ({"lowest_deg": self.lowest_deg} if self.lowest_deg else {})


def jump_above(edge: FreeEdge, soft: SoftEdge | None = None, axis: str = "") -> Effect:
    """Return a step above a curve of any form, soft where the curve is known only so well."""
    variant = _above_curve(np.array(edge.el) / DEG, np.array(edge.az) / DEG, axis)
    member: dict[str, Any] = {
        "edge_az_rad": [float(one) for one in edge.az],
        "edge_el_rad": [float(one) for one in edge.el],
    }
    if soft is not None:
        member["share"] = soft.member
    return subreflector_jump(edge, variant, edge.el[0], member, soft, axis)


def curved_jump(shape: tuple[float, ...], axis: str = "") -> Effect:
    """Return a step above a curve that waves once and twice with azimuth.

    `shape` holds the curve's height and its cosine and sine once and twice
    around [rad].
    """

    def edge(az: Array) -> Array:
        waves = (np.ones(len(az)), np.cos(az), np.sin(az), np.cos(2 * az), np.sin(2 * az))
        return np.asarray(sum(one * wave for one, wave in zip(shape, waves, strict=True)))

    around = np.arange(360.0)
    variant = _above_curve(edge(np.radians(around)) / DEG, around, axis)
    member = {"wave_rad": [float(one) for one in shape]}
    return subreflector_jump(edge, variant, shape[0], member, axis=axis)


def _above_curve(el_deg: Array, az_deg: Array, axis: str) -> str:
    """Return in words what is above a curve, a level one where it rises by less than a degree."""
    low, high = el_deg.min(), el_deg.max()
    if high - low < 1:
        return f"above elevation {(low + high) / 2:.1f} deg"
    top = _counted(float(az_deg[el_deg.argmax()]), axis)
    return f"above a curve from {low:.0f} to {high:.0f} deg, highest at azimuth {top:.0f} deg"


def _counted(az_deg: float, axis: str) -> float:
    """Return an azimuth from 0 to 360 deg, the angle of another first axis from -180 to 180."""
    return (az_deg + 180) % 360 - 180 if axis else az_deg % 360


def _above(el: float, axis: str = "") -> Effect:
    name, member = f"above elevation {el / DEG:.1f} deg", {"above_el_rad": el}
    return subreflector_jump(lambda az: np.full(len(az), el), name, el, member, axis=axis)


def _beyond(az: float, axis: str = "") -> Effect:
    name, member = f"beyond azimuth {az / DEG:.1f} deg", {"beyond_az_rad": az}
    return subreflector_jump(
        lambda there: np.where(there >= az, -np.inf, np.inf), name, az, member, axis=axis
    )


def _tilted_edges(el: Array, axis: str) -> list[Effect]:
    """Return steps above circles that lean: a first guess of a curve that waves with azimuth."""
    leans = [LEAN * np.array([np.cos(a), np.sin(a)]) for a in np.radians(np.arange(0, 360, 90))]
    heights = np.unique(np.quantile(el, (0.4, 0.7)))
    return [
        curved_jump((float(height), float(lean[0]), float(lean[1]), 0.0, 0.0), axis)
        for height in heights
        for lean in leans
    ]


def _edges_tried(at: Circumstances) -> tuple[Effect, ...]:
    """Return steps at straight edges, an eighth of the rows apart, and above leaning circles.

    On a mount with other axes than azimuth and elevation those of either axis too.
    """
    found = _edges_of(at, "")
    if at.mount is not ALTAZ:
        own = [one for axis in ("first", "second") for one in _edges_of(at.axes, axis)]
        found += [on(one, at.mount) for one in own]
    if not found:
        raise MissingColumn("a second direction")
    return tuple(found)


def _edges_of(at: Circumstances, axis: str) -> list[Effect]:
    """Return the edges in some angles: of an axis also where the load on it turns over, at zero."""
    shares = np.arange(1, MOST_EDGES + 1) / (MOST_EDGES + 1)
    zero = [0.0] if axis else []
    found = [
        make(float(value), axis)
        for make, where in ((_above, at.el), (_beyond, at.az))
        for value in np.unique([*np.quantile(where, shares), *zero])
        if where.min() < value <= where.max()
    ]
    return [*found, *_tilted_edges(at.el, axis)] if found else []


EFFECTS = (_above(60 * DEG),)
