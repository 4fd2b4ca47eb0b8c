"""Fields: sums of bumps over the sky, along a column or in time.

A diagnosis lays them through what no effect explains. Each field is given by a few
numbers, so that a file can hold it and it has a value at any place, not only where
recordings were made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array, Codes, cosine_between, separation
from pyport.effects.base import Circumstances, Coefficient, Effect
from pyport.effects.empirical.oscillations import SHORTEST_S
from pyport.effects.sky.frame import sun_seen

#: The id of what no effect of the catalogue explains.
UNKNOWN = "unknown"

Bumps = Mapping[str, Any]

#: A file may ask for any number of bumps: none is narrower than a quarter of a degree, which
#: makes 300,000 over the sky, and none of a column are more than a thousand.
NARROWEST_RAD, MOST_BUMPS = 0.0044, 1000


def sky(at: Circumstances, width_rad: float) -> Array:
    """Return bumps on the sphere, as far apart as they are wide, shape (n, K)."""
    bumps = []
    for height in np.arange(width_rad / 2, np.pi / 2 + width_rad / 2, width_rad):
        around = max(1, round(2 * np.pi * abs(np.cos(height)) / width_rad))
        centres = np.arange(around) * 2 * np.pi / around
        bumps += [cosine_between(centre, height, at.az, at.el) for centre in centres]
    return np.stack([np.exp((cosine - 1) / width_rad**2) for cosine in bumps], axis=1)


def wave(at: Circumstances, around: int, upward: int) -> Array:
    """Return waves that go around the sky and up it so often, shape (n, 2 or 4)."""
    circle = [np.cos(around * at.az), np.sin(around * at.az)]
    arc = [np.cos(upward * at.el), np.sin(upward * at.el)] if upward else [np.ones(len(at))]
    return np.stack([a * e for a in circle for e in arc], axis=1)


def azimuth(at: Circumstances, width_rad: float) -> Array:
    """Return bumps around the circle of azimuth, as far apart as they are wide, shape (n, K)."""
    centres = np.arange(0, 2 * np.pi, width_rad)
    return np.asarray(np.exp((np.cos(at.az[:, None] - centres) - 1) / width_rad**2))


def elevation(at: Circumstances, width_rad: float, centres_rad: Sequence[float]) -> Array:
    """Return bumps along elevation, shape (n, K)."""
    return _normal(at.el, np.asarray(centres_rad, float), width_rad)


def cycle(
    at: Circumstances,
    name: str,
    period_rad: float,
    count: int,
    from_rad: float | None = None,
    *,
    falls: bool = False,
) -> Array:
    """Return harmonics of what comes back along an angle, shape (n, 2 count).

    The m-th is smaller by m, so that what has drawn heights is rough as a random walk is. The angle
    is counted around a circle from `from_rad`, or as it is recorded, beyond a turn. With `falls`
    they fall as the cosine of the second angle, as what the first drive errs by does on the sky.
    """
    found = _harmonics(_counted(_along(at, name), from_rad) / period_rad, count)
    return found * _lever(at) if falls else found


def _lever(at: Circumstances) -> Array:
    """Return what an error of the first axis moves the beam by, shape (n, 1)."""
    sky = at if at.sky is None else at.sky
    return sky.onto_sky[:, None]


def repeat(at: Circumstances, period_s: float, since_s: float, count: int) -> Array:
    """Return harmonics, as those of `cycle`, of what comes back in time, shape (n, 2 count)."""
    return _harmonics((at.numbers("time") - since_s) / period_s, count)


def _harmonics(turns: Array, count: int) -> Array:
    order = np.arange(1, count + 1)
    phase = 2 * np.pi * turns[:, None] * order
    return np.concatenate([np.cos(phase), np.sin(phase)], axis=1) / np.tile(order, 2)


def _counted(angle: Array, from_rad: float | None) -> Array:
    return angle if from_rad is None else (angle - from_rad) % (2 * np.pi)


def within_period(bumps: Bumps, at: Circumstances) -> tuple[Array, str] | None:
    """Return how far into the period of what comes back each place is, shape (n,), and the unit.

    None for what has no period.
    """
    if bumps.get("kind") == "repeat":
        return (at.numbers("time") - bumps["since_s"]) % bumps["period_s"] / 60, "min"
    if bumps.get("kind") != "cycle":
        return None
    here = at.axes if bumps.get("in_axes") else at
    angle = _counted(_along(here, bumps["name"]), bumps.get("from_rad"))
    return angle % bumps["period_rad"] / DEG, "deg"


def column(at: Circumstances, name: str, count: int, values: Sequence[float]) -> Array:
    """Return bumps over the ranks that a column's numbers have among `values`, shape (n, K)."""
    return _ranked(_along(at, name), count, values)


def levels(at: Circumstances, name: str, values: Sequence[str | float]) -> Array:
    """Return 1 where a column has each of some values, shape (n, K): labels, or few numbers."""
    return (at.column(name)[:, None] == np.asarray(values)).astype(float)


