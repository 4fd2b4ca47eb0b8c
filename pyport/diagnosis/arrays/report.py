"""An array's report: shared and own parts, implied places, whole antenna-days held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import ARCMIN, ARCSEC
from pyport.diagnosis.arrays.blocks import Block, Shape, blocks, lasting_shapes, model_shapes
from pyport.diagnosis.arrays.lasting import Lasting, lasting, well_known
from pyport.diagnosis.arrays.places import Comparison, Places, compare, places
from pyport.diagnosis.arrays.repeat import Repeat, UnseenDays, repeats, unseen_days
from pyport.diagnosis.case import Problem
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.joint import Joint, rms, visible
from pyport.diagnosis.naming.finding import Evidence, Finding, HeldOut, Parameter, Where
from pyport.diagnosis.naming.scene import axes
from pyport.effects import CATALOGUE
from pyport.errors import BadInput
from pyport.recordings.files import Survey
from pyport.recordings.schema import Recordings
from pyport.runs.workers import one_thread
from pyport.thresholds import SEVERAL, SIGNIFICANT

LEAN = "tilt_east"
#: Play in scans along elevation, which a time tag moves by the rate itself.
SCAN = "scan_direction_el"
#: What a session's antennas share: a clock moves hour angles, a time tag moves scans.
SHARED = (LEAN, "scan_direction_az", SCAN)


@dataclass(frozen=True)
class Session:
    """What one session's antennas share, and how well it tells the leans by itself.

    Attributes
    ----------
    name, antennas
        Its label, and how many antennas have enough pointings in it.
    hours
        First and last hour angle [rad], None where no site is known.
    sigma
        Median error of a lean toward east by this session alone [rad].
    inflation
        By how much the zero and the other shapes widen that error, median over antennas.
    clock
        What moved all hour angles alike, with its sigma [rad of hour angle]: the antennas' mean
        is taken for the reference, so that only its changes mean something. None without site.
    tag
        Time tag of all scans along elevation, own parts zero on average, with its sigma [s];
        None where their rate is not known.
    """

    name: str
    antennas: int
    hours: tuple[float, float] | None
    sigma: float
    inflation: float
    clock: tuple[float, float] | None
    tag: tuple[float, float] | None


@dataclass(frozen=True)
class ArrayReport:
    """What an array's recordings say beyond its findings.

    Attributes
    ----------
    shapes, blocks, parts
        What was asked for, of which blocks, and the answer.
    form, fitted
        The shapes of the model itself, and blocks that were asked for those.
    rate
        Of the scans along elevation [rad/s], None where it is not one known rate.
    sessions
        One by one.
    repeats
        Shape -> own parts of each session beside those of the others.
    places, comparison
        Implied displacements, None where no site is known; None without a survey.
    unseen
        Whole antenna-days held out, None of a single session.
    """

    shapes: tuple[Shape, ...]
    blocks: tuple[Block, ...]
    parts: Lasting
    form: tuple[Shape, ...]
    fitted: tuple[Block, ...]
    rate: float | None
    sessions: tuple[Session, ...]
    repeats: dict[str, list[Repeat]]
    places: Places | None
    comparison: Comparison | None
    unseen: UnseenDays | None

    @property
    def tag_level(self) -> float | None:
        """Return how well the time tags' level is known [s]: the error of a mean of own parts."""
        scan = number_of(self.shapes, SCAN)
        if scan is None or self.rate is None:
            return None
        own = self.parts.own[well_known(self.parts.own_covariance(scan)) > 0, scan]
        return float(np.std(own, ddof=1) / np.sqrt(len(own)) / self.rate) if len(own) > 1 else None


def number_of(shapes: Sequence[Shape], name: str) -> int | None:
    """Return the number of a shape, None where recordings do not show it."""
    names = [one.name for one in shapes]
    return names.index(name) if name in names else None


def shared_shapes(shapes: Sequence[Shape]) -> list[int]:
    """Return the shapes that a session's antennas may share."""
    return [n for n, one in enumerate(shapes) if one.name in SHARED]


@one_thread
def report(problem: Problem, fit: Joint, survey: Survey | None = None) -> ArrayReport | None:
    """Return what an array's recordings say; None where they are no array's.

    Parameters
    ----------
    problem, fit
        The case of a diagnosis, and its fit of all that was found.
    survey
        Where the antennas stand, to compare with.

    Raises
    ------
    BadInput
        There is a survey, and nothing or nobody to compare it with.
    """
    recordings, shapes, form = problem.recordings, lasting_shapes(problem), model_shapes(problem)
    found, fitted = (tuple(blocks(problem, fit, some)) for some in (shapes, form))
    lean = number_of(shapes, LEAN)
    if len({one.antenna for one in found}) < SEVERAL or lean is None:
        if survey is not None:
            raise BadInput("too few antennas with enough pointings to compare", recordings.file)
        return None
    site = recordings.at.site
    if site is None and survey is not None:
        raise BadInput("no '# latitude_deg: ...', expected it to compare places", recordings.file)
    shared = shared_shapes(shapes)
    parts = lasting(found, shared)
    several = len(parts.sessions) > 1
    implied = None if site is None else places(parts, lean, site)
    rate = _rate(recordings)
    units = {LEAN: None if site is None else float(np.cos(site.latitude)), SCAN: rate}
    return ArrayReport(
        shapes,
        found,
        parts,
        form,
        fitted,
        rate,
        tuple(_session(recordings, found, shapes, parts, name, units) for name in parts.sessions),
        {shapes[n].name: repeats(found, shared, n) for n in shared} if several else {},
        implied,
        None if implied is None or survey is None else compare(implied, survey),
        unseen_days(fitted, found, shapes, shared) if several and fitted else None,
    )


