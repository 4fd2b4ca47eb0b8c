"""Two baselines: what one would do without a diagnosis, over the classical list of pointing terms.

Terms are picked by the Bayesian information criterion (Schwarz 1978, Ann. Statist. 6, 461), the
best one first, until none lowers it; or by the lasso (Tibshirani 1996, J. R. Stat. Soc. B 58, 267)
with the largest penalty whose cross-validated error is within one standard error of the least
(Hastie, Tibshirani & Friedman 2009, The Elements of Statistical Learning, sec. 7.10). Both take
scatter for white, have one name for a term, and never say `unknown`.

The list is that of Wallace, TPOINT: zeros, axes, encoders, flexure, refraction, harmonics of
azimuth and elevation; beside it whatever is logged: time, sessions, scans, channels, the weather.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.examiner import scores
from pyport.examiner.scores import Array, both
from pyport.examiner.sealed.scoring.judge import Table, numbers, read_table

_UNITS = {"deg": 3600.0, "arcmin": 60.0, "arcsec": 1.0}
_HARMONICS = range(2, 9)
_TRACK = range(2, 5)
#: Blocks of time that are left out in turn.
_FOLDS = 5
#: The least penalty that is tried, over the one that leaves no term: below it every term is kept.
_LEAST_PENALTY = 0.02
#: What moves with the weather, or begins with a session: columns of the classical model.
_ZEROS, _TILT, _SAG = (0, 1, 2), (4, 5), (6,)


@dataclass(frozen=True)
class Term:
    """A term of the list: the name that it stands for, and its columns, shape (n, 2, k)."""

    name: str
    columns: Array
    since: str | None = None


@dataclass(frozen=True)
class Night:
    """Recordings as a baseline reads them: n offsets across and along [arcsec], NaN for none."""

    table: Table
    az: Array
    el: Array
    offsets: Array
    base: Array

    @classmethod
    def read(cls, path: Path, *, held: bool) -> Night:
        """Read recordings; `held` where the model is not to be fitted again.

        Raises `BadInput`: they have no azimuth and elevation, or no offsets.
        """
        table = read_table(path)
        if not {"az_deg", "el_deg"} <= set(table):
            raise BadInput("no az_deg and el_deg, which the list of terms needs", path)
        south = "azimuth_zero: south" in path.read_text(encoding="utf-8")
        az, el = (np.radians(numbers(table, name)) for name in ("az_deg", "el_deg"))
        az = az + np.pi * south
        across = _angle(table, "d_xel")
        x = np.where(np.isfinite(across), across, _angle(table, "d_az") * np.cos(el))
        offsets = np.stack([x, _angle(table, "d_el")], axis=1)
        if not np.isfinite(offsets).any():
            raise BadInput("no offsets that a baseline reads", path)
        return cls(table, az, el, offsets, scores.altaz(az, el)[:, :, : 0 if held else 7])

    def column(self, name: str) -> Array | None:
        """Return a logged quantity, where there is one that varies, about its mean."""
        try:
            values = numbers(self.table, name)
        except (KeyError, ValueError):
            return None
        values = np.where(np.isfinite(values), values, np.nanmean(values))
        return values - values.mean() if np.ptp(values) > 0 else None


def _angle(table: Table, name: str) -> Array:
    for unit, arcsec in _UNITS.items():
        if f"{name}_{unit}" in table:
            return numbers(table, f"{name}_{unit}") * arcsec
    return np.full(len(next(iter(table.values()))), np.nan)


def terms(night: Night) -> list[Term]:
    """Return the list of terms for some recordings."""
    found = [*_of_direction(night), *_of_sessions(night), *_of_logs(night)]
    return [one for one in found if np.ptp(one.columns, axis=0).max() > 0]


def _of_direction(night: Night) -> Iterator[Term]:
    az, el, n = night.az, night.el, len(night.el)

    def term(name: str, *columns: tuple[Array | float, Array | float]) -> Term:
        return Term(name, np.stack([both(*one, n) for one in columns], axis=2))

    across = np.cos(el)
    yield term("sag_sine", (0.0, np.sin(el)))
    yield term("refraction", (0.0, 1 / np.tan(el)))
    yield term("refraction_curvature", (0.0, 1 / np.tan(el) ** 3))
    yield term("azimuth_scale", (across * az, 0.0))
    yield term("elevation_scale", (0.0, el))
    yield term("azimuth_eccentricity", (across * np.sin(az), 0.0), (across * np.cos(az), 0.0))
    for k in _HARMONICS:
        sin, cos = np.sin(k * az), np.cos(k * az)
        yield term("azimuth_harmonics", (across * sin, 0.0), (across * cos, 0.0))
        yield term("elevation_harmonics", (0.0, sin), (0.0, cos))
        yield term("elevation_encoder_harmonics", (0.0, np.sin(k * el)), (0.0, np.cos(k * el)))
        if k in _TRACK:
            rolls = (np.sin(el) * sin, 0.0), (np.sin(el) * cos, 0.0)
            yield term("azimuth_track", (0.0, sin), (0.0, cos), *rolls)


def _of_sessions(night: Night) -> Iterator[Term]:
    """Yield zeros, tilt and sag that are others from the start of a session on."""
    if not {"session", "time_utc"} <= set(night.table):
        return
    time = np.array(night.table["time_utc"])
    classical = scores.altaz(night.az, night.el)
    session = np.array(night.table["session"])
    starts = sorted(min(time[session == one].tolist()) for one in np.unique(session))
    for start in starts[1:]:
        later = (time >= start)[:, None, None]
        for name, which in (("offset", _ZEROS), ("tilt", _TILT), ("sag", _SAG)):
            yield Term(f"epoch_{name}", later * classical[:, :, which], start)


def _of_logs(night: Night) -> Iterator[Term]:
    """Yield what goes with time, the weather, scans and channels."""
    classical, n = scores.altaz(night.az, night.el), len(night.el)
    logged = {
        name: night.column(column)
        for name, column in {
            "temperature": "temperature_c",
            "wind": "wind_speed_m_s",
            "scan": "scan_direction",
            "rate": "scan_rate_arcmin_per_min",
            "channel": "channel",
        }.items()
    }
    if "time_utc" in night.table:
        stamps = np.char.rstrip(np.array(night.table["time_utc"]), "Z").astype("datetime64[ms]")
        logged["time"] = (stamps - stamps.min()) / np.timedelta64(1, "D")
    zeros, tilt = classical[:, :, _ZEROS], classical[:, :, _TILT]
    either = np.stack([both(1.0, 0.0, n), both(0.0, 1.0, n)], axis=2)
    for name, what, columns, power in (
        ("drift", "time", zeros, 1),
        ("temperature", "temperature", zeros, 1),
        ("thermal_tilt", "temperature", tilt, 1),
        ("wind_tilt", "wind", tilt, 2),
        ("scan_direction", "scan", either, 1),
        ("scan_timing", "rate", either, 1),
        ("beam_squint", "channel", either, 1),
    ):
        if (values := logged.get(what)) is not None:
            yield Term(name, (values**power)[:, None, None] * columns)


@dataclass(frozen=True)
class Problem:
    """Measured numbers m in units of their axis's scatter, what is fitted anyway, and the terms."""

    data: Array
    base: Array
    terms: list[tuple[Term, Array]]

    @classmethod
    def of(cls, night: Night) -> Problem:
        """Weight both axes by the scatter that the model leaves."""
        known = np.isfinite(night.offsets)
        left = np.where(known, night.offsets, 0.0)
        base = night.base[known]
        residual = left[known] - base @ np.linalg.lstsq(base, left[known], rcond=None)[0]
        spread = np.zeros_like(left)
        spread[known] = residual
        count = np.maximum(known.sum(axis=0), 1)
        sigma = np.maximum(np.sqrt((spread**2).sum(axis=0) / count), 1e-9)
        weight = np.broadcast_to(1 / sigma, left.shape)[known]
        listed = [(one, one.columns[known] * weight[:, None]) for one in terms(night)]
        return cls(left[known] * weight, base * weight[:, None], listed)


