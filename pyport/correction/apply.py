"""A model applied to a file of targets or recordings: offsets, mount positions, residuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.columns import LABELS, NUMBERS, SCAN_RATE, SET_ASIDE, TIME, angle_of
from pyport.correction.compare import rms_of, spoken_axes
from pyport.correction.use import PointingModel
from pyport.effects import Circumstances
from pyport.effects.sky.atmosphere import LOWEST_EL
from pyport.errors import BadInput
from pyport.formats.convert import table_of
from pyport.models.conditions import refuse_slips
from pyport.models.labels import taken_for
from pyport.mounts import ALTAZ, Mount, turned
from pyport.recordings.interpret import angles_of, azimuth_from_south, targets
from pyport.recordings.mounted import axes_of, names_of, offsets_of
from pyport.recordings.naming import KEYS
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings, Table
from pyport.recordings.sky import with_nights
from pyport.recordings.where import parse

#: A reading that no direction gives is missed by more than this [rad].
MISSED = 1e-3 * ARCSEC


@dataclass(frozen=True)
class Applied:
    """A table with what a model says in each row."""

    table: Table  #: the columns of the file and the new ones
    added: tuple[str, ...]  #: names of those
    #: `rows`, `skipped`: how many rows, and how many of them tell no direction.
    rows: int
    skipped: int
    #: Conditions that the model follows, with the number of rows that do not tell them: what
    #: follows them counts as zero there.
    unknown: dict[str, int]
    low: int  #: how many rows lie so low that refraction is held
    #: Of what is left of recordings, by axis and over the sky [arcsec], excluded rows not counted;
    #: empty without offsets.
    rms: dict[str, float]
    axes: Mapping[str, str]  #: what is said for `xel` and `el` of those, see `spoken_axes`
    notes: tuple[str, ...] = ()  #: whose coefficients were taken for others, and which columns


def applied(
    model: PointingModel,
    raw: Raw,
    *,
    inverse: bool,
    residuals: bool,
    where: str,
) -> Applied:
    """Return a table with a model's offsets, and where to drive, in each row.

    `model`: with coefficients.
    `raw`: a file's cells: directions, and whatever the model needs beside them.
    `inverse`: the file's azimuth and elevation are the mount's readings: the true ones are added.
    `residuals`: the file holds measured offsets: what the model leaves of them is added.
    `where`: an expression: rows for which it does not hold are left out.
    Raises `BadInput`: the file tells no directions, `where` holds for none of them, or the file
      lacks something that the model needs.
    """
    at = targets(raw)
    if at.mount is ALTAZ:
        at = replace(at, mount=model.model.mount)
    there = np.isfinite(at.az) & np.isfinite(at.el)
    if not there.any():
        raise raw.error("no row tells an azimuth and an elevation")
    nothing = np.full(len(at), np.nan)
    rows = Recordings(at, nothing, nothing, nothing, nothing, raw.line, raw.file)
    kept = _kept(rows, where)
    there &= kept
    met = model.met(with_nights(rows).at, raw.file) if residuals else at
    known = met.take(there)
    try:
        found = _inverse(model, known) if inverse else _forward(model, known)
        if residuals:
            found |= _residuals(raw, at, there, found)
    except BadInput as error:
        _refuse_labels(model, known, raw, np.flatnonzero(there))
        raise BadInput(error.message, raw.file) from None
    turn = np.pi if azimuth_from_south(raw) else 0.0
    columns = dict(table_of(raw).columns)
    for name, values in found.items():
        whole = np.full(len(at), np.nan)
        whole[there] = values - turn / DEG if name.endswith("az_deg") else values
        columns[name] = whole
    bent = any("refraction" in term.effect.id for term in model.model.terms)
    return Applied(
        Table(raw.meta, {name: values[kept] for name, values in columns.items()}),
        tuple(found),
        int(kept.sum()),
        int((kept & ~there).sum()),
        _unknown(model, known),
        int((known.el < LOWEST_EL).sum()) if bent else 0,
        _rms(raw, there, found) if residuals else {},
        spoken_axes(at.mount),
        (
            *taken_for(model.model.completed, known.columns),
            *(_readings(raw, at.mount) if inverse else ()),
            *(_unreached(model, known, found) if inverse else _beyond(at.mount, found)),
        ),
    )


def _refuse_labels(
    model: PointingModel, at: Circumstances, raw: Raw, rows: NDArray[np.intp]
) -> None:
    """Refuse, with its line, the first of a file's `rows` whose label a term does not know."""
    for term in model.model.terms:
        found = term.first_unknown(at.columns) if term.has_values else None
        if found is not None:
            raise raw.error(found[1], int(rows[found[0]]))


def _kept(rows: Recordings, where: str) -> NDArray[np.bool_]:
    """Tell for which rows an expression holds, all of them for "", shape (n,)."""
    if not where:
        return np.ones(len(rows), bool)
    keep = parse(where)(rows)
    if not keep.any():
        raise BadInput(f"--where {where!r} holds for none of the {len(rows)} rows", rows.file)
    return keep


