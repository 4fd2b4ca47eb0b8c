"""From scans to offsets: an antenna crosses a source, the peak comes early or late.

The axis moves at a constant rate and stands at the source's computed place at
the expected time. If power peaks at another time, the axis stood at
direction * rate * (observed - expected) from there: encoder minus true. The
GMRT paper (section 1) prints (expected - observed) * rate / 60 in degrees,
times cos El along azimuth: minutes, not hours as it says, and the direction's
sign left to the reader.

Section 3 of the GMRT paper: set the offsets to zero, scan forward and reverse
twice, load the average, scan again; the second round should be near zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCMIN, Array
from pyport.columns import SCAN_RATE, SCAN_RATE_UNIT, SET_ASIDE, TIME
from pyport.recordings.formats import csv
from pyport.recordings.interpret import interpret
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings

#: Exponent of a Gaussian in units of its full width at half maximum.
SHAPE = 4 * np.log(2)

#: A peak is one from this many sigmas of its height on.
DETECTED = 5.0

#: Unknowns of the fit: height, time, width, and the baseline's level and slope.
UNKNOWNS = 5


@dataclass(frozen=True)
class Peak:
    """A beam's crossing."""

    #: `time_s`, `sigma_s`: when it was at its height, on the samples' clock, and the one-sigma
    #: error [s].
    time_s: float
    sigma_s: float
    width_s: float  #: full width at half maximum [s]
    #: `height`, `noise`: in the unit of the power: the beam's height, the scatter of a sample.
    height: float
    noise: float


def fit_peak(time_s: Array, power: Array) -> Peak | str:
    """Fit a Gaussian and a straight baseline to power against time.

    `time_s`, `power`: samples of one scan, shape (n,); NaN where a sample is missing.
    Returns the peak, or why there is none.
    """
    good = np.isfinite(time_s) & np.isfinite(power)
    if good.sum() <= 2 * UNKNOWNS:
        return f"{good.sum()} samples, expected more than {2 * UNKNOWNS}"
    t, p = time_s[good], power[good]
    span, scale = float(np.ptp(t)), float(np.ptp(p))
    if span == 0 or scale == 0:
        return f"no peak: the {'power' if span else 'time'} is constant"
    # times from -1/2 to 1/2 and powers of order 1, so that all unknowns are alike
    middle = float(t.min() + t.max()) / 2
    u, v = (t - middle) / span, (p - np.median(p)) / scale
    (height, centre, width), (sigma_height, sigma_centre), noise = _bell(u, v)
    if height < DETECTED * sigma_height:
        return f"no peak: {height / sigma_height:.1f} sigmas high"
    if abs(centre) > 0.5:
        return "no peak within the scan"
    if not 2 * np.median(np.diff(np.sort(u))) < width < 1:
        return "no peak: its width is not a beam's"
    return Peak(
        middle + span * centre, span * sigma_centre, span * width, scale * height, scale * noise
    )


def _bell(u: Array, v: Array) -> tuple[tuple[float, float, float], tuple[float, float], float]:
    """Return height, centre and width; the sigmas of the first two; and the noise."""
    from scipy.optimize import least_squares

    def left(unknowns: Array) -> Array:
        height, centre, width, base, slope = unknowns
        return height * np.exp(-SHAPE * ((u - centre) / width) ** 2) + base + slope * u - v

    def jacobian(unknowns: Array) -> Array:
        height, centre, width, _, _ = unknowns
        apart = (u - centre) / width
        bell = np.exp(-SHAPE * apart**2)
        steep = 2 * SHAPE * height * bell * apart / width
        return np.stack([bell, steep, steep * apart, np.ones_like(u), u], axis=1)

    found = least_squares(left, _start(u, v), jacobian, method="lm")
    noise = float(np.sqrt(2 * found.cost / (len(u) - UNKNOWNS)))
    variance = np.diag(np.linalg.pinv(found.jac.T @ found.jac)) * noise**2
    height, centre, width = (float(one) for one in found.x[:3])
    sigmas = [max(float(np.sqrt(one)), 1e-300) for one in variance[:2]]
    return (height, centre, abs(width)), (sigmas[0], sigmas[1]), noise