def by_bic(problem: Problem) -> list[tuple[Term, Array, Array]]:
    """Return the terms picked by BIC in their order, with values and sigmas in arcsec."""
    design, picked = problem.base, []
    rest = list(problem.terms)
    best = _bic(design, problem.data)
    while rest:
        tried = [_bic(np.hstack([design, columns]), problem.data) for _, columns in rest]
        at = int(np.argmin(tried))
        if tried[at] >= best:
            break
        best = tried[at]
        picked.append(rest.pop(at))
        design = np.hstack([design, picked[-1][1]])
    values = np.asarray(np.linalg.lstsq(design, problem.data, rcond=None)[0], float)
    spare = max(len(problem.data) - design.shape[1], 1)
    variance = np.sum((problem.data - design @ values) ** 2) / spare
    sigmas: Array = np.sqrt(variance * np.diag(np.linalg.pinv(design.T @ design)))
    found: list[tuple[Term, Array, Array]] = []
    at = problem.base.shape[1]
    for term, columns in picked:
        to = at + columns.shape[1]
        found.append((term, values[at:to], sigmas[at:to]))
        at = to
    return found


def _bic(design: Array, data: Array) -> float:
    n, (values, _, rank, _) = len(data), np.linalg.lstsq(design, data, rcond=1e-9)
    squares = max(float(np.sum((data - design @ values) ** 2)), 1e-300)
    return n * np.log(squares / n) + float(rank) * np.log(n)


