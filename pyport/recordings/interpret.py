"""From cells to recordings: units, signs, what is missing, and what cannot be used."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array
from pyport.columns import (
    ANGLES,
    DAY,
    DIRECTIONS,
    HOUR_OF_DAY,
    LABELS,
    NUMBERS,
    RESERVED,
    SCAN_RATE,
    SCAN_RATE_UNIT,
    SET_ASIDE,
    TIME,
    angle_of,
)
from pyport.effects.base import PIER_SIDE, Circumstances, Site
from pyport.effects.mounts import MOUNT, declared
from pyport.mounts import ALTAZ, Mount
from pyport.recordings import mounted, sky
from pyport.recordings.masks import repeated
from pyport.recordings.naming import number_of, site_of
from pyport.recordings.raw import BLANK, Raw, without_blanks
from pyport.recordings.schema import Recordings, SetAside

#: No cable reaches further [deg].
LARGEST_AZ_DEG = 720
LOWEST_EL_DEG, HIGHEST_EL_DEG = -10, 180
#: Beyond the zenith only where the header says so: a telescope that plunges is rare, a mistake
#: (a zenith distance, an azimuth in the wrong column) is not.
PLUNGE = "highest_el_deg"
LARGEST_HOUR_ANGLE_H = 24
LARGEST_OFFSET_DEG = 180
#: On the sky no telescope that found its source is further off; an azimuth in place of an offset,
#: or a record of another format, is. A file whose encoders have no zero says so by the key.
LARGEST_ON_SKY_DEG, FAR_OFF = 10.0, "largest_offset_deg"


def interpret(raw: Raw) -> Recordings:
    """Return the recordings that the cells of a file describe.

    Raises `BadInput`: required columns are missing, two say the same, a cell is no number or out of
      range, a header key is no number.
    """
    angles = angles_of(raw)
    at, blank = _circumstances(raw, angles)
    x, y = mounted.offsets_of(raw, angles, at)
    _refuse_far_off(raw, x, y)
    sigma_x, sigma_y = mounted.sigmas_of(angles, at)
    everything = Recordings(
        at=at,
        x=x,
        y=y,
        sigma_x=sigma_x,
        sigma_y=sigma_y,
        line=raw.line,
        file=raw.file,
        meta=_declaring(raw, at) | ({BLANK: ", ".join(blank)} if blank else {}),
    )
    return _quarantine(everything, raw)


def _refuse_far_off(raw: Raw, x: Array, y: Array) -> None:
    """Refuse offsets larger on the sky than any telescope's, unless the header allows them."""
    largest = number_of(raw.meta, FAR_OFF, LARGEST_OFFSET_DEG, raw.error) or LARGEST_ON_SKY_DEG
    size = np.hypot(np.nan_to_num(x), np.nan_to_num(y)) / DEG
    if np.any(far := size > largest):
        row = int(np.argmax(far))
        wrong = f"offset of {size[row]:.4g} deg on the sky, expected less than {largest:g} deg"
        raise raw.error(f"{wrong}, or a line '# {FAR_OFF}: {np.ceil(size[row]):g}'", row)


def targets(raw: Raw) -> Circumstances:
    """Return where the cells of a file point, whether or not an offset was measured there.

    Angles are NaN in a row that tells no direction.

    Raises `BadInput`: as `interpret`, but for columns of offsets.
    """
    return _circumstances(raw, angles_of(raw, measured=False))[0]


def _circumstances(raw: Raw, angles: dict[str, Array]) -> tuple[Circumstances, list[str]]:
    """Return where, when and in which conditions, and which cells were taken for blank.

    Azimuths become those from north.
    """
    site, mount = site_of(raw.meta, raw.error), mounted.mount_of(raw, angles)
    if mount.needs_latitude and site is None:
        raise raw.error(f"{mount.sentence} needs a line '# latitude_deg: ...', expected one")
    columns, blank = _columns(raw)
    south = azimuth_from_south(raw)
    check_ranges(raw, angles)
    if south:
        for name in {"az", "sun_az", "wind_az"} & set(angles):
            angles[name] = angles[name] + np.pi
    az, el = _position(raw, angles, site, mount)
    columns |= {name: angles[name] for name in DIRECTIONS & set(angles)}
    if site is not None:
        _add_equatorial(columns, az, el, site)
    at = Circumstances(az, el, site, columns, mount=mount)
    if mount is not ALTAZ:
        for axis, angle in zip((mount.first, mount.second), mounted.axes_of(at), strict=True):
            columns.setdefault(axis.column, angle)
    return at, blank


def _declaring(raw: Raw, at: Circumstances) -> dict[str, str]:
    """Return the header keys; what the columns say of the mount is declared like the rest."""
    words = declared(raw.meta)
    if at.mount is ALTAZ or at.mount.id in words:
        return raw.meta
    others = (word for word in words if word in mounted.MOUNTS)
    return {**raw.meta, MOUNT: ", ".join((at.mount.id, *others))}


