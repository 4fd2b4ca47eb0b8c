"""What a page or a picture shows of a watch: tonight's rows, running terms, alarms, where next."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pyport.angles import DEG, Array, separation
from pyport.effects.circumstances import NIGHT_GAP_S
from pyport.planning.design import coverage
from pyport.planning.suggest import directions
from pyport.report.typed import as_json
from pyport.watch.alarms import moment
from pyport.watch.detection.antenna import Antenna
from pyport.watch.watch import Seen, Watch

#: Pointings that a running zero, and a running tilt, are taken from.
ZERO_OF, TILT_OF = 15, 30
#: Elevations between which a pointing is suggested [deg].
LOWEST_DEG, HIGHEST_DEG = 15.0, 80.0
#: Where a row was, and what it was off by.
_OFFSETS = ("az_deg", "el_deg", "xel_arcsec", "el_arcsec", "sigma_xel_arcsec", "sigma_el_arcsec")
#: Directions that are suggested, so far apart from each other [rad].
SUGGESTED, APART = 3, 20 * DEG


def live(watch: Watch) -> dict[str, Any]:
    """Return everything that the page draws, as JSON holds it; rows of the last antenna seen."""
    antenna = watch.recent[-1].antenna if watch.recent else ""
    rows = tonight([one for one in watch.recent if one.antenna == antenna], timed=watch.timed)
    status = watch.status()
    alarms = [one.as_json(timed=watch.timed) for one in watch.alarms.values()]
    own = watch.antennas.get(antenna)
    return {
        **status,
        "timed": watch.timed,
        "antenna": antenna,
        "axes": list(watch.history.at.mount.names),
        "recent": [_row(one) for one in rows],
        "running": running(rows),
        "alarms": alarms[::-1],
        "threshold": None if own is None else own.threshold / math.log(10),
        "next": [] if own is None else suggested(own, rows),
        "updated": None if not rows else moment(rows[-1].time, timed=watch.timed),
    }


def tonight(rows: list[Seen], *, timed: bool) -> list[Seen]:
    """Return the rows since the last long gap; all where they have no times."""
    if not timed or not rows:
        return rows
    gaps = np.diff([one.time for one in rows]) > NIGHT_GAP_S
    return rows[int(np.flatnonzero(gaps)[-1]) + 1 if gaps.any() else 0 :]


def _row(one: Seen) -> list[float | None]:
    """Return time, azimuth and elevation [deg], offsets and their sigmas [arcsec], evidence."""
    values = [getattr(one, name) for name in ("time", *_OFFSETS)] + [one.evidence / math.log(10)]
    found: list[float | None] = as_json([round(value, 4) for value in values])
    return found


def running(rows: list[Seen]) -> list[dict[str, Any]]:
    """Return zeros and tilts, each from the pointings before a row, with errors [arcsec].

    They are plain means and least squares of the offsets against the model of the past: what an
    observer would draw by hand, beside what the detector makes of it.
    """
    if not rows:
        return []
    az, el, x, y, sigma_x, sigma_y = (np.array([getattr(r, n) for r in rows]) for n in _OFFSETS)
    tilt = _tilt(az * DEG, el * DEG)
    found = []
    for n in range(len(rows)):
        short = slice(max(0, n + 1 - ZERO_OF), n + 1)
        long = slice(max(0, n + 1 - TILT_OF), n + 1)
        found.append(
            {
                "time": rows[n].time,
                "xel": _mean(x[short], sigma_x[short]),
                "el": _mean(y[short], sigma_y[short]),
                **_lean(tilt[:, long], x[long], y[long], sigma_x[long], sigma_y[long]),
            }
        )
    return found


def _tilt(az: Array, el: Array) -> Array:
    """Return zeros and tilts of either axis, (2, n, 4)."""
    none, one = np.zeros(len(az)), np.ones(len(az))
    across = [one, none, np.sin(el) * np.sin(az), -np.sin(el) * np.cos(az)]
    along = [none, one, np.cos(az), np.sin(az)]
    return np.stack([np.stack(across, axis=1), np.stack(along, axis=1)])


def _mean(values: Array, sigma: Array) -> list[float] | None:
    good = np.isfinite(values) & (sigma > 0)
    if not good.any():
        return None
    weight = 1 / sigma[good] ** 2
    middle, far = np.median(values[good]), 4 * sigma[good]
    # outliers pull no further than four sigmas from the median
    mean = float(np.clip(values[good], middle - far, middle + far) @ weight / weight.sum())
    return [round(mean, 4), round(float(1 / np.sqrt(weight.sum())), 4)]


def _lean(columns: Array, x: Array, y: Array, sigma_x: Array, sigma_y: Array) -> dict[str, Any]:
    """Return the tilt toward north and east beside both zeros, None where it is not determined."""
    value, sigma = np.concatenate([x, y]), np.concatenate([sigma_x, sigma_y])
    good = np.isfinite(value) & (sigma > 0)
    design = columns.reshape(-1, 4)[good] / sigma[good, None]
    if np.linalg.matrix_rank(design, tol=1e-2 * np.sqrt(len(design))) < 4:
        return {"north": None, "east": None}
    inverse = np.linalg.inv(design.T @ design)
    values = inverse @ (design.T @ (value[good] / sigma[good]))
    errors = np.sqrt(np.diag(inverse))
    return {
        name: [round(float(values[k]), 4), round(float(errors[k]), 4)]
        for name, k in (("north", 2), ("east", 3))
    }


def suggested(own: Antenna, rows: list[Seen]) -> list[dict[str, Any]]:
    """Return where to point next: what decides between the likeliest names, else holes in the sky.

    The directions are those in which what the two likeliest changes predict differs most in
    standard deviations (T-optimal: Atkinson & Fedorov 1975, Biometrika 62, 57).
    """
    if own.pending is not None and (found := _deciding(own)):
        return found
    if not rows:
        return []
    az, el = (np.array([getattr(r, n) for r in rows]) * DEG for n in ("az_deg", "el_deg"))
    holes = coverage(az, el, LOWEST_DEG).holes[:SUGGESTED]
    return [
        {"az_deg": one.az_deg, "el_deg": one.el_deg, "why": "far from every pointing tonight"}
        for one in holes
    ]


def _deciding(own: Antenna) -> list[dict[str, Any]]:
    from pyport.effects import Circumstances
    from pyport.watch.detection.changes import columns

    layout, detector, changes = own.layout, own.detector, own.baseline.changes
    joint = (detector.log_mass + layout.log_share)[:, : layout.members]
    first = int(np.argmax(joint.max(axis=0)))
    others = [k for k, one in enumerate(changes) if one.alike != changes[first].alike]
    if not others:
        return []
    second = others[int(np.argmax(joint[:, others].max(axis=0)))]
    sky = directions(LOWEST_DEG, HIGHEST_DEG)
    at = Circumstances(sky.az, sky.el, None, {})
    predicted = []
    for change in (first, second):
        start = int(np.argmax(joint[:, change]))
        size = len(changes[change].prior)
        x, y = columns([changes[change].effect], at)
        value = detector.mean[start, change, :size]
        predicted.append(np.stack([x @ value, y @ value]))
    differ = np.hypot(*((predicted[0] - predicted[1]) / own.white[:, None]))
    names = " and ".join(changes[k].alike[0] for k in (first, second))
    found: list[dict[str, Any]] = []
    while len(found) < SUGGESTED and differ.max() > 0:
        best = int(np.argmax(differ))
        found.append(
            {
                "az_deg": float(sky.az[best] / DEG) % 360,
                "el_deg": float(sky.el[best] / DEG),
                "why": f"{names} differ there by {differ[best]:.1f} sigma",
            }
        )
        differ[separation(sky.az[best], sky.el[best], sky.az, sky.el) < APART] = 0.0
    return found