def by_lasso(problem: Problem) -> list[tuple[Term, Array, Array]]:
    """Return the terms that the lasso keeps, the largest first, with values in arcsec."""
    try:
        from sklearn.linear_model import Lasso, LassoCV
    except ImportError:
        raise BadInput(
            "the lasso needs scikit-learn: pip install 'pyport-pointing[challenge]'"
        ) from None
    design = np.hstack([columns for _, columns in problem.terms])
    # What is fitted anyway pays no penalty: it is taken out of both sides.
    ortho = np.linalg.qr(problem.base)[0]
    left = design - ortho @ (ortho.T @ design)
    data = problem.data - ortho @ (ortho.T @ problem.data)
    norm = np.sqrt(np.mean(left**2, axis=0))
    usable = norm > 1e-6 * np.sqrt(np.mean(design**2, axis=0))
    scaled = left[:, usable] / norm[usable]
    blocks = np.arange(len(data)) * _FOLDS // len(data)
    folds = [(np.flatnonzero(blocks != n), np.flatnonzero(blocks == n)) for n in range(_FOLDS)]
    fitted = LassoCV(alphas=40, eps=_LEAST_PENALTY, cv=folds, fit_intercept=False, tol=1e-3)
    with warnings.catch_warnings():
        # Columns that are nearly alike take long to agree; the error has long ceased to change.
        warnings.simplefilter("ignore")
        fitted.fit(scaled, data)
    error = fitted.mse_path_.mean(axis=1)
    best = int(np.argmin(error))
    allowed = error[best] + fitted.mse_path_[best].std() / np.sqrt(_FOLDS)
    alpha = fitted.alphas_[np.flatnonzero(error <= allowed)[0]]
    values = np.zeros(design.shape[1])
    values[usable] = Lasso(alpha, fit_intercept=False).fit(scaled, data).coef_ / norm[usable]
    found, at = [], 0
    for term, columns in problem.terms:
        own = values[at : at + columns.shape[1]]
        at += columns.shape[1]
        if own.any():
            size = float(np.mean((columns @ own) ** 2))
            found.append((size, (term, own, np.full(len(own), np.nan))))
    return [one for _, one in sorted(found, key=lambda pair: -pair[0])]


#: Baselines by name.
METHODS: dict[str, Callable[[Problem], Sequence[tuple[Term, Array, Array]]]] = {
    "bic": by_bic,
    "lasso": by_lasso,
}


def answer(method: str, recordings: Path, arguments: Sequence[str] = ()) -> dict[str, Any]:
    """Return a baseline's answer to some recordings, in the form of a report.

    `arguments`: what the case was sealed with; `--refit none` holds the model.
    """
    try:
        picked = METHODS[method](Problem.of(Night.read(recordings, held="none" in arguments)))
    except (BadInput, np.linalg.LinAlgError, ValueError) as error:
        return {"findings": [], "examined": {"failed": str(error)}}
    findings: dict[str, dict[str, Any]] = {}
    for term, values, sigmas in picked:
        one = findings.setdefault(
            term.name,
            {
                "effect": term.name,
                "class": [term.name],
                "verdict": "named",
                "where": {"since": term.since},
                "parameters": [],
            },
        )
        if len(values) == 1:
            sigma = float(sigmas[0]) if np.isfinite(sigmas[0]) else None
            one["parameters"] = [{"name": term.name, "value": float(values[0]), "sigma": sigma}]
    return {"mismatch": bool(findings), "findings": list(findings.values()), "examined": {}}
