"""What comes back: offsets from day to day, mirror images of the arms, jumps at transit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, HOUR, Array
from pyport.studies.gmrt.curves import Curve, Track, line

#: The paper's own list: section 5 (b).
NAMED = ("C12", "C13", "E03", "S03", "W02")

#: An antenna whose level moves by less repeats as well as any beam needs [rad].
REPEATS_WITHIN = 2 * ARCMIN

#: How far beyond the common hour angles scans are taken [rad].
BEYOND = 1 * HOUR

#: Chance below which days differ at all.
CHANCE = 1e-3


@dataclass(frozen=True)
class Repeat:
    """One antenna on several days."""

    antenna: str  #: whose
    #: Session -> mean offset over the days' common hour angles relative to the first day, with its
    #: sigma [rad].
    level: dict[str, tuple[float, float]]
    p_value: float  #: chance of levels so different if the days were alike (F test)
    scatter: float  #: of a scan about its day's level [rad]

    @property
    def spread(self) -> float:
        """Return the largest difference between two days [rad]."""
        levels = [value for value, _ in self.level.values()]
        return max(levels) - min(levels)

    @property
    def repeats(self) -> bool:
        """Tell whether the days are alike, or differ by little."""
        return self.p_value > CHANCE or self.spread <= REPEATS_WITHIN


def repeatability(found: Sequence[Track]) -> list[Repeat]:
    """Return the test for every antenna with two days or more, the least repeatable first.

    Days share a cubic in hour angle; each has its own half-difference between
    forward and reverse, and may have its own level. Compared are the hour
    angles that all days of the antenna reach, and a little beyond.
    """
    days: dict[str, list[Track]] = {}
    for track in found:
        days.setdefault(track.antenna, []).append(track)
    tests = [_test(own) for own in days.values() if len(own) > 1]
    return sorted((test for test in tests if test), key=lambda test: -test.spread)


def _test(own: Sequence[Track]) -> Repeat | None:
    """Return the test of one antenna, None where fewer than two days can be compared."""
    from scipy.stats import f

    low = max(float(track.hour_angle.min()) for track in own) - BEYOND
    high = min(float(track.hour_angle.max()) for track in own) + BEYOND
    parts = [(track, (track.hour_angle >= low) & (track.hour_angle <= high)) for track in own]
    parts = [(track, part) for track, part in parts if _both_ways(track.direction[part])]
    if len(parts) < 2:
        return None
    day = np.repeat(np.arange(len(parts)), [int(part.sum()) for _, part in parts])
    hours, offset, direction = (
        np.concatenate([getattr(track, name)[part] for track, part in parts])
        for name in ("hour_angle", "offset", "direction")
    )
    each = (day[:, None] == np.arange(len(parts))).astype(float)
    powers = np.vander(hours / HOUR / 3, 4)
    alike = np.concatenate([powers, each * direction[:, None]], axis=1)
    apart = line(np.concatenate([each[:, 1:], alike], axis=1), offset)
    # the same weights for both, or the comparison is none
    root = np.sqrt(apart.weight)
    common = np.linalg.lstsq(alike * root[:, None], offset * root, rcond=None)[0]
    squares = float((apart.weight * (offset - alike @ common) ** 2).sum())
    more = len(parts) - 1
    ratio = max(0.0, squares - apart.squares) / more / (apart.squares / apart.spare)
    level = {parts[0][0].session: (0.0, 0.0)}
    for k, (track, _) in enumerate(parts[1:]):
        level[track.session] = (float(apart.value[k]), float(apart.sigma[k]))
    return Repeat(own[0].antenna, level, float(f.sf(ratio, more, apart.spare)), apart.rms)


def _both_ways(direction: Array) -> bool:
    """Tell whether scans of both directions are there, two each or more."""
    return min((direction > 0).sum(), (direction < 0).sum()) >= 2


#: The antennas that the paper calls mirror images of each other.
EAST = ("E03", "E04", "E05", "E06")
WEST = ("W04", "W05", "W06")


@dataclass(frozen=True)
class Mirror:
    """The odd part (coefficient of sin HA) of both arms on one day."""

    session: str  #: the day
    odd: dict[str, tuple[float, float]]  #: antenna -> coefficient and sigma [rad]
    #: How many antennas have the sign of their arm, and how many there are.
    opposite: tuple[int, int]
    chance: float  #: of as many with the right sign if signs were tossed


def mirrors(found: Sequence[Curve]) -> list[Mirror]:
    """Return for each day whether the arms bend opposite ways about the meridian."""
    from scipy.stats import binom

    days = []
    for session in sorted({curve.track.session for curve in found}):
        odd = {
            curve.track.antenna: curve.odd
            for curve in found
            if curve.track.session == session and curve.track.antenna in EAST + WEST
        }
        right = sum(
            np.sign(value) == (-1 if antenna in EAST else 1) for antenna, (value, _) in odd.items()
        )
        chance = float(binom.sf(right - 1, len(odd), 0.5)) if odd else 1.0
        days.append(Mirror(session, odd, (int(right), len(odd)), chance))
    return days


#: Scans this near to transit are looked at [rad].
NEAR_TRANSIT = 2.5 * HOUR

#: So many are needed on either side.
EACH_SIDE = 3


@dataclass(frozen=True)
class Jump:
    """The step of one antenna's offsets at transit, with its sigma [rad]."""

    antenna: str
    step: float
    sigma: float


@dataclass(frozen=True)
class Jumps:
    """All steps of a day."""

    session: str  #: the day
    jumps: tuple[Jump, ...]  #: of each antenna
    #: `mean`, `sigma`: of all steps, each weighted by its error [rad].
    mean: float
    sigma: float
    p_value: float  #: chance of steps so large without any jump (chi-square)


def jumps_at_transit(found: Sequence[Track]) -> list[Jumps]:
    """Return each day's steps at transit beyond a parabola and forward minus reverse."""
    from scipy.stats import chi2

    days = []
    for session in sorted({track.session for track in found}):
        each = [jump for track in found if track.session == session and (jump := _jump(track))]
        if not each:
            continue
        step, sigma = (np.array([getattr(one, name) for one in each]) for name in ("step", "sigma"))
        weight = 1 / sigma**2
        p_value = float(chi2.sf(((step / sigma) ** 2).sum(), len(each)))
        mean = float((weight * step).sum() / weight.sum())
        days.append(Jumps(session, tuple(each), mean, float(weight.sum() ** -0.5), p_value))
    return days


def _jump(track: Track) -> Jump | None:
    """Return the step of a track, None where it has too few scans on either side."""
    near = np.abs(track.hour_angle) <= NEAR_TRANSIT
    after = track.hour_angle[near] > 0
    if min(after.sum(), (~after).sum()) < EACH_SIDE:
        return None
    powers = np.vander(track.hour_angle[near], 3)
    side = after.astype(float)
    fit = line(
        np.concatenate([side[:, None], track.direction[near, None], powers], axis=1),
        track.offset[near],
    )
    return Jump(track.antenna, float(fit.value[0]), float(fit.sigma[0]))
