"""Lists of targets as telescopes and programs read them, and catalogues of sources."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, DEG, HOUR
from pyport.errors import BadInput
from pyport.files import is_file
from pyport.planning.targets import Source, Target
from pyport.recordings.formats import csv


def as_csv(some: Sequence[Target]) -> str:
    """Return targets as CSV: when, what, where on the sky and on the axes, what each decides."""
    axes = list(some[0].axes) if some else []
    lines = [",".join(["time_utc,source,az_deg,el_deg,ra_deg,dec_deg", *axes, "decides"])]
    for one in some:
        decides = " or ".join(one.decides or ())
        where = f"{one.az_deg:.4f},{one.el_deg:.4f},{one.ra_deg:.6f},{one.dec_deg:.6f}"
        when = np.datetime64(round(one.time_s), "s")
        turned = (f"{one.axes[name]:.4f}" for name in axes)
        lines.append(",".join([f"{when}Z", one.source, where, *turned, decides]))
    return "\n".join(lines) + "\n"


def as_snap(some: Sequence[Target]) -> str:
    """Return targets as commands of the VLBI Field System: go there, then wait until it is time.

    A source is given by its place (J2000), a direction by azimuth and elevation.
    """
    lines = ['" targets, each followed by the time at which it is observed']
    for n, one in enumerate(some, 1):
        if one.source:
            ra, dec = _sexagesimal(one.ra_deg / 15, 2), _sexagesimal(abs(one.dec_deg), 1)
            sign = "-" if one.dec_deg < 0 else "+"
            name = one.source.replace(" ", "_").lower()
            lines.append(f"source={name},{ra},{sign}{dec},2000.0")
        else:
            lines.append(f"source=azel,{one.az_deg:.4f}d,{one.el_deg:.4f}d")
        when = np.datetime64(round(one.time_s), "s")
        day = int((when.astype("datetime64[D]") - when.astype("datetime64[Y]")).astype(int)) + 1
        lines += [f"!{str(when)[:4]}.{day:03d}.{str(when)[11:]}", f'" target {n}']
    return "\n".join(lines) + "\n"


def as_grid(some: Sequence[Target]) -> str:
    """Return targets as a grid for TPOINT's mapping: azimuth and elevation [deg] a line."""
    return "".join(f"{one.az_deg:10.4f} {one.el_deg:9.4f}\n" for one in some)


def as_places(some: Sequence[Target]) -> str:
    """Return targets as names and places: RA [h m s] and Dec [d ' "], ICRS."""
    lines = []
    for n, one in enumerate(some, 1):
        ra, dec = _sexagesimal(one.ra_deg / 15, 2, " "), _sexagesimal(abs(one.dec_deg), 1, " ")
        sign = "-" if one.dec_deg < 0 else "+"
        lines.append(f"{one.source.replace(' ', '_') or f'target{n:03d}':20} {ra} {sign}{dec}\n")
    return "".join(lines)


FORMATS: dict[str, Callable[[Sequence[Target]], str]] = {
    "csv": as_csv,
    "snap": as_snap,
    "tpoint": as_grid,
    "radec": as_places,
}


def _sexagesimal(value: float, decimals: int, between: str = "") -> str:
    """Return an angle in hours or degrees as three numbers, rounded once."""
    units = round(value * 3600 * 10**decimals)
    seconds, part = divmod(units, 10**decimals)
    minutes, second = divmod(seconds, 60)
    whole, minute = divmod(minutes, 60)
    return between.join((f"{whole:02d}", f"{minute:02d}", f"{second:02d}.{part:0{decimals}d}"))


#: Catalogues that are shipped: calibrators of 1 Jy and more at 8 GHz (Radio Fundamental Catalogue),
#: stars brighter than 3.75 (Hipparcos, the new reduction). Their first lines say whose they are.
SHIPPED = {one: Path(__file__).parent / "data" / f"{one}.csv" for one in ("radio", "stars")}
#: The epoch of catalogued places.
EPOCH = 2000.0


def read_catalogue(name_or_path: str | Path, year: float = EPOCH) -> list[Source]:
    """Read sources, one of `SHIPPED` or a CSV file.

    With `name` (or `source`), `ra_deg` or `ra_h`, and `dec_deg`, all ICRS of 2000; where there are
    `pm_ra_mas_yr`, on the sky, and `pm_dec_mas_yr`, places are moved to `year`.

    Raises `BadInput`: no such file, a column is missing, or a cell is no number.
    """
    path = SHIPPED.get(str(name_or_path), Path(name_or_path))
    if not is_file(path):
        wanted = f"expected {', '.join(SHIPPED)} or a CSV file name,ra_deg,dec_deg"
        raise BadInput(f"no such file, {wanted}", path)
    raw = csv.read(path)
    name = next((one for one in ("name", "source") if one in raw.columns), "")
    ra = next((one for one in ("ra_deg", "ra_h") if one in raw.columns), "")
    if not (name and ra and "dec_deg" in raw.columns):
        raise raw.error("a catalogue has columns name, ra_deg (or ra_h) and dec_deg")
    right, dec = raw.numbers(ra) * (DEG if ra == "ra_deg" else HOUR), raw.numbers("dec_deg") * DEG
    raw.refuse(~np.isfinite(right) | ~np.isfinite(dec), f"no place, expected {ra} and dec_deg")
    raw.refuse(np.abs(dec) > np.pi / 2, "dec_deg outside [-90, 90]")
    most = "360" if ra == "ra_deg" else "24"
    raw.refuse((right < 0) | (right > 2 * np.pi), f"{ra} outside [0, {most}]")
    if "pm_ra_mas_yr" in raw.columns and "pm_dec_mas_yr" in raw.columns:
        moved = [raw.numbers(f"pm_{one}_mas_yr") * (year - EPOCH) for one in ("ra", "dec")]
        right = right + moved[0] * ARCSEC / 1000 / np.cos(dec)
        dec = dec + moved[1] * ARCSEC / 1000
    names = raw.words(name).tolist()
    first: dict[str, int] = {}
    for row, one in enumerate(names):
        if (before := first.setdefault(one, row)) != row:
            wrong = f"two sources have one name, {one!r}: line {raw.line[before]} has it too"
            raise raw.error(wrong, row)
    return [
        Source(str(one), float(a), float(d)) for one, a, d in zip(names, right, dec, strict=True)
    ]
