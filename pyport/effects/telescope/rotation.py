"""Rotation of the image: platforms that do not follow elevation, rotators, the field itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, RADIANS_PER, Array
from pyport.effects.base import AXES, Circumstances, Coefficient, Effect, MissingColumn, stack
from pyport.effects.circumstances import mostly_known
from pyport.effects.sky.frame import hour_angle_shift

_TPOINT = "Wallace, TPOINT Telescope Pointing Analysis System, terms NRX and NRY"
_WALLACE = "Wallace 2002, Proc. SPIE 4848, 125: a rotator whose axis is not where the beam is"

#: The image must turn by this much: over a shorter arc a circle leaves its chord by less than a
#: seventh of its radius, and a straight line in the same column fits as well. [rad]
LEAST_ARC = 60 * DEG
#: So many columns are tried, those that turn furthest; two senses and two rates each make 20.
MOST_COLUMNS = 5
#: A K-mirror and a prism turn the image by twice their angle. Half of a recorded angle is not
#: tried: an angle that was recorded modulo 360 deg has none.
RATES = (1, 2)
#: Parts of a column's name that say that it is a place, an offset, an error or a size.
PLACES = frozenset(
    {
        *("az", "azimuth", "el", "elevation", "alt", "altitude", "zd", "za", "zenith"),
        *("ra", "dec", "ha", "lst", "lat", "latitude", "lon", "longitude"),
    }
)
#: Those that say that a column holds what was measured here, or what a model makes of it.
MEASURED = frozenset({"d", "delta", "model", "residual", "res"})
OFFSETS_AND_SIZES = MEASURED | {
    *("offset", "off", "shift", "correction", "corr"),
    *("sigma", "err", "error", "rms", "std", "sd"),
    *("fwhm", "beam", "width", "size", "seeing", "separation"),
}
#: An angle that has one of these in its name turns no image.
NO_ROTATION = (
    PLACES
    | OFFSETS_AND_SIZES
    | {
        *("sun", "moon", "wind", "dome"),
        *("slew", "slewed", "distance", "dist", "travel", "step", "lag", "length", "move", "moved"),
    }
)

Angle = Callable[[Circumstances], Array]


def nasmyth(sense: int) -> Effect:
    """Return the offset of a receiver that stays on its platform while the tube turns.

    `sense` is +1 where the image turns with elevation, as on the platform at the right of
    somebody who looks along the beam, -1 where it turns against it. The coefficients are the
    offset at the horizon; TPOINT's NRX and NRY are the first and minus the second, at sense +1.
    """
    return Effect(
        "nasmyth",
        "what receives is off the elevation axis and stays where it is while the tube turns",
        _TPOINT,
        (Coefficient("nasmyth_xel"), Coefficient("nasmyth_el")),
        lambda at: _circle(at, sense * at.el),
        variant="platform on the right" if sense > 0 else "platform on the left",
        profile=lambda _: (nasmyth(1), nasmyth(-1)),
        acts_in=AXES,
        mounts=("altaz",),
        pattern="a circle in both axes that turns with elevation",
        means={"nasmyth": "a receiver or camera off the elevation axis, on its platform"},
        formula=("b cos E -+ c sin E", "+-b sin E + c cos E, the sign by the side of the platform"),
        member={"sense": sense},
        make=nasmyth,
    )


def _circle(at: Circumstances, angle: Array) -> tuple[Array, Array]:
    """Return (x, y) of an offset in each axis that is turned counterclockwise by an angle."""
    return stack(at, (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle)))


def parallactic_angle(at: Circumstances) -> Array:
    """Return how the sky turns beside the mount's second axis [rad], positive west of the meridian.

    On an alt-azimuth mount the parallactic angle; on an equatorial one the sky does not turn.
    """
    across, along = at.along_axes(*hour_angle_shift(at))
    return np.arctan2(-along, across)


def angle_columns(at: Circumstances) -> dict[str, Array]:
    """Return the recorded angles that may turn an image [rad], NaN where unknown.

    Numbers whose name ends in a unit of angle and does not say that they are a direction, an
    offset or a size; the contract's angles are all of these. Half of the rows must have them.
    """
    found: dict[str, Array] = {}
    for name, values in at.columns.items():
        quantity, _, unit = name.rpartition("_")
        is_angle = quantity and unit in RADIANS_PER and unit != "h"
        if not is_angle or values.dtype.kind not in "fiu" or NO_ROTATION & set(quantity.split("_")):
            continue
        angle = np.asarray(values, float) * RADIANS_PER[unit]
        if mostly_known(angle):
            found[name] = angle
    return found


def arc(angle: Array) -> float:
    """Return the shortest arc that holds all known angles [rad]."""
    around = np.unique(angle[np.isfinite(angle)] % (2 * np.pi))
    if len(around) < 2:
        return 0.0
    gaps = np.diff(around, append=around[0] + 2 * np.pi)
    return float(2 * np.pi - gaps.max())


def _turning(name: str, angle: Angle, member: Mapping[str, str | int]) -> Effect:
    """Return the circle in an angle, given as what it is called and how it is read."""
    return Effect(
        "rotator_circle",
        "what turns the image, or turns with it, is off its axis",
        _WALLACE,
        (Coefficient("circle_xel"), Coefficient("circle_el")),
        lambda at: _circle(at, angle(at)),
        variant=f"phi = {name}",
        profile=_turnings,
        pattern=f"a circle in both axes that turns with {name}",
        needs=("rotator_deg or latitude_deg",),
        formula=(
            "b cos phi - c sin phi",
            "b sin phi + c cos phi, phi +- a recorded angle, +- twice",
        ),
        member=dict(member),
        make=_made,
    )


def _made(angle: str = "", times: int = 1) -> Effect:
    """Return the circle that a file tells: in a recorded angle, or in the parallactic angle."""
    return _recorded(angle, times) if angle else _by_the_field(times)


def _recorded(column: str, times: int) -> Effect:
    """Return the circle in a multiple of a recorded angle."""
    scale = times * RADIANS_PER[column.rpartition("_")[2]]
    sign = "-" if times < 0 else ""
    name = f"{sign}{'' if abs(times) == 1 else f'{abs(times)} '}{column}"
    member: dict[str, str | int] = {"angle": column, "times": times}
    return _turning(name, lambda at: scale * at.numbers(column), member)


#: What the circle in the field's angle lacks: nothing says that anything turns there.
_ROTATOR = "record the angle of what turns the image: where nothing does it is something else"


def _by_the_field(sense: int) -> Effect:
    """Return the circle in the parallactic angle; at sense -1 it is fixed to the sky."""
    name = f"{'-' if sense < 0 else ''}parallactic angle"
    circle = _turning(name, lambda at: sense * parallactic_angle(at), {"times": sense})
    return replace(circle, wants=_ROTATOR)


def _turnings(at: Circumstances) -> tuple[Effect, ...]:
    """Return circles in every angle that turned far enough, both ways."""
    columns = angle_columns(at)
    furthest = sorted(columns, key=lambda name: -arc(columns[name]))[:MOST_COLUMNS]
    found = [
        _recorded(name, sense * rate)
        for name in furthest
        for rate in RATES
        if arc(rate * columns[name]) >= LEAST_ARC
        for sense in (1, -1)
    ]
    if at.site is not None:
        field = parallactic_angle(at)
        known = any(_alike(field, columns[name]) for name in furthest)
        if arc(field) >= LEAST_ARC and not known:
            found += [_by_the_field(1), _by_the_field(-1)]
    if not found:
        lacking = not columns and at.site is None
        raise MissingColumn("rotator_deg or latitude_deg" if lacking else "60 deg of rotation")
    return tuple(found)


def _alike(one: Array, other: Array) -> bool:
    """Tell whether two angles [rad] are one, but for its sign and zero, to a degree."""
    known: NDArray[np.bool_] = np.isfinite(one) & np.isfinite(other)
    return any(arc((one - sense * other)[known]) < DEG for sense in (1, -1))


EFFECTS = (nasmyth(1), _by_the_field(1))