def _start(u: Array, v: Array) -> Array:
    """Return the bell of a grid of centres and widths that takes most out of the power."""
    line = np.linalg.qr(np.stack([np.ones_like(u), u], axis=1))[0]
    rest = v - line @ (line.T @ v)
    best, start = 0.0, np.array([0.0, 0.0, 0.1, 0.0, 0.0])
    for width in (0.04, 0.1, 0.2, 0.4):
        centres = np.arange(-0.48, 0.5, width / 4)
        bells = np.exp(-SHAPE * ((u[:, None] - centres) / width) ** 2)
        bells -= line @ (line.T @ bells)
        size = np.maximum((bells**2).sum(axis=0), 1e-12)
        heights = rest @ bells / size
        gains = np.where(heights > 0, heights**2 * size, 0)
        one = int(gains.argmax())
        if gains[one] > best:
            best = float(gains[one])
            start = np.array([heights[one], centres[one], width, 0.0, 0.0])
    return start


#: Columns that tell one scan of one antenna's channel from another.
KEYS = ("session", "scan", "antenna", "channel")
#: Labels of scans alone, text also where they are numbers.
LABELS = ("scan", "round")

POWER = "power"
EXPECTED = "expected_utc"
#: Error of the offset along the scan, until it is known across what.
SIGMA = "sigma_along_arcmin"

REQUIRED = ("scan", TIME, POWER, EXPECTED, "scan_axis", "scan_direction", SCAN_RATE)


def offset_along_scan(
    observed_s: float, expected_s: float, direction: float, rate_per_s: float
) -> float:
    """Return the offset of the scanned axis, encoder minus true, in the rate's unit of angle.

    `observed_s`, `expected_s`: when power peaked, and when the axis stood at the source's computed
      place [s].
    `direction`: +1 for a scan toward larger angles, -1 for one back.
    `rate_per_s`: angle per second, positive; of the axis, so along azimuth not yet times cos El.
    """
    return direction * rate_per_s * (observed_s - expected_s)


def measure(path: str | Path) -> Recordings:
    """Return one recording for each scan, antenna and channel of a file of samples.

    The file is a CSV with a row for each sample: `scan`, `time_utc`, `power`,
    and the same in all rows of a scan `expected_utc`, `scan_axis` (az or el),
    `scan_direction`, `scan_rate_arcmin_per_min`, besides `antenna`, `channel`
    and whatever else recordings may tell. Scans without a peak are excluded.

    Raises `BadInput`: with file and line: what is wrong and what was expected.
    """
    samples = csv.read(Path(path))
    for name in REQUIRED:
        if name not in samples.columns:
            raise samples.error(f"no column {name}, expected {', '.join(REQUIRED)}")
    time, power = samples.seconds(TIME), samples.numbers(POWER)
    first, member = _scans(samples)
    expected = samples.seconds(EXPECTED)[first]
    direction, rate = (samples.numbers(name)[first] for name in ("scan_direction", SCAN_RATE))
    axis = samples.words("scan_axis")[first]
    whole = Raw(samples.file, samples.meta, samples.header_line, {}, samples.line[first])
    whole.refuse(np.isnan(expected), f"{EXPECTED} is blank, expected a time")
    whole.refuse(np.abs(direction) != 1, "scan_direction is not +1 or -1")
    whole.refuse(~(rate > 0), f"{SCAN_RATE} is not positive")
    whole.refuse(~np.isin(axis, ("az", "el")), "scan_axis is not az or el")

    labels = [(key, samples.words(key)[first]) for key in KEYS if key in samples.columns]
    peaks = [
        fit_peak(time[member == number] - expected[number], power[member == number])
        for number in range(len(first))
    ]
    rate *= SCAN_RATE_UNIT / ARCMIN
    found = [
        (offset_along_scan(peak.time_s, 0.0, way, speed), speed * peak.sigma_s, "")
        if isinstance(peak, Peak)
        else (np.nan, np.nan, f"{peak} ({', '.join(f'{key} {of[n]}' for key, of in labels)})")
        for n, (peak, way, speed) in enumerate(zip(peaks, direction, rate, strict=True))
    ]
    offset, sigma = (np.array([one[k] for one in found]) for k in range(2))
    columns = {n: c[first] for n, c in samples.columns.items() if n not in {TIME, POWER, EXPECTED}}
    columns |= {
        TIME: samples.columns[EXPECTED][first],
        "d_az_arcmin": np.where(axis == "az", offset, np.nan),
        "d_el_arcmin": np.where(axis == "el", offset, np.nan),
        SIGMA: sigma,
        SET_ASIDE: np.array([one[2] for one in found], np.str_),
    }
    return _with_sigmas(interpret(replace(whole, columns=columns)))