def azimuth_from_south(raw: Raw) -> bool:
    """Tell whether the file counts azimuth from south through west."""
    zero = raw.meta.get("azimuth_zero", "north").lower()
    if zero not in {"north", "south"}:
        raise raw.error(f"azimuth_zero is {zero!r}, expected north or south", key="azimuth_zero")
    return zero == "south"


def angles_of(raw: Raw, *, measured: bool = True) -> dict[str, Array]:
    """Return all angles of the contract that the file has, in radians.

    One of the offsets has to be there unless `measured` is false.
    """
    found: dict[str, tuple[str, float]] = {}
    for name in raw.columns:
        angle = angle_of(name)
        if angle is None:
            if name in ANGLES:
                raise raw.error(f"column {name!r} has no unit, expected for instance {name}_deg")
            if name in RESERVED:
                raise raw.error(f"column {name!r} is not known, expected {RESERVED[name]}")
            continue
        quantity, radians = angle
        if quantity in found:
            raise raw.error(f"{found[quantity][0]!r} and {name!r} say the same, expected one")
        found[quantity] = name, radians
    for one, other in mounted.SAME:
        if one in found and other in found:
            both = f"{found[one][0]!r} and {found[other][0]!r}"
            raise raw.error(f"{both} say the same, expected one")
    if measured and not mounted.OFFSETS & set(found):
        raise raw.error("no offset column, expected d_az_deg or d_xel_deg, d_el_deg or d_zd_deg")
    return {quantity: raw.numbers(name) * radians for quantity, (name, radians) in found.items()}


def _columns(raw: Raw) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Return everything that is no angle, under the names that effects know; and what was blank."""
    columns: dict[str, NDArray[Any]] = {}
    blank: list[str] = []
    no_conditions = {TIME, SET_ASIDE, *({DAY, HOUR_OF_DAY} if _of_the_day(raw) else ())}
    for name in raw.columns:
        if name in LABELS:
            columns[name] = raw.words(name)
        elif name in NUMBERS:
            columns[name] = without_blanks(name, raw.numbers(name), blank)
        elif name == SCAN_RATE:
            columns["scan_rate"] = raw.numbers(name) * SCAN_RATE_UNIT
        elif name not in no_conditions and angle_of(name) is None:
            values = raw.numbers_or_words(name)
            of_numbers = values.dtype.kind == "f"
            columns[name] = without_blanks(name, values, blank) if of_numbers else values
    columns |= _time(raw)
    if "scan_direction" in columns:
        direction = columns["scan_direction"] = np.nan_to_num(columns["scan_direction"])
        raw.refuse(~np.isin(direction, (-1, 0, 1)), "scan_direction is not +1, -1, 0 or blank")
    if "scan_axis" in columns:
        raw.refuse(
            ~np.isin(columns["scan_axis"], ("az", "el", "")), "scan_axis is not az, el or blank"
        )
    if PIER_SIDE in columns:
        side = columns[PIER_SIDE] = mounted.sides(columns[PIER_SIDE])
        raw.refuse(~np.isin(side, (*mounted.SIDES, "")), "pier_side is not east, west or blank")
    if "scan_rate" in columns:
        raw.refuse(columns["scan_rate"] < 0, f"{SCAN_RATE} is negative, expected a positive number")
    return columns, blank


def _of_the_day(raw: Raw) -> bool:
    """Tell whether a file's times are days and their hours."""
    return {DAY, HOUR_OF_DAY} <= set(raw.columns) and TIME not in raw.columns


def _time(raw: Raw) -> dict[str, Array]:
    """Return the time [s since 1970], from a day and its hours where that is what is recorded."""
    if TIME in raw.columns:
        return {"time": raw.seconds(TIME)}
    if _of_the_day(raw):
        return {"time": raw.seconds(DAY) + 3600 * raw.hours(HOUR_OF_DAY)}
    return {}


