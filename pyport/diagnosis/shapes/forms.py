"""Forms of a nameless misfit: bumps over the sky, along a column, over two, in time; waves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.columns import COLUMNS
from pyport.diagnosis.candidates import conditions
from pyport.diagnosis.case import Problem
from pyport.diagnosis.naming.finding import Interval
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.circumstances import mostly_known
from pyport.effects.empirical import fields
from pyport.effects.empirical.fields import Bumps
from pyport.effects.telescope.rotation import MEASURED
from pyport.mounts import ALTAZ
from pyport.recordings.schema import Recordings
from pyport.thresholds import FEWEST

#: Widths of the bumps over the sky, and along azimuth and elevation: down to teeth of a gear and
#: sectors of an encoder's disc. [rad]
OVER_SKY = (6 * DEG, 20 * DEG, 45 * DEG)
ALONG_AZIMUTH = (2 * DEG, 6 * DEG, 20 * DEG)
ALONG_ELEVATION = (2 * DEG, 5 * DEG)
#: Bumps along a column: so many over the ranks of its values.
ALONG_COLUMN = 10
#: Numbers of no more values than this have an offset each, of more a curve.
FEW_VALUES = 5
#: A column of more labels than this is none of few.
MOST_LEVELS = 12
#: And over two columns: so many over the ranks of each.
OVER_TWO = 4
#: Harmonics of what comes back, along an angle or in time, in any form.
HARMONICS = 8
#: Lengths of bumps in time. [s]
IN_TIME = (6 * 3600.0, 86400.0)
#: More bumps in time than this say that the campaign is too long for them.
MOST_BUMPS = 160
#: Waves: this often around and this often up.
WAVES_AROUND, WAVES_UPWARD = range(1, 6), range(4)


@dataclass(frozen=True)
class Field:
    """A family of forms that a misfit may take.

    Attributes
    ----------
    family, variant
        What kind of field it is, and which of its kind.
    values
        Its bumps at the readings, shape (m, B).
    is_y
        Which readings are of elevation, shape (m,).
    choices
        How many of its kind are tried.
    along
        The column that it follows, and the column's values, shape (m,); none for the sky's.
    region
        Where it is confined to, where that is known beforehand.
    of_time
        Whether it belongs to the moments of its recordings: no other session has it.
    bumps, axes, which
        What its columns are made of, for any place in the sky: see `empirical.fields.field`;
        no axes where both measure it alike.
    """

    family: str
    variant: str
    values: Array
    is_y: NDArray[np.bool_]
    choices: int = 1
    along: tuple[str, Array] | None = None
    region: tuple[Interval, ...] = ()
    of_time: bool = False
    bumps: Bumps = field(default_factory=dict)
    axes: tuple[int, ...] = ()
    which: tuple[int, ...] = ()

    @property
    def of_two(self) -> bool:
        """Tell whether it follows two columns together."""
        return self.bumps.get("kind") == "pair"

    @property
    def columns(self) -> Array:
        """Return what its bumps do to the readings, one column for each of its axes, (m, K)."""
        if not self.axes:
            return self.values
        return self.values[:, list(self.which)] * (self.is_y[:, None] == np.array(self.axes, bool))


def numbers(recordings: Recordings) -> dict[str, Array]:
    """Return the numbers that a misfit may follow: the direction and every numeric column.

    Columns that the file's header calls `bookkeeping` say how a row was
    written down, not what the telescope met, and are passed over. So are offsets, by their name,
    and what a model left of them: a misfit would follow itself.
    """
    at = conditions(recordings)
    found: dict[str, Array] = {}
    for name, column in {"az_deg": at.az, "el_deg": at.el, **at.columns}.items():
        if name == "order" or MEASURED & {*name.split("_")} or column.dtype.kind not in "fiu":
            continue
        values = np.asarray(column, float)
        several = len(np.unique(values[np.isfinite(values)])) > FEW_VALUES
        if mostly_known(values) and several:
            found[name] = values
    return found


def families(problem: Problem) -> Iterator[tuple[int, Field]]:
    """Yield every field that these recordings could show, as if both axes measured it alike.

    With each comes how many there are of its kind.
    """
    sky = [
        _field(
            problem, "a smooth field over the sky", f"{w / DEG:.0f} deg wide", "sky", width_rad=w
        )
        for w in OVER_SKY
    ]
    waves = [
        _field(problem, "a wave over the sky", _wave_name(m, n), "wave", around=m, upward=n)
        for m in WAVES_AROUND
        for n in WAVES_UPWARD
    ]
    known = numbers(problem.recordings)
    ordered = {
        name: np.sort(values[np.isfinite(values)]).tolist()
        for name, values in known.items()
        if name not in ("az_deg", "time")
    }
    curves = [
        *_curves(problem, known, ordered),
        *_about_the_sun(problem),
        *_after_slews(problem),
        *_in_time(problem),
    ]
    for kind in (sky, waves, curves, [*_levels(problem)], [*_surfaces(problem, ordered)]):
        for one in kind:
            yield len(kind), one


def _field(
    problem: Problem,
    family: str,
    variant: str,
    kind: str,
    *,
    along: tuple[str, Array] | None = None,
    of_time: bool = False,
    **numbers_of: Any,  # noqa: ANN401 - what tells the bumps of this kind
) -> Field:
    """Return a field with its bumps at the readings."""
    bumps = {"kind": kind, **numbers_of}
    values = fields.values(bumps, problem.recordings.at)[problem.stack.row]
    return Field(
        family, variant, values, problem.stack.is_y, along=along, of_time=of_time, bumps=bumps
    )


def _wave_name(m: int, n: int) -> str:
    return f"goes with {m} A" + (f" and {n} E" if n else "")


def _curves(
    problem: Problem, known: Mapping[str, Array], ordered: Mapping[str, list[float]]
) -> Iterator[Field]:
    """Yield bumps along azimuth, elevation, the angles of other axes and every column of numbers.

    `known`, `ordered`: the columns of numbers, and those to follow in rising order.
    A circle of azimuth is counted from north, other first axes from minus half a turn.
    """
    at, row = problem.recordings.at, problem.stack.row
    yield from _angles(problem, at, ("az_deg", at.az % (2 * np.pi)), "el_deg")
    if (mount := at.mount) is not ALTAZ:
        first = (at.axes.az + np.pi) % (2 * np.pi) - np.pi
        names = f"{mount.first.column}_deg", f"{mount.second.column}_deg"
        yield from _angles(problem, at.axes, (names[0], first), names[1], in_axes=True)
    if np.ptp(at.az) > 2 * np.pi:
        # Of two readings of one direction a turn apart only the cable knows.
        along = "unwrapped_az_deg", at.az[row] / DEG
        counted = np.sort(at.az).tolist()
        yield _curve(problem, "column", along, name="az_deg", count=ALONG_COLUMN, values=counted)
    for name, values in ordered.items():
        if name != "el_deg":
            along = name, known[name][row]
            yield _curve(problem, "column", along, name=name, count=ALONG_COLUMN, values=values)


def _angles(
    problem: Problem,
    at: Circumstances,
    first: tuple[str, Array],
    second: str,
    **numbers_of: Any,  # noqa: ANN401 - what tells the bumps of this kind
) -> Iterator[Field]:
    """Yield bumps along two angles, what the first is called and counted as, and the second's."""
    row = problem.stack.row
    for width in ALONG_AZIMUTH:
        along = first[0], first[1][row] / DEG
        yield _curve(problem, "azimuth", along, width_rad=width, **numbers_of)
    for width in ALONG_ELEVATION:
        centres = np.arange(at.el[row].min(), at.el[row].max() + width, width).tolist()
        along = second, at.el[row] / DEG
        yield _curve(
            problem, "elevation", along, width_rad=width, centres_rad=centres, **numbers_of
        )