def with_conditions(raw: Raw, stated: Mapping[str, str], model: PointingModel) -> Raw:
    """Return a file's cells with columns for conditions that were stated for all rows.

    Raises `BadInput`: the file has such a column, or the name is nearly that of a condition.
    """
    n, known = len(raw.line), NUMBERS | LABELS | {TIME, SCAN_RATE} | set(model.needs())
    columns = {
        key: np.full(n, text, object)
        for key, text in stated.items()
        if (key in known or angle_of(key) is not None) and key not in KEYS
    }
    refuse_slips(set(stated) - set(columns) - KEYS, known)
    for key in set(columns) & set(raw.columns):
        raise BadInput(f"--set {key}: the file has a column of this name", raw.file)
    return replace(raw, columns={**raw.columns, **columns})


def _forward(model: PointingModel, at: Circumstances) -> dict[str, Array]:
    x, y = model.at(at)
    first, second = axes_of(at)
    turn, names = turned(x, second), names_of(at.mount)
    drive_first, drive_second = _driven(at.mount)
    return {
        f"model_{names.across}_arcsec": x / ARCSEC,
        f"model_{names.first}_arcsec": turn / ARCSEC,
        f"model_{names.along}_arcsec": y / ARCSEC,
        drive_first: (first + turn) / DEG,
        drive_second: (second + y) / DEG,
    }


def _inverse(model: PointingModel, at: Circumstances) -> dict[str, Array]:
    az, el = model.inverse_at(at)
    found = {"true_az_deg": az / DEG, "true_el_deg": el / DEG}
    if at.mount is ALTAZ:
        return found
    names, (first, second) = names_of(at.mount), axes_of(replace(at, az=az, el=el))
    return found | {
        f"true_{names.first.removeprefix('d_')}_deg": first / DEG,
        f"true_{names.along.removeprefix('d_')}_deg": second / DEG,
    }


def _driven(mount: Mount) -> tuple[str, str]:
    """Return the columns that hold where to drive a mount's axes, the first and the second."""
    names = names_of(mount)
    first, second = (f"mount_{one.removeprefix('d_')}_deg" for one in (names.first, names.along))
    return first, second


def _unreached(model: PointingModel, at: Circumstances, found: dict[str, Array]) -> Iterator[str]:
    """Yield how many readings no direction gives: at the zenith, at the edge of a field."""
    there = replace(at, az=found["true_az_deg"] * DEG, el=found["true_el_deg"] * DEG)
    back = _forward(model, there)
    first, second = (back[name] * DEG for name in _driven(at.mount))
    read_first, read_second = axes_of(at)
    turn = wrap(first - read_first) * np.cos(read_second)
    count = int(np.sum(np.hypot(turn, second - read_second) > MISSED))
    if count:
        yield f"{count} rows hold readings that no direction gives: the nearest one is written"


def _beyond(mount: Mount, found: dict[str, Array]) -> Iterator[str]:
    """Yield how many rows drive the second axis beyond its pole."""
    _, name = _driven(mount)
    count = int(np.sum(np.abs(found[name]) > 90.0))
    if count:
        yield f"{count} rows drive the second axis beyond its pole: {name} is more than 90"


def _readings(raw: Raw, mount: Mount) -> Iterator[str]:
    """Yield what a file has the mount's readings under, besides the names that are taken."""
    for name in _driven(mount):
        if name in raw.columns:
            yield f"the readings are those under {name.removeprefix('mount_')}, not under {name}"


def _residuals(
    raw: Raw, at: Circumstances, there: NDArray[np.bool_], found: dict[str, Array]
) -> dict[str, Array]:
    """Return what is left of the measured offsets [arcsec]."""
    if "true_az_deg" in found:
        raise BadInput("residuals are of true directions: leave --inverse out")
    measured, names = offsets_of(raw, angles_of(raw), at), names_of(at.mount)
    return {
        f"residual_{name.removeprefix('d_')}_arcsec": one[there] / ARCSEC
        - found[f"model_{name}_arcsec"]
        for name, one in zip((names.across, names.along), measured, strict=True)
    }


def _unknown(model: PointingModel, at: Circumstances) -> dict[str, int]:
    found = {}
    for name in model.columns_needed():
        values = at.columns.get(name)
        if values is None:
            continue
        blank = np.isnan(values) if values.dtype.kind == "f" else values == ""
        if np.any(blank):
            found[name] = int(np.sum(blank))
    return found


def _rms(raw: Raw, there: NDArray[np.bool_], found: dict[str, Array]) -> dict[str, float]:
    """Return the rms of what is left, of rows that are not excluded [arcsec]."""
    left = np.stack([one for name, one in found.items() if name.startswith("residual_")])
    if SET_ASIDE in raw.columns:
        left[:, np.asarray(raw.words(SET_ASIDE))[there] != ""] = np.nan
    return rms_of(left)