def check_ranges(raw: Raw, angles: dict[str, Array]) -> None:
    """Refuse angles that no telescope can have, at the first line that has one."""
    if "az" in angles:
        raw.refuse(
            np.abs(angles["az"]) > LARGEST_AZ_DEG * DEG,
            f"azimuth outside +-{LARGEST_AZ_DEG} deg, expected a telescope's",
        )
    if "el" in angles:
        raw.refuse(
            (angles["el"] < LOWEST_EL_DEG * DEG) | (angles["el"] > HIGHEST_EL_DEG * DEG),
            f"elevation outside [{LOWEST_EL_DEG}, {HIGHEST_EL_DEG}] deg, expected a telescope's",
        )
        highest = number_of(raw.meta, PLUNGE, HIGHEST_EL_DEG, raw.error) or 90.0
        above = angles["el"] > (highest + 1e-9) * DEG
        needed = np.ceil(np.max(angles["el"] / DEG, where=above, initial=highest) - 1e-9)
        raw.refuse(
            above,
            f"elevation above {highest:g} deg, expected less, or a line '# {PLUNGE}: {needed:g}' "
            "for a telescope that goes beyond the zenith",
        )
    if "hour_angle" in angles:
        raw.refuse(
            np.abs(angles["hour_angle"]) > LARGEST_HOUR_ANGLE_H * HOUR,
            f"hour angle outside +-{LARGEST_HOUR_ANGLE_H} h, expected hours in a column "
            "hour_angle_h, degrees in hour_angle_deg",
        )
    if "dec" in angles:
        beyond = np.abs(angles["dec"]) > np.pi / 2 + 1e-12
        raw.refuse(beyond, "declination outside [-90, 90] deg, expected one of the sky")
    for name in mounted.OFFSETS & set(angles):
        raw.refuse(
            np.abs(angles[name]) > LARGEST_OFFSET_DEG * DEG,
            f"offset {name} above {LARGEST_OFFSET_DEG} deg, expected a pointing offset",
        )
    for name in {one for one in angles if one.startswith("sigma_")}:
        raw.refuse(
            angles[name] <= 0, f"{name} is not positive, expected a positive number or blank"
        )


def _position(
    raw: Raw, angles: dict[str, Array], site: Site | None, mount: Mount
) -> tuple[Array, Array]:
    """Return azimuth and elevation, from other angles where they are not given."""
    nothing = np.full(len(raw.line), np.nan)
    az, el = angles.get("az", nothing), angles.get("el", nothing)
    if mount is not ALTAZ and {mount.first.column, mount.second.column} <= set(angles):
        az, el = mounted.place(mount, angles, 0.0 if site is None else site.latitude, az, el)
        _refuse_below(raw, el, f"{mount.first.name} and {mount.second.name}")
        return az, el
    if {"az", "el"} <= set(angles) and site is None:
        return az, el
    if site is not None and {"hour_angle", "dec"} <= set(angles):
        seen_az, seen_el = sky.horizon(angles["hour_angle"], angles["dec"], site.latitude)
        lost = np.isnan(az) | np.isnan(el)
        az, el = np.where(lost, seen_az, az), np.where(lost, seen_el, el)
        _refuse_below(raw, el, "hour angle and declination")
    elif not {"az", "el"} <= set(angles):
        instead = "hour_angle_h, dec_deg and a line '# latitude_deg: ...'"
        if not mount.needs_latitude and mount is not ALTAZ:
            instead = f"{mount.first.column}_deg and {mount.second.column}_deg"
        raise raw.error(f"no columns az_deg and el_deg, expected them, or {instead}")
    return az, el


def _refuse_below(raw: Raw, el: Array, axes: str) -> None:
    """Refuse places below the horizon that the angles of some axes tell."""
    wrong = f"{axes} of a place below the horizon, expected a telescope's"
    raw.refuse(el < LOWEST_EL_DEG * DEG, f"{wrong} (units, signs, the latitude)")


def _add_equatorial(columns: dict[str, NDArray[Any]], az: Array, el: Array, site: Site) -> None:
    """Add hour angle and declination where the file does not tell them."""
    for name, derived in zip(
        ("hour_angle", "dec"), sky.equator(az, el, site.latitude), strict=True
    ):
        recorded = columns.get(name)
        columns[name] = (
            derived if recorded is None else np.where(np.isnan(recorded), derived, recorded)
        )


def _quarantine(everything: Recordings, raw: Raw) -> Recordings:
    """Exclude, each with a reason, the rows that cannot be used."""
    reason = raw.words(SET_ASIDE) if SET_ASIDE in raw.columns else np.full(len(everything), "")
    reason = reason.astype(object)
    no_offset = np.isnan(everything.x) & np.isnan(everything.y)
    at = everything.at
    no_position = np.isnan(at.az) | np.isnan(at.el)
    reason[(reason == "") & no_offset] = "no offset on either axis"
    reason[(reason == "") & no_position] = "no azimuth or no elevation"
    if at.mount.turns_over:
        if PIER_SIDE not in at:
            raise raw.error(f"{at.mount.sentence} needs a column pier_side, expected east or west")
        reason[(reason == "") & (at.column(PIER_SIDE) == "")] = "no side of the pier"
    for row, line in repeated(raw, everything).items():
        reason[row] = reason[row] or f"the same as line {line} in every column"
    bad = reason != ""
    aside = tuple(
        SetAside(int(line), str(why))
        for line, why in zip(everything.line[bad], reason[bad], strict=True)
    )
    return replace(everything.take(~bad), set_aside=aside) if aside else everything