def _surfaces(problem: Problem, ordered: Mapping[str, list[float]]) -> Iterator[Field]:
    """Yield bumps over every two columns of numbers together, elevation being one."""
    for one, two in combinations(ordered, 2):
        how, values = f"follows {one} and {two}", [ordered[one], ordered[two]]
        yield _field(
            problem,
            "a smooth surface",
            how,
            "pair",
            names=[one, two],
            count=OVER_TWO,
            values=values,
        )


def _levels(problem: Problem) -> Iterator[Field]:
    """Yield an offset for each value of every column that has few, and that no effect asks for.

    Labels, and numbers that are no curve's: a valve that is open or shut, who observed, which way
    the telescope came.
    """
    known = {one.name for one in COLUMNS}
    for name, cells in conditions(problem.recordings).columns.items():
        if name in known or name == "order":
            continue
        text = cells.dtype.kind == "U"
        values, counts = np.unique(cells[cells != ""] if text else cells, return_counts=True)
        most = MOST_LEVELS if text else FEW_VALUES
        often = np.count_nonzero(counts >= FEWEST)
        if len(values) <= most and often > 1 and (text or np.isfinite(values).all()):
            bumps = {"name": name, "values": values.tolist()}
            yield _field(problem, "an offset for each value", f"by {name}", "levels", **bumps)


def _after_slews(problem: Problem) -> Iterator[Field]:
    """Yield bumps along how far the last slew went, where the moments of recordings are known."""
    at = problem.recordings.at
    if at.times is None:
        return
    for name, went in zip(("az_deg", "el_deg"), fields.last_slew(at), strict=True):
        known = np.sort(went[np.isfinite(went)]).tolist()
        if len(set(known)) > ALONG_COLUMN:
            how = f"follows the last slew in {name.removesuffix('_deg')}"
            bumps = {"name": name, "count": ALONG_COLUMN, "values": known}
            yield _field(problem, "a smooth curve", how, "slew", **bumps)


def _about_the_sun(problem: Problem) -> Iterator[Field]:
    """Yield bumps along the distance from the Sun, where its place is recorded or can be known."""
    try:
        away = fields.from_sun(problem.recordings.at)
    except MissingColumn:
        return
    known = np.sort(away[np.isfinite(away)]).tolist()
    if len(set(known)) > ALONG_COLUMN:
        along = "sun_distance_deg", away[problem.stack.row] / DEG
        yield _curve(problem, "sun", along, count=ALONG_COLUMN, values=known)


def _curve(problem: Problem, kind: str, along: tuple[str, Array], **numbers_of: Any) -> Field:  # noqa: ANN401
    return _field(problem, "a smooth curve", f"follows {along[0]}", kind, along=along, **numbers_of)


def _in_time(problem: Problem) -> Iterator[Field]:
    """Yield bumps in time, where there are recordings."""
    at, row = problem.recordings.at, problem.stack.row
    if at.times is None:
        return
    time = at.times[row]
    for length in IN_TIME:
        centres = np.unique(np.round(time / length)) * length
        if 3 <= len(centres) <= MOST_BUMPS:
            how = f"follows time, over {length / 3600:.0f} h"
            bumps = {"length_s": length, "centres_s": centres.tolist()}
            yield _field(problem, "a smooth curve", how, "time", of_time=True, **bumps)