def _scans(samples: Raw) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first row of each scan, and which scan each row belongs to; refuse changes."""
    keys = np.stack([samples.words(key) for key in KEYS if key in samples.columns], axis=1)
    _, first, member = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    first, member = first[order], np.argsort(order)[member.reshape(-1)]
    for name in set(samples.columns) - {TIME, POWER}:
        cells = samples.words(name)
        changed = np.flatnonzero(cells != cells[first][member])
        if changed.size:
            raise samples.error(f"{name} changes within a scan, expected one value", changed[0])
    return first, member


def _with_sigmas(measured: Recordings) -> Recordings:
    """Return recordings with the errors along each scan moved to the scanned axis, and labels."""
    columns = dict(measured.at.columns)
    columns |= {name: _as_words(columns[name]) for name in LABELS if name in columns}
    error = columns.pop(SIGMA) * ARCMIN
    along_az = columns["scan_axis"] == "az"
    return replace(
        measured,
        at=replace(measured.at, columns=columns),
        sigma_x=np.where(along_az, error * np.cos(measured.at.el), np.nan),
        sigma_y=np.where(along_az, np.nan, error),
    )


def _as_words(labels: NDArray[Any]) -> NDArray[np.str_]:
    """Return labels as text, whole numbers without a point, "" for blank."""
    if labels.dtype.kind == "U":
        return labels
    return np.array(["" if one != one else f"{one:.15g}" for one in labels], np.str_)  # noqa: PLR0124


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
    antenna, rounds = recordings.label("antenna"), recordings.label("round")
    direction = recordings.at.column("scan_direction")
    found = []
    for axis, offset in (("az", recordings.x), ("el", recordings.y)):
        here = np.isfinite(offset)
        for name, turn in sorted(set(zip(antenna[here], rounds[here], strict=True))):
            own = here & (antenna == name) & (rounds == turn)
            found.append(_average(str(name), axis, str(turn), offset[own], direction[own]))
    return found


def _average(antenna: str, axis: str, turn: str, offset: Array, direction: Array) -> Average:
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


def _arcmin(angle: float, form: str) -> str:
    """Return an angle in arcminutes as a table has it, a dash for none."""
    text = f"{angle / ARCMIN:{form}}"
    return text if np.isfinite(angle) else "-".rjust(len(text))


def text(found: list[Average]) -> str:
    """Return the averages as a table in arcminutes, with a verdict on the later rounds."""
    first = min((one.round for one in found), default="")
    lines = ["antenna  axis  round  offset ['] +- sigma   half difference [']  scans"]
    for one in found:
        verdict = ""
        if one.round != first and np.isfinite(one.offset):
            verdict = "  near zero" if one.near_zero else "  NOT near zero: load and scan again"
        lines.append(
            f"{one.antenna:7}  {one.axis:4}  {one.round:5}  {_arcmin(one.offset, '+9.3f')} "
            f"+- {_arcmin(one.sigma, '6.3f')}  {_arcmin(one.half_difference, '+19.3f')}  "
            f"{one.scans:5}{verdict}"
        )
    return "\n".join(lines)
