"""What outcomes come to: shares with Wilson's intervals, runs that go on, columns of known models.

Offsets are encoder minus true, across (times cos E) and along elevation; azimuth A from north
through east, radians. Himwich, Mark IV Field System documentation, Pointing Model (1993); Lal,
Ishwara-Chandra & Rao, The GMRT Antenna Pointing II (2003), section 4 (hour angle).
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pyport.examiner import program

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Array = NDArray[np.float64]

#: Coefficients of the classical model of an alt-azimuth mount, in the order of its columns.
ALTAZ = (
    *("azimuth_zero", "elevation_zero", "collimation", "skew"),
    *("tilt_north", "tilt_east", "sag_cosine"),
)
#: Coefficients of a wave in hour angle along elevation.
HOUR_ANGLE = ("elevation_zero", "hour_angle_cosine", "hour_angle_sine")


def lean(az: Array, el: Array, toward: float = 0.0) -> tuple[Array, Array]:
    """Return what an azimuth axis that leans by one toward an azimuth does."""
    return np.sin(el) * np.sin(az - toward), np.cos(az - toward)


def both(across: Array | float, along: Array | float, n: int) -> Array:
    """Return offsets of both axes side by side, shape (n, 2)."""
    return np.stack([np.broadcast_to(one, n) for one in (across, along)], axis=1)


def altaz(az: Array, el: Array) -> Array:
    """Return the columns of the classical model, shape (n, 2, 7)."""
    columns: list[tuple[Array | float, Array | float]] = [
        (np.cos(el), 0.0),
        (0.0, 1.0),
        (1.0, 0.0),
        (np.sin(el), 0.0),
        lean(az, el),
        lean(az, el, np.pi / 2),
        (0.0, np.cos(el)),
    ]
    return np.stack([both(*one, len(el)) for one in columns], axis=2)


def hour_angle(angle: Array) -> Array:
    """Return the columns of a wave in hour angle [rad], shape (n, 2, 3)."""
    columns = [(0.0, np.ones(len(angle))), (0.0, np.cos(angle)), (0.0, np.sin(angle))]
    return np.stack([both(*one, len(angle)) for one in columns], axis=2)


Case = TypeVar("Case", bound="DataclassInstance")
Item = TypeVar("Item")
Result = TypeVar("Result")
Outcome = dict[str, Any]


def run(
    wanted: Sequence[Case],
    examine: Callable[[Case], Outcome],
    file: Path,
    jobs: int = 1,
    made_by: object = None,
) -> Iterator[Outcome]:
    """Yield what comes out of every case: what the file has of this program, then the others.

    Cases are frozen dataclasses of numbers and texts, whose fields are part of the outcome, as is
    `program`: what it was made by, this version where nothing is given.
    Every outcome is appended to the file as soon as it is there; a run that was killed goes on.
    """
    kept = read(file, type(wanted[0]), made_by) if wanted else {}
    rest = []
    for case in wanted:
        if (outcome := kept.get(case)) is None:
            rest.append(case)
        else:
            yield outcome
    for outcome in each(examine, rest, jobs):
        keep(file, outcome)
        yield outcome


def each(examine: Callable[[Item], Result], rest: Sequence[Item], jobs: int) -> Iterator[Result]:
    """Yield what becomes of every item as soon as it is there, `jobs` processes at it."""
    if jobs == 1:
        yield from map(examine, rest)
        return
    with ProcessPoolExecutor(jobs) as pool:
        for done in as_completed([pool.submit(examine, case) for case in rest]):
            yield done.result()


def keep(file: Path, outcome: Outcome) -> None:
    """Append an outcome to a file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(outcome) + "\n")


def lines(file: Path) -> Iterator[Outcome]:
    """Yield the outcomes in a file, if it is there; a line cut short is none."""
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else ():
        with contextlib.suppress(ValueError):
            yield json.loads(line)


def read(file: Path, kind: type[Case], made_by: object = None) -> dict[Case, Outcome]:
    """Return the outcomes that a file has of the present program, or of what else made them."""
    names = [field.name for field in dataclasses.fields(kind)]
    return {
        kind(*(one[name] for name in names)): one
        for one in lines(file)
        if one.get("program") == (made_by or program.version())
    }


#: Standard deviations that hold 95 % of a normal distribution.
_Z95 = 1.959963984540054

MET, MISSED, OPEN, NONE = "met", "missed", "open", "none"


@dataclass(frozen=True)
class Share:
    """A share that was counted, and what its interval is made from.

    `hits` of `of`; `effective` is how many independent ones the `of` are worth, 0 for all.
    """

    hits: int
    of: int
    effective: float = 0.0

    @property
    def value(self) -> float:
        """Return the share; NaN where nothing was counted."""
        return self.hits / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Return Wilson's 95 % interval (Wilson 1927, JASA 22, 209)."""
        if not self.of:
            return 0.0, 1.0
        spread = _Z95**2 / (self.effective or self.of)
        centre = (self.value + spread / 2) / (1 + spread)
        half = math.sqrt(self.value * (1 - self.value) * spread + spread**2 / 4) / (1 + spread)
        return max(0.0, centre - half), min(1.0, max(centre + half, self.value))

    def judged(self, low: float, high: float) -> str:
        """Tell whether a target was met (its share is in it), missed (its interval is not), open.

        Open is a share outside the target that more cases may bring into it.
        """
        if not self.of:
            return NONE
        if low <= self.value <= high:
            return MET
        least, most = self.interval
        return MISSED if least > high or most < low else OPEN

    def __str__(self) -> str:
        """Return "71.2 (68.0-74.1)" in per cent."""
        if not self.of:
            return "-"
        low, high = self.interval
        return f"{100 * self.value:.1f} ({100 * low:.1f}-{100 * high:.1f})"


def counted(outcomes: Sequence[bool]) -> Share:
    """Return the share of what came true among independent outcomes."""
    return Share(sum(outcomes), len(outcomes))


def clustered(groups: Sequence[Sequence[bool]]) -> Share:
    """Return the share of what came true where the outcomes of a group hang together.

    The coefficients of one fit share its noise: the variance of the share is that between groups
    (Kish 1965, Survey Sampling, sec. 5.4), never less than that of independent outcomes.
    """
    kept = [group for group in groups if group]
    hits, of = sum(map(sum, kept)), sum(map(len, kept))
    if of == 0:
        return Share(0, 0)
    share = hits / of
    free = share * (1 - share) / of
    between = sum((sum(group) - share * len(group)) ** 2 for group in kept) / of**2
    if len(kept) > 1:
        between *= len(kept) / (len(kept) - 1)
    worse = max(between / free, 1.0) if free > 0 else of / len(kept)
    return Share(hits, of, of / worse)
