"""Offsets from day to day: a test whether they repeat, and by how much they do not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, HOUR, Array
from pyport.studies.gmrt.tracks import Track, line

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
    """One antenna on several days.

    Attributes
    ----------
    antenna
        Whose.
    level
        Session -> mean offset over the days' common hour angles relative to the
        first day, with its sigma [rad].
    p_value
        Chance of levels so different if the days were alike (F test).
    scatter
        Of a scan about its day's level [rad].
    """

    antenna: str
    level: dict[str, tuple[float, float]]
    p_value: float
    scatter: float

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