def pair(
    at: Circumstances, names: Sequence[str], count: int, values: Sequence[Sequence[float]]
) -> Array:
    """Return products of bumps over the ranks of two columns, shape (n, K)."""
    one, other = (
        _ranked(_along(at, name), count, of) for name, of in zip(names, values, strict=True)
    )
    return (one[:, :, None] * other[:, None]).reshape(len(at), -1)


def _along(at: Circumstances, name: str) -> Array:
    """Return a column of numbers or an angle [rad]: azimuth as it was counted, beyond a turn."""
    angle = {"az_deg": at.az, "el_deg": at.el}.get(name)
    return at.numbers(name) if angle is None else angle


#: What moves less is tracked, not slewed to. [rad]
SLEW_RAD = 0.02


def last_slew(at: Circumstances) -> Array:
    """Return how far each antenna went in azimuth and elevation when it last slewed [rad], (2, n).

    A structure comes to rest slowly, and a drive that has play stands where it came from. NaN where
    an antenna has not slewed yet, or the time is unknown.
    """
    found = np.full((2, len(at)), np.nan)
    for rows, went in _steps(at):
        slewed = np.flatnonzero(np.abs(went).max(axis=0) > SLEW_RAD)
        last = np.searchsorted(slewed, np.arange(len(rows))) - 1
        found[:, rows[last >= 0]] = went[:, slewed[last[last >= 0]]]
    return found


def stepped(at: Circumstances) -> Array:
    """Return how far each antenna went to each reading, in the angle that changed more [rad], (n,).

    Zero to the first, and where the time is unknown.
    """
    found = np.zeros(len(at))
    for rows, went in _steps(at):
        found[rows[1:]] = np.abs(went).max(axis=0)
    return found


def _steps(at: Circumstances) -> Iterator[tuple[Codes, Array]]:
    """Yield for each antenna its rows in order of time, (r,), and its way between, (2, r - 1)."""
    time, angles = at.numbers("time"), np.stack([at.az, at.el])
    antennas = at.column("antenna") if "antenna" in at else np.zeros(len(at))
    for one in np.unique(antennas):
        rows = np.flatnonzero((antennas == one) & np.isfinite(time))
        rows = rows[np.argsort(time[rows], kind="stable")]
        yield rows, np.diff(angles[:, rows])


def slew(at: Circumstances, name: str, count: int, values: Sequence[float]) -> Array:
    """Return bumps over the ranks of how far the last slew went in an angle, shape (n, K)."""
    return _ranked(last_slew(at)[int(name != "az_deg")], count, values)


def from_sun(at: Circumstances) -> Array:
    """Return how far from the Sun each direction is [rad], shape (n,)."""
    return separation(*sun_seen(at), at.az, at.el)


def sun(at: Circumstances, count: int, values: Sequence[float]) -> Array:
    """Return bumps over the ranks of the distance from the Sun, shape (n, K)."""
    return _ranked(from_sun(at), count, values)


def _ranked(here: Array, count: int, values: Sequence[float]) -> Array:
    ordered = np.sort(np.asarray(values, float))
    rank = np.searchsorted(ordered, here) / len(ordered)
    bumps = _normal(rank, np.linspace(0, 1, count), 1 / (count - 1))
    return np.where(np.isfinite(here)[:, None], bumps, 0.0)


def time(at: Circumstances, length_s: float, centres_s: Sequence[float]) -> Array:
    """Return bumps in time, shape (n, K)."""
    return np.nan_to_num(_normal(at.numbers("time"), np.asarray(centres_s, float), length_s))


def box(at: Circumstances, az_rad: Sequence[float], el_rad: Sequence[float]) -> Array:
    """Return 1 inside a stretch of azimuth and of elevation, shape (n, 1)."""
    return inside(at.az % (2 * np.pi), at.el, (*az_rad, *el_rad))[:, None].astype(float)


def sector(at: Circumstances, az_rad: Sequence[float]) -> Array:
    """Return what an error of the first angle in a stretch of it does on the sky, shape (n, 1)."""
    return _between(at.az, *az_rad)[:, None] * _lever(at)


def inside(az: Array, el: Array, edges: Sequence[float] | Array) -> NDArray[np.bool_]:
    """Tell which places are between two azimuths and two elevations [rad], shape (n,)."""
    left, right, low, high = edges
    return _between(az, left, right) & (el >= low) & (el <= high)


def _between(az: Array, left: float, right: float) -> NDArray[np.bool_]:
    return np.asarray((az - left) % (2 * np.pi) <= right - left)


def stretch(at: Circumstances, name: str, low_rad: float, high_rad: float) -> Array:
    """Return 1 inside a stretch of azimuth or elevation, shape (n, 1)."""
    values = at.az % (2 * np.pi) if name == "az_deg" else at.el
    return ((values >= low_rad) & (values <= high_rad))[:, None].astype(float)


