"""The structure: a part that is loose, and jumps when the load turns over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.effects.base import Circumstances, Coefficient, Effect, MissingColumn, stack

Edge = Callable[[Array], Array]

#: So many straight edges are tried in elevation, and in azimuth: a first guess of the curve.
MOST_EDGES = 7
#: How far the leaning edges that are tried rise and fall with azimuth. [rad]
LEAN = 10 * DEG


def subreflector_jump(edge: Edge, name: str, parameter: float | None = None) -> Effect:
    """Return a step in elevation above a curve in the sky.

    Parameters
    ----------
    edge
        Azimuth (from north through east, unwrapped) -> elevation of the curve [rad].
    name
        What to call this curve in a report.
    parameter
        Where a straight edge stands [rad].
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (0, np.where(at.el >= edge(at.az), 1.0, 0.0)))

    return Effect(
        "subreflector_jump",
        "something gives way where the telescope crosses a curve in the sky",
        "Borkowski, RT32 Pointing Model (2004), eq. 19 and routine Hjump",
        (Coefficient("jump"),),
        basis,
        variant=name,
        profile=_edges_tried,
        pattern="a step in elevation at a curve in the sky",
        means={"secondary": "a loose secondary mirror"},
        formula=("", "j above a curve in the sky"),
        parameter=parameter,
        edge=edge,
    )


@dataclass(frozen=True)
class FreeEdge:
    """A curve of any form: straight pieces between elevations given at azimuths.

    Attributes
    ----------
    az, el
        Azimuths (unwrapped, growing) and elevations of its corners [rad].
    """

    az: tuple[float, ...]
    el: tuple[float, ...]

    def __call__(self, az: Array) -> Array:
        """Return the elevation of the curve at some azimuths [rad]."""
        return np.interp(az, self.az, self.el)

    @property
    def span(self) -> tuple[float, float]:
        """Return the azimuths between which it is known [rad]."""
        return self.az[0], self.az[-1]


def jump_above(edge: FreeEdge) -> Effect:
    """Return a step above a curve of any form."""
    el = np.array(edge.el) / DEG
    top = int(np.argmax(el))
    name = f"above a curve from {el.min():.0f} to {el.max():.0f} deg, highest at azimuth"
    return subreflector_jump(edge, f"{name} {np.degrees(edge.az[top]) % 360:.0f} deg", edge.el[0])


def curved_jump(shape: tuple[float, ...]) -> Effect:
    """Return a step above a curve that waves once and twice with azimuth.

    `shape` holds the curve's height and its cosine and sine once and twice
    around [rad].
    """

    def edge(az: Array) -> Array:
        waves = (np.ones(len(az)), np.cos(az), np.sin(az), np.cos(2 * az), np.sin(2 * az))
        return np.asarray(sum(one * wave for one, wave in zip(shape, waves, strict=True)))

    el = edge(np.radians(np.arange(360.0))) / DEG
    name = f"above a curve from {el.min():.0f} to {el.max():.0f} deg, highest at azimuth"
    return subreflector_jump(edge, f"{name} {int(el.argmax())} deg", shape[0])


def _above(el: float) -> Effect:
    name = f"above elevation {el / DEG:.1f} deg"
    return subreflector_jump(lambda az: np.full(len(az), el), name, el)


def _beyond(az: float) -> Effect:
    name = f"beyond azimuth {az / DEG:.1f} deg"
    return subreflector_jump(lambda there: np.where(there >= az, -np.inf, np.inf), name, az)


def _tilted_edges(el: Array) -> list[Effect]:
    """Return steps above circles that lean: a first guess of a curve that waves with azimuth."""
    leans = [LEAN * np.array([np.cos(a), np.sin(a)]) for a in np.radians(np.arange(0, 360, 90))]
    heights = np.unique(np.quantile(el, (0.4, 0.7)))
    return [
        curved_jump((float(height), float(lean[0]), float(lean[1]), 0.0, 0.0))
        for height in heights
        for lean in leans
    ]


def _edges_tried(at: Circumstances) -> tuple[Effect, ...]:
    """Return steps at straight edges, an eighth of the rows apart, and above leaning circles."""
    shares = np.arange(1, MOST_EDGES + 1) / (MOST_EDGES + 1)
    found = [
        make(float(value))
        for make, where in ((_above, at.el), (_beyond, at.az))
        for value in np.unique(np.quantile(where, shares))
        if where.min() < value
    ]
    if not found:
        raise MissingColumn("a second direction")
    return (*found, *_tilted_edges(at.el))


EFFECTS = (_above(60 * DEG),)
