"""Recordings of any mount: which it is, and what its columns of places and offsets are called."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import OVER, PIER_SIDE, Circumstances
from pyport.effects.mounts import MOUNT, MOUNTS, declared
from pyport.errors import BadInput
from pyport.mounts import ALTAZ, KINDS, Mount
from pyport.recordings.raw import Raw

#: Words that other programs have for the mounts.
ALSO = {
    "azel": "altaz",
    "alt-azimuth": "altaz",
    "hadec": "equatorial",
    "hadc": "equatorial",
    "polar": "equatorial",
    "gem": "german",
    "xyns": "xy-ns",
    "xyew": "xy-ew",
}
#: The sides of a pier: of the tube, `east` in the ordinary state, looking west.
SIDES = ("east", OVER)


def sides(words: NDArray[np.str_]) -> NDArray[np.str_]:
    """Return sides of a pier as `SIDES` spells them: also E and W, and ASCOM's pierEast."""
    short = np.char.lower(words)
    for whole in SIDES:
        short = np.where(np.isin(short, (whole[0], f"pier{whole}")), whole, short)
    return short


@dataclass(frozen=True)
class Names:
    """What a mount's offsets are called, without a unit: as a coordinate, on the sky, along."""

    first: str
    across: str
    along: str

    @property
    def offsets(self) -> frozenset[str]:
        """Return all of them."""
        return frozenset({self.first, self.across, self.along})

    @property
    def sigmas(self) -> tuple[str, str, str]:
        """Return what their errors are called."""
        first, across, along = (
            f"sigma_{one.removeprefix('d_')}" for one in (self.first, self.across, self.along)
        )
        return first, across, along


def names_of(mount: Mount) -> Names:
    """Return what a mount's offsets are called."""
    return Names(mount.first.offset, mount.across_column, mount.second.offset)


#: Names of the offsets of all mounts.
ALL_NAMES = tuple(dict.fromkeys(map(names_of, KINDS.values())))
OFFSETS = frozenset().union(*(one.offsets for one in ALL_NAMES)) | {"d_zd"}
#: What says the same: a coordinate's offset, or its error, and that on the sky.
SAME = (
    *((one.first, one.across) for one in ALL_NAMES),
    *(one.sigmas[:2] for one in ALL_NAMES),
    ("d_el", "d_zd"),
)


def stated(keys: Mapping[str, str]) -> Mount | None:
    """Return the kind of mount that header keys state, None where they state none.

    Raises `BadInput`: they state no mount that is known, or two.
    """
    words = [ALSO.get(word, word) for word in declared(keys)]
    if wrong := [word for word in words if word not in MOUNTS and word not in KINDS]:
        known = ", ".join((*KINDS, *MOUNTS))
        raise BadInput(f"{MOUNT} is {wrong[0]!r}, expected one or more of {known}")
    kinds = [KINDS[word] for word in words if word in KINDS]
    if len(kinds) > 1:
        raise BadInput(f"{MOUNT} is {kinds[0].id} and {kinds[1].id}, expected one of them")
    return kinds[0] if kinds else None


def mount_of(raw: Raw, quantities: Collection[str]) -> Mount:
    """Return the mount that a file declares or, where it is silent, that its columns tell.

    Raises `BadInput`: it declares no mount that is known, or two; its columns are of another, or of
      one of two.
    """
    try:
        mount = stated(raw.meta)
    except BadInput as error:
        raise raw.error(error.message, key=MOUNT) from None
    there = {one for one in ALL_NAMES if one.offsets & set(quantities)}
    if mount is not None:
        # what was measured across and along elevation any mount's axes can show
        foreign = there - {names_of(mount), names_of(ALTAZ)}
        if foreign:
            name = min(foreign.pop().offsets & set(quantities))
            wanted = f"expected {mount.first.offset}_deg or {mount.across_column}_deg, and so on"
            raise raw.error(f"{name} is no offset of {mount.sentence}, {wanted}")
        return mount
    fitting = [one for one in KINDS.values() if names_of(one) in there]
    if not fitting or ALTAZ in fitting:
        return ALTAZ
    if PIER_SIDE in raw.columns:
        fitting = [one for one in fitting if one.turns_over] or fitting
    if len({one.model for one in fitting}) == 1 and fitting[0].needs_latitude:
        return fitting[0]
    which = " or ".join(f"'# {MOUNT}: {one.id}'" for one in fitting)
    raise raw.error(f"these are offsets of one of two mounts, expected a line {which}")


def place(
    mount: Mount, angles: dict[str, Array], latitude: float, az: Array, el: Array
) -> tuple[Array, Array]:
    """Return azimuth and elevation, from the axes' angles where they are not given."""
    with np.errstate(invalid="ignore"):  # a NaN stays one
        first, second = angles[mount.first.column], angles[mount.second.column]
        seen_az, seen_el = mount.sky(first, second, latitude)
    lost = np.isnan(az) | np.isnan(el)
    return np.where(lost, seen_az, az), np.where(lost, seen_el, el)


def axes_of(at: Circumstances) -> tuple[Array, Array]:
    """Return the angles of the axes [rad], shape (n,) each, as if nothing had turned over."""
    latitude = at.latitude() if at.mount.needs_latitude else 0.0
    return at.mount.angles(at.az, at.el, latitude)


def offsets_of(raw: Raw, angles: dict[str, Array], at: Circumstances) -> tuple[Array, Array]:
    """Return the offsets across and along the mount's axes, shape (n,) each.

    Raises `BadInput`: they are across and along elevation on a mount of other axes, and one of them
      is missing.
    """
    names = names_of(at.mount)
    if at.mount is not ALTAZ and not names.offsets & set(angles):
        x, y = _along(names_of(ALTAZ), angles, np.cos(at.el))
        if np.any(np.isnan(x) != np.isnan(y)):
            wanted = f"expected both, or {names.across}_deg and {names.along}_deg"
            raise raw.error(f"one of two offsets on {at.mount.sentence}, {wanted}")
        return at.along_axes(x, y)
    return _along(names, angles, np.cos(axes_of(at)[1]))


def sigmas_of(angles: dict[str, Array], at: Circumstances) -> tuple[Array, Array]:
    """Return the errors of the offsets, shape (n,) each, NaN where there is none."""
    coordinate, across, along = names_of(at.mount).sigmas
    nothing = np.full(len(at), np.nan)
    if coordinate in angles:
        return angles[coordinate] * np.cos(axes_of(at)[1]), angles.get(along, nothing)
    return angles.get(across, nothing), angles.get(along, nothing)


def _along(names: Names, angles: dict[str, Array], cosine: Array) -> tuple[Array, Array]:
    nothing = np.full(len(cosine), np.nan)
    x = angles[names.first] * cosine if names.first in angles else angles.get(names.across, nothing)
    if names == names_of(ALTAZ) and "d_zd" in angles:
        return x, -angles["d_zd"]
    return x, angles.get(names.along, nothing)
