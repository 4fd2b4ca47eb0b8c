"""What an observer loads: the average of forward and reverse, channel by channel, round by round.

Section 3 of the GMRT paper: set the offsets to zero, scan forward and reverse
twice, load the average, scan again; the second round should be near zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCMIN, Array
from pyport.recordings.schema import Recordings

#: A second round is near zero within this many sigmas, or within this angle [rad].
NEAR_ZERO_SIGMAS = 3.0
NEAR_ZERO = 1 * ARCMIN


@dataclass(frozen=True)
class Average:
    """One antenna's average along one axis in one round of scans; angles in radians."""

    #: `antenna`, `axis`, `round`: whose; axis is "az" (across, times cos El) or "el".
    antenna: str
    axis: str
    round: str
    #: `offset`, `sigma`: mean of the forward mean and the reverse mean, so that what flips with the
    #: direction drops out; NaN where one direction is missing. Its error is from the scatter of the
    #: scans.
    offset: float
    sigma: float
    half_difference: float  #: half of forward minus reverse: slack and time tag
    scans: int  #: how many readings went in

    @property
    def near_zero(self) -> bool:
        """Tell whether nothing is left to load."""
        return abs(self.offset) <= max(NEAR_ZERO, NEAR_ZERO_SIGMAS * self.sigma)


def averages(recordings: Recordings) -> list[Average]:
    """Return the average of each antenna, axis and round (a column `round`, if there is one)."""
    antenna, rounds = recordings.label("antenna"), _as_words(recordings.label("round"))
    direction = recordings.at.column("scan_direction")
    found = []
    for axis, offset in (("az", recordings.x), ("el", recordings.y)):
        here = np.isfinite(offset)
        for name, turn in sorted(set(zip(antenna[here], rounds[here], strict=True))):
            own = here & (antenna == name) & (rounds == turn)
            found.append(_average(str(name), axis, str(turn), offset[own], direction[own]))
    return found


def _as_words(labels: NDArray[Any]) -> NDArray[np.str_]:
    """Return labels as text, whole numbers without a point."""
    if labels.dtype.kind == "U":
        return labels
    return np.array([f"{label:g}" for label in labels], np.str_)


def _average(antenna: str, axis: str, turn: str, offset: Array, direction: Array) -> Average:
    """Return the average of some readings."""
    ways = [offset[direction == sign] for sign in (1, -1)]
    if not all(len(way) for way in ways):
        return Average(antenna, axis, turn, np.nan, np.nan, np.nan, len(offset))
    forward, reverse = (float(way.mean()) for way in ways)
    spare = len(offset) - 2
    squares = sum(float(((way - way.mean()) ** 2).sum()) for way in ways)
    variance = squares / spare if spare else np.nan
    sigma = float(np.sqrt(variance * sum(1 / len(way) for way in ways)) / 2)
    middle, half = (forward + reverse) / 2, (forward - reverse) / 2
    return Average(antenna, axis, turn, middle, sigma, half, len(offset))


def text(found: list[Average]) -> str:
    """Return the averages as a table in arcminutes, with a verdict on the later rounds."""
    first = min((one.round for one in found), default="")
    lines = ["antenna  axis  round  offset ['] +- sigma   half difference [']  scans"]
    for one in found:
        verdict = ""
        if one.round != first and np.isfinite(one.offset):
            verdict = "  near zero" if one.near_zero else "  NOT near zero: load and scan again"
        lines.append(
            f"{one.antenna:7}  {one.axis:4}  {one.round:5}  {one.offset / ARCMIN:+9.3f} "
            f"+- {one.sigma / ARCMIN:6.3f}  {one.half_difference / ARCMIN:+19.3f}  "
            f"{one.scans:5}{verdict}"
        )
    return "\n".join(lines)