def _rate(recordings: Recordings) -> float | None:
    """Return the one rate of all scans along elevation [rad/s], None where there is none."""
    at = recordings.at
    if "scan_rate" not in at or "scan_direction" not in at:
        return None
    scanned = np.nan_to_num(np.asarray(at.column("scan_direction"), float)) != 0
    if "scan_axis" in at:
        scanned &= at.column("scan_axis") == "el"
    rates = np.unique(np.asarray(at.column("scan_rate"), float)[scanned])
    return float(rates[0]) if len(rates) == 1 and rates[0] > 0 else None


def _session(
    recordings: Recordings,
    found: Sequence[Block],
    shapes: Sequence[Shape],
    parts: Lasting,
    name: str,
    units: dict[str, float | None],
) -> Session:
    """Return what one session tells."""
    own = [one for one in found if one.session == name]
    hours = None
    if "hour_angle" in recordings.at:
        every = recordings.at.column("hour_angle")[np.concatenate([one.row for one in own])]
        hours = float(np.nanmin(every)), float(np.nanmax(every))
    session = parts.sessions.index(name)

    def common(shape: str) -> tuple[float, float] | None:
        number, unit = number_of(shapes, shape), units[shape]
        if number is None or unit is None:
            return None
        sigma = np.sqrt(parts.common_covariance(number)[session, session])
        return float(parts.common[session, number] / unit), float(sigma / unit)

    lean = number_of(shapes, LEAN)
    errors = np.array([_error(one.information, 0 if lean is None else lean) for one in own])
    free, known = errors.T
    return Session(
        name,
        len(own),
        hours,
        float(np.median(free)),
        float(np.median(free / known)),
        common(LEAN),
        common(SCAN),
    )


def _error(information: np.ndarray, shape: int) -> tuple[float, float]:
    """Return a coefficient's error with the others free, and with them known."""
    free = np.linalg.pinv(information, rcond=1e-9)[shape, shape]
    return float(np.sqrt(free)), float(1 / np.sqrt(max(information[shape, shape], 1e-300)))


_DECIDE = "compute each antenna's offsets for its own coordinates; what leans still is the mount"


def with_site(diagnosis: Diagnosis, found: ArrayReport | None) -> Diagnosis:
    """Add `site_longitude` to the findings where a survey shows that it is the site."""
    if found is None or found.comparison is None or not found.comparison.is_the_site:
        return diagnosis
    site = _finding(diagnosis, found)
    strongest_first = sorted((*diagnosis.findings, site), key=lambda one: -one.evidence.delta_bic)
    p_value = min(diagnosis.p_value, site.evidence.p_value)
    return replace(diagnosis, findings=tuple(strongest_first), p_value=p_value)


def _finding(diagnosis: Diagnosis, found: ArrayReport) -> Finding:
    problem, one = diagnosis.problem, found.comparison
    site, implied = problem.recordings.at.site, found.places
    if one is None or site is None or implied is None:
        raise ValueError("no survey was compared")
    # of longitude, as the effect's coefficient is
    radius = implied.radius_m * np.cos(site.latitude)
    shift = dict(zip(one.antennas, one.slope * one.surveyed_m / radius, strict=True))
    column = problem.stack.columns(CATALOGUE["site_longitude"], problem.recordings.at)[:, 0]
    curve = column * np.array([shift.get(str(name), 0.0) for name in problem.antenna])
    seen = visible(problem, diagnosis.weighed, curve)
    moved = np.isin(problem.antenna, one.antennas)
    standing = np.abs(one.implied_m) > SIGNIFICANT * one.sigma_m
    lean = one.lean_m / implied.radius_m / ARCMIN
    return Finding(
        effect="site_longitude",
        members=("site_longitude",),
        verdict="named",
        sentence=(
            "the antennas do not stand where their offsets were computed for: hour angles shift, "
            "or verticals lean, in proportion to the distance toward east, by "
            f"{one.slope:.2f} +- {one.slope_sigma:.2f} of what the survey asks for (correlation "
            f"{one.correlation:.2f}, {len(one.antennas)} antennas); beside it each mount leans by "
            f"{lean:.2f} arcmin of its own"
        ),
        where=Where(
            axes(problem, curve),
            {"antenna": [n for n, there in zip(one.antennas, standing, strict=True) if there]},
        ),
        parameters=(
            Parameter("implied_over_surveyed", one.slope, one.slope_sigma, "", 1.0),
            *(
                Parameter(f"longitude_error[{name}]", value, sigma, "arcsec")
                for name, value, sigma in zip(
                    one.antennas,
                    one.implied_m / radius / ARCSEC,
                    one.sigma_m / radius / ARCSEC,
                    strict=True,
                )
            ),
        ),
        evidence=Evidence(one.p_value, one.delta_bic, "tilt", 0.0),
        visible_rms=rms(seen[moved], diagnosis.share[moved]),
        true_rms=rms(curve[moved], diagnosis.share[moved]),
        heldout=HeldOut(
            "each antenna's lean from the line through all others",
            one.unseen_m[0] / implied.radius_m,
            one.unseen_m[1] / implied.radius_m,
            float(np.median(one.sigma_m)) / implied.radius_m,
        ),
        decide_by=_DECIDE,
    )
