"""What past recordings say: the model's terms, the noise, and what may change.

The noise is that of `pyport.noise`, written as the states of a filter: coefficients that stay,
departures that each session or source draws anew, drifts that forget.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.candidates import conditions
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.fitting.fit import Fit, fit
from pyport.models.model import Model, Term
from pyport.noise.estimation.departing import terms_of_sessions, terms_of_sources
from pyport.noise.scatter import recorded
from pyport.recordings.schema import Recordings
from pyport.watch.detection import changes
from pyport.watch.detection.changes import Change

#: Past pointings below which nothing is watched; so many for each coefficient of the model.
FEWEST, FEWEST_PER_COEFFICIENT = 30, 3
#: So many for each coefficient where the past may be chosen: of p coefficients from n pointings of
#: two readings the errors add p / 2n to the variance of a prediction, a twentieth.
ENOUGH_PER_COEFFICIENT = 10
#: Processes that the drift of an axis is drawn together into, and the share of its variance below
#: which one is left out.
MOST_DRIFTS, FAINT_DRIFT = 3, 0.02
#: What the scatter follows is read off the past with so many readings' worth of doubt.
DOUBT = 1.0
#: The coefficients are unknown beforehand: up to so many times the largest offset.
BEYOND = 30.0
#: So many sources, those visited most, have a place of their own that comes back with them; the
#: place of another one is unknown whenever the telescope turns to it.
MOST_SOURCES = 24
#: Departures are known from so many deviations at least, for their variance to be finite.
LEAST_DOF = 3.0
#: No white scatter is below this share of what the model leaves: rounded offsets repeat exactly.
LEAST_WHITE = 0.05


def enough(model: Model) -> int:
    """Return how many pointings make a past, where it may be chosen."""
    count = sum(len(term.effect.coefficients) for term in model.fitted())
    return max(FEWEST, ENOUGH_PER_COEFFICIENT * count)


class TooFew(BadInput):
    """The past of an antenna is too short to watch it."""


@dataclass(frozen=True)
class Nuisance:
    """States of one kind that move offsets and are no alarm."""

    term: str  #: which columns: a term's place in the model, the name of a departure, `xel` or `el`
    of: str  #: `model`, `session`, `source`, `sources known`, `pointing` or `drift`
    mean: Array  #: before any reading, and again whenever the label changes, shape (k,)
    covariance: Array  #: likewise, shape (k, k)
    memory_s: float = np.inf  #: of a drift; infinite for what does not forget
    #: The one source whose rows it moves; "" for all that have no states of their own.
    label: str = ""


@dataclass(frozen=True)
class Baseline:
    """The past of one antenna, ready to be compared with what comes."""

    antenna: str  #: which
    model: Model  #: the model, its terms fitted or given
    terms: tuple[Term, ...]  #: its fitted terms
    nuisances: tuple[Nuisance, ...]  #: the states
    white: Array  #: white variance of a usual reading of either axis [rad^2], (2,)
    scatter: Array  #: coefficients of the log-variance on `_follows`, (k,)
    #: Median recorded error of either axis [rad], NaN where errors are not used, (2,).
    recorded_median: Array
    coupling: float  #: correlation of both axes' white scatter
    changes: tuple[Change, ...]  #: what is watched for
    rows: int  #: past pointings
    axes: tuple[str, str]  #: what the offsets across and along are called on this mount

    def design(self, at: Circumstances) -> tuple[Array, Array]:
        """Return what one of each state does to either axis, (n, D) each."""
        zero = np.zeros((len(at), 1))
        departing = {"session": terms_of_sessions(at), "source": terms_of_sources(at)}
        found: list[tuple[Array, Array]] = [(zero[:, :0], zero[:, :0])]
        known = {one.label for one in self.nuisances if one.label}
        for one in self.nuisances:
            size = len(one.mean)
            if one.of in ("pointing", "drift"):
                found.append((zero + 1, zero) if one.term == "xel" else (zero, zero + 1))
            elif one.term.isdigit():
                found.append(changes.columns([self.terms[int(one.term)].effect], at))
            else:
                nothing = np.zeros((len(at), size))
                x, y = departing[one.of.removesuffix("s known")].get(one.term, (nothing, nothing))
                here = _rows_of(at, one, known)
                found.append((x * here, y * here))
        return np.concatenate([x for x, _ in found], 1), np.concatenate([y for _, y in found], 1)

    def variance(self, recordings: Recordings) -> Array:
        """Return the white variance of the readings of some rows [rad^2], (n, 2)."""
        sigma = np.stack([recordings.sigma_x, recordings.sigma_y], axis=1)
        follows = _follows(recordings.at, sigma / self.recorded_median)
        return np.asarray(self.white * np.exp(follows @ self.scatter))


@dataclass(frozen=True)
class Past:
    """A baseline and the recordings it was made from, with their robust weights, (n, 2)."""

    baseline: Baseline
    recordings: Recordings
    weights: Array


def _rows_of(at: Circumstances, one: Nuisance, known: Collection[str]) -> Array:
    """Return one in the rows that a departure moves, zero in the others, (n, 1)."""
    if not one.of.startswith("source") or "source" not in at:
        return np.ones((len(at), 1))
    source = at.column("source").astype(str)
    here = (source == one.label) if one.label else ~np.isin(source, list(known))
    return np.asarray(here, float)[:, None]


def past(history: Recordings, model: Model, antenna: str | None = None) -> Past:
    """Return what past recordings, of one antenna where there are several, say of a model.

    The recordings are `pyport.fitting.fit.in_sessions`.

    Raises `BadInput`: there are too few of them, or the model lacks something.
    """
    terms = tuple(model.fitted())
    if antenna is not None:
        history = history.take(history.label("antenna").astype(str) == antenna)
    needed = max(FEWEST, FEWEST_PER_COEFFICIENT * sum(len(t.effect.coefficients) for t in terms))
    if len(history) < needed:
        whose = f" of antenna {antenna}" if antenna else ""
        wrong = f"{len(history)} past pointings{whose}, expected {needed} or more to watch from"
        raise TooFew(wrong, history.file)
    fitted = fit(history, model)
    white, within = _white(fitted)
    scatter, median = _scatter(fitted)
    coupling = next(iter(fitted.noise.coupling.values()), 0.0)
    nuisances = (
        *_terms(fitted, terms),
        *_departures(fitted, history),
        *(
            Nuisance(name, "pointing", np.zeros(1), np.array([[white[axis]]]))
            for axis, name in enumerate(("xel", "el"))
            if within[axis] > 0
        ),
        *_drifts(fitted),
    )
    whole = np.where(within > 0, within, white)
    made = Baseline(
        antenna or "",
        model,
        terms,
        nuisances,
        whole,
        scatter,
        median,
        coupling,
        (),
        len(history),
        history.at.mount.names,
    )
    usual = made.variance(history) + np.where(within > 0, white, 0.0)
    usual[~np.isfinite(np.stack([history.x, history.y], axis=1))] = np.inf
    departing = {one.of for one in nuisances}
    watched = changes.possible(
        conditions(history), usual, [term.effect for term in terms], departing
    )
    weights = np.ones((len(history), 2))
    weights[fitted.stack.row, fitted.stack.is_y.astype(int)] = fitted.weight
    return Past(replace(made, changes=watched), history, weights)


def _white(fitted: Fit) -> tuple[Array, Array]:
    """Return the variance of pointings and of readings within one, of either axis [rad^2]."""
    found = np.ones((2, 2))
    for part, noise in zip(fitted.noise.parts, fitted.noise.noises, strict=True):
        least = (LEAST_WHITE * noise.floor) ** 2
        between = max((noise.between / noise.tail) ** 2, least)
        found[:, int(part.is_y)] = between, noise.within**2
    return found[0], found[1]


def _terms(fitted: Fit, terms: Sequence[Term]) -> list[Nuisance]:
    """Return the coefficients of the model, unknown beforehand.

    What is fitted for each session scatters about its mean over the sessions.
    """
    largest = BEYOND * float(np.abs(fitted.stack.value).max(initial=1e-6))
    found = []
    for n, term in enumerate(terms):
        own = [one for one in fitted.coefficients if one.term is term]
        values = np.array([one.value for one in own])
        given = np.array([term.given(one.labels) for one in own])
        size = len(term.effect.coefficients)
        if term.of_session and len(values) > 1:
            values = np.nan_to_num(values - given)
            mean, spread = values.mean(axis=0), np.cov(values.T, ddof=1).reshape(size, size)
            found.append(Nuisance(str(n), "session", mean, spread))
            continue
        scale = np.array([abs(one.scale) for one in term.effect.coefficients])
        known = np.abs(np.nan_to_num(values - given)).max(axis=0, initial=0.0)
        sigma = np.maximum(largest * scale / scale.max(), BEYOND * known)
        found.append(Nuisance(str(n), "model", np.zeros(size), np.diag(sigma**2)))
    return found


def _departures(fitted: Fit, recordings: Recordings) -> list[Nuisance]:
    """Return what departs, as far as so few sessions or sources tell how much.

    A variance known from d deviations leaves the next departure a Student's t of d degrees of
    freedom, whose variance is d / (d - 2) times as large.
    """
    found = []
    for one in fitted.noise.departures:
        count = len(set(one.labels))
        size = one.columns.shape[1] // count
        dof = max((count - 1) * size, LEAST_DOF)
        variance = one.sigma**2 * dof / (dof - 2)
        states = np.zeros(size), variance * np.eye(size)
        found.append(Nuisance(one.term, one.of, *states))
        if one.of == "source":
            name, visits = np.unique(recordings.label("source").astype(str), return_counts=True)
            most = filter(None, name[np.argsort(-visits, kind="stable")[:MOST_SOURCES]].tolist())
            found += [Nuisance(one.term, "sources known", *states, label=each) for each in most]
    return found


def _drifts(fitted: Fit) -> list[Nuisance]:
    """Return the drifts of either axis, those of similar memory drawn together.

    Few memories of a slow drift fit into the past, so that its variance is known from as few
    deviations: as with departures, it counts for more. One that outlasts the past stands for what
    it changes within it.
    """
    found = []
    for part, noise in zip(fitted.noise.parts, fitted.noise.noises, strict=True):
        drifts = noise.shown_within(part.span).drifts
        if not drifts:
            continue
        amplitude, memory = np.array(drifts).T
        least = FAINT_DRIFT * (float(amplitude @ amplitude) + noise.between**2)
        for own in np.array_split(np.argsort(memory, kind="stable"), min(MOST_DRIFTS, len(memory))):
            power = amplitude[own] ** 2
            if power.sum() < least:
                continue
            middle = float(np.exp(power @ np.log(memory[own]) / power.sum()))
            name = "el" if part.is_y else "xel"
            dof = max(part.span / middle, LEAST_DOF)
            spread = np.array([[power.sum() * dof / (dof - 2)]])
            found.append(Nuisance(name, "drift", np.zeros(1), spread, middle))
    return found


def _follows(at: Circumstances, error: Array) -> Array:
    """Return what the log-variance may follow, (n, 2, k): elevation, azimuth, wind, own error."""
    n = len(at)
    wind = np.zeros(n)
    if "wind_speed_m_s" in at:
        wind = np.nan_to_num(np.asarray(at.column("wind_speed_m_s"), float))
    turns = [f(k * at.az) for k in (1, 2) for f in (np.cos, np.sin)]
    one = np.stack([np.ones(n), -np.log(np.maximum(np.sin(at.el), 0.02)), *turns, wind], axis=1)
    both = np.repeat(one[:, None, :], 2, axis=1)
    own = np.log(np.where(np.isfinite(error) & (error > 0), error, 1.0)) * 2
    return np.concatenate([both, own[:, :, None]], axis=2)


def _scatter(fitted: Fit) -> tuple[Array, Array]:
    """Return the log-variance's coefficients, as the precision of past readings has them."""
    recordings, data = fitted.recordings, fitted.stack
    sigma = np.stack([recordings.sigma_x, recordings.sigma_y], axis=1)
    median = np.full(2, np.nan)
    if recorded(recordings, data) is not None:
        known = np.where(np.isfinite(sigma) & (sigma > 0), sigma, np.nan)
        some = [one[np.isfinite(one)] for one in known.T]
        median = np.array([np.median(one) if len(one) else np.nan for one in some])
    follows = _follows(recordings.at, sigma / median)[data.row, data.is_y.astype(int)]
    wanted = -np.log(fitted.noise.precision)
    inner = follows.T @ follows + DOUBT * np.eye(follows.shape[1])
    return np.linalg.solve(inner, follows.T @ wanted), median