def curve(at: Circumstances, name: str, low: float, high: float, order: int) -> Array:
    """Return Legendre polynomials of a column between two values of it, shape (n, order).

    Outside they stay as they are at the ends; what is not known has none.
    """
    here = _along(at, name)
    if name == "az_deg":  # recordings may have counted on beyond a turn
        here = np.where((here < low) | (here > high), low + (here - low) % (2 * np.pi), here)
    spread = np.clip(2 * (here - low) / (high - low) - 1, -1.0, 1.0)
    found = np.polynomial.legendre.legvander(spread, order)[:, 1:]
    return np.where(np.isfinite(here)[:, None], found, 0.0)


def waves(at: Circumstances, each: Sequence[Sequence[int]]) -> Array:
    """Return several waves, each given by how often it goes around and up, shape (n, K)."""
    return np.concatenate([wave(at, around, upward) for around, upward in each], axis=1)


def _normal(values: Array, centres: Array, width: float) -> Array:
    return np.asarray(np.exp(-0.5 * ((values[:, None] - centres) / width) ** 2))


_FORMS = (
    *(sky, wave, waves, azimuth, elevation, cycle, box, sector, stretch),
    *(column, levels, pair, curve, slew, sun, time, repeat),
)
KINDS: dict[str, Callable[..., Array]] = {one.__name__: one for one in _FORMS}


def values(bumps: Bumps, at: Circumstances) -> Array:
    """Return the bumps that `{"kind": one of KINDS, ...}` stands for, shape (n, K).

    With `"in_axes": true` azimuth and elevation are the angles of the mount's axes.
    """
    settings = dict(bumps)
    here = at.axes if settings.pop("in_axes", False) else at
    return KINDS[settings.pop("kind")](here, **settings)


def field(
    bumps: Bumps,
    axes: Sequence[int],
    which: Sequence[int],
    directions: Sequence[Sequence[float]],
    family: str,
    variant: str,
    spread: Sequence[float] = (),
) -> Effect:
    """Return a field as an effect that nobody may name.

    `bumps`: see `values`.
    `axes`, `which`: of each of k terms the axis that it acts on (0 across, 1 along elevation), and
      its bump.
    `directions`: how many of each term one of each coefficient is, shape (k, dof).
    `family`, `variant`: what kind of field it is, and which of its kind.
    `spread`: one sigma of each coefficient before any recordings [rad]; none where they are free.
    Raises `ValueError`: there are no such bumps, or more than any recordings determine.
    """
    if bumps["kind"] not in KINDS:
        raise ValueError(f"no field is made of {bumps['kind']!r}")
    counts = (bumps.get(name, 2) for name in ("count", "order", "around", "upward"))
    each = bumps.get("each", ())
    count = max(*counts, len(each), *(one for pair in each for one in pair))
    narrowest = min(bumps.get("width_rad", 1.0), bumps.get("period_rad", 1.0))
    shortest = bumps.get("period_s", SHORTEST_S)
    if narrowest < NARROWEST_RAD or shortest < SHORTEST_S or count > MOST_BUMPS:
        raise ValueError("a field of more bumps than any recordings determine")
    along = np.asarray(axes)[:, None] == (0, 1)
    mix = np.asarray(directions, float)
    of_term = [int(one) for one in which]
    if mix.ndim != 2 or not len(mix) == len(along) == len(of_term):
        raise ValueError("a field needs an axis, a bump and directions for each term")
    if len(spread) not in {0, mix.shape[1]} or any(one <= 0 for one in spread):
        raise ValueError("a field needs a spread above zero for each direction, or none")

    def basis(at: Circumstances) -> tuple[Array, Array]:
        terms = values(bumps, at)[:, of_term]
        return terms @ (mix * along[:, :1]), terms @ (mix * along[:, 1:])

    return Effect(
        UNKNOWN,
        f"{family}, {variant}",
        "a field, no physics",
        tuple(Coefficient(f"field_{n + 1}") for n in range(mix.shape[1])),
        basis,
        physical=False,
        variant=variant,
        needs=_needs(bumps),
        member={
            "bumps": dict(bumps),
            "axes": [int(one) for one in axes],
            "which": of_term,
            "directions": mix.tolist(),
            "family": family,
            "variant": variant,
        }
        | ({"spread": [float(one) for one in spread]} if len(spread) else {}),
        make=field,
        prior=tuple(float(one) for one in spread),
    )


def _needs(bumps: Bumps) -> tuple[str, ...]:
    if bumps["kind"] == "sun":
        return ("sun_az_deg and sun_el_deg, or time_utc with latitude_deg and longitude_deg",)
    if bumps["kind"] in {"time", "slew", "repeat"} or bumps.get("name") == "time":
        return ("time_utc",)
    one = bumps["kind"] in {"column", "curve", "levels"}
    names = bumps.get("names", (bumps["name"],) if one else ())
    return tuple(one for one in names if one not in {"az_deg", "el_deg"})
