"""Two models held against each other before the mount is given the new one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.correction.use import PointingModel
from pyport.effects import Circumstances, MissingColumn, Site
from pyport.effects.circumstances import PIER_SIDE
from pyport.effects.empirical.drivers import unit_in_words
from pyport.models.conditions import Columns, Value
from pyport.mounts import ALTAZ, Mount
from pyport.recordings.schema import Recordings, as_input
from pyport.recordings.sky import with_nights

#: The sky is compared in steps of so many degrees, down to this elevation.
STEP_DEG, LOWEST_DEG = 3.0, 5.0
#: Beyond this distance from every recording a direction was not observed [deg]: terms of a
#: pointing model change by a few percent over it.
REACH_DEG = 15.0
#: A recording gets worse by more than this [arcsec]: other programs' files round coefficients to
#: some ten thousandths, and a model is no worse than its own copy.
WORSE_ARCSEC = 1e-3
#: A change within so many sigmas of nothing has no significance.
SIGNIFICANT = 2.0
#: The bands where an unsound term does its harm: the horizon and the zenith [deg].
HORIZON_DEG, ZENITH_DEG = (5.0, 15.0), (80.0, 89.0)


@dataclass(frozen=True)
class Sky:
    """How far commanded positions move over the sky."""

    #: `az_deg`, `el_deg`: directions, shape (n,).
    az_deg: Array
    el_deg: Array
    #: `x_arcsec`, `y_arcsec`: new minus old, across and along elevation, shape (n,).
    x_arcsec: Array
    y_arcsec: Array
    #: Whether a recording is near; all True where there are none to tell.
    observed: NDArray[np.bool_]
    conditions: Mapping[str, str]  #: what the comparison is for beside directions, by column

    @property
    def size_arcsec(self) -> Array:
        """Return how far each direction moves."""
        return np.hypot(self.x_arcsec, self.y_arcsec)

    def rms_arcsec(self, where: NDArray[np.bool_] | None = None) -> float:
        """Return the rms of the move over the sky, or a part of it, by area."""
        weight = np.cos(self.el_deg * DEG) * (1.0 if where is None else where)
        return float(np.sqrt((self.size_arcsec**2 * weight).sum() / max(weight.sum(), 1e-300)))

    def share(self, beyond_arcsec: float) -> float:
        """Return the share of the sky that moves by more than some size."""
        weight = np.cos(self.el_deg * DEG)
        return float((weight * (self.size_arcsec > beyond_arcsec)).sum() / weight.sum())


@dataclass(frozen=True)
class Rows:
    """What both models leave of recordings."""

    line: NDArray[np.int64]  #: of the file, shape (n,)
    #: `before_arcsec`, `after_arcsec`: size of what is left of each recording, both axes together,
    #: shape (n,).
    before_arcsec: Array
    after_arcsec: Array
    #: `rms_before`, `rms_after`: by axis, and `sky` over both by the recording [arcsec].
    rms_before: dict[str, float]
    rms_after: dict[str, float]
    axes: Mapping[str, str]  #: what is said for `xel` and `el`, see `spoken_axes`

    @property
    def worse(self) -> NDArray[np.intp]:
        """Return the rows that get worse, the worst first."""
        change = self.after_arcsec - self.before_arcsec
        order = np.argsort(-change, kind="stable")
        return order[change[order] > WORSE_ARCSEC]


@dataclass(frozen=True)
class Unsound:
    """A change without significance that moves the horizon or the zenith."""

    value: Value
    horizon_arcsec: float
    zenith_arcsec: float

    @property
    def refused(self) -> bool:
        """Tell whether the term itself has no significance, so that it should not be there."""
        return abs(self.value.value) < SIGNIFICANT * (self.value.sigma or 0.0)

    def words(self, scatter_arcsec: float) -> str:
        """Return it as a sentence."""
        one, unit = self.value, unit_in_words(self.value.unit)
        most = max(self.horizon_arcsec, self.zenith_arcsec)
        where = "horizon" if self.horizon_arcsec >= self.zenith_arcsec else "zenith"
        moves = f"moves the {where} by {most:.3g} arcsec, more than the scatter of"
        if self.refused:
            said = f"{one.name} is {one.value:.3g} +- {one.sigma:.3g} {unit}, which is not "
            return f"{said}significant, and {moves} {scatter_arcsec:.3g}: drop or fix it"
        said = f"{one.name} changes by {one.change:+.3g} +- {one.sigma:.3g} {unit}, within its"
        advice = f"keep the old value with --fix {one.name}, or observe there"
        return f"note: {said} error, and {moves} {scatter_arcsec:.3g}: {advice}"


@dataclass(frozen=True)
class Comparison:
    """How a new model differs from an old one.

    `scatter_arcsec` is that of the data about the new model, None where nothing tells it. Of the
    `unsound` changes those are `refused` whose term is itself within two sigmas of nothing.
    """

    sky: Sky
    rows: Rows | None
    unsound: tuple[Unsound, ...]
    scatter_arcsec: float | None
    input: dict[str, Any] | None = None  #: the recordings as `as_input` says; None without any

    @property
    def refused(self) -> tuple[Unsound, ...]:
        """Return the changes that the mount should not be given."""
        return tuple(one for one in self.unsound if one.refused)


def compare(
    old: PointingModel,
    new: PointingModel,
    recordings: Recordings | None = None,
    conditions: Columns | None = None,
    site: Site | None = None,
) -> Comparison:
    """Return how far a new model moves commanded positions, and what it does to recordings.

    `old`, `new`: models with coefficients.
    `recordings`: measured offsets; also where the sky was observed and in which conditions.
    `conditions`: what holds for the whole sky beside directions, by column.
    `site`: where the telescope stands, if neither the models nor the recordings tell.
    Raises `BadInput`: a model needs a condition that neither the recordings nor `conditions` tell.
    """
    recordings = None if recordings is None else with_nights(recordings)
    rows = None if recordings is None else _rows(old, new, recordings)
    scatter = None if rows is None else rows.rms_after["sky"]
    if scatter is None and new.model.completed is not None:
        scatter = new.model.completed.made.get("sky_rms_arcsec")
    site = recordings.at.site if recordings is not None and recordings.at.site else site
    sky = _sky(old, new, recordings, conditions or {}, site)
    source = None if recordings is None else as_input(recordings)
    return Comparison(sky, rows, _unsound(new, scatter), scatter, source)


def _sky(
    old: PointingModel,
    new: PointingModel,
    recordings: Recordings | None,
    conditions: Columns,
    site: Site | None,
) -> Sky:
    az_deg, el_deg = (
        one.ravel()
        for one in np.meshgrid(
            np.arange(0.0, 360.0, STEP_DEG), np.arange(LOWEST_DEG, 90.0, STEP_DEG), indexing="ij"
        )
    )
    given = {name: np.asarray(one).reshape(-1)[:1] for name, one in conditions.items()}
    needed = {name for one in (old, new) for name in one.columns_needed()}
    if any(one.model.mount.turns_over for one in (old, new)):
        needed.add(PIER_SIDE)
    for name in needed - set(given):
        usual = None if recordings is None else _usual(recordings, name)
        if usual is not None:
            given[name] = usual
    columns = {name: np.repeat(one, len(az_deg)) for name, one in given.items()}
    at = Circumstances(az_deg * DEG, el_deg * DEG, site, columns)
    x, y = (n - o for n, o in zip(new.at(at), old.at(at), strict=True))
    observed = np.ones(len(az_deg), bool)
    if recordings is not None:
        observed = _near(az_deg * DEG, el_deg * DEG, recordings.at.az, recordings.at.el)
    shown = {
        name: f"{one[0]:.6g}" if one.dtype.kind == "f" else str(one[0])
        for name, one in given.items()
    }
    return Sky(az_deg, el_deg, x / ARCSEC, y / ARCSEC, observed, shown)


def _usual(recordings: Recordings, name: str) -> NDArray[Any] | None:
    """Return a column's median, of times the last, of labels the one of most rows."""
    if name not in recordings.at:
        return None
    values = recordings.at.column(name)
    if values.dtype.kind in "fiu":
        known = np.asarray(values, float)[np.isfinite(np.asarray(values, float))]
        if not len(known):
            return None
        return np.array([known.max() if name == "time" else np.median(known)])
    names, count = np.unique(values.astype(str), return_counts=True)
    return names[[int(np.argmax(count))]]


def _near(az: Array, el: Array, seen_az: Array, seen_el: Array) -> NDArray[np.bool_]:
    """Tell which directions have a recording within reach, shape (n,)."""
    from scipy.spatial import KDTree

    def vectors(a: Array, e: Array) -> Array:
        return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)

    chord = 2 * np.sin(REACH_DEG * DEG / 2)
    distance = KDTree(vectors(seen_az, seen_el)).query(vectors(az, el))[0]
    return np.asarray(distance <= chord)


def _rows(old: PointingModel, new: PointingModel, recordings: Recordings) -> Rows:
    measured = np.stack([recordings.x, recordings.y])
    met = [one.met(recordings.at, recordings.file) for one in (old, new)]
    left = [
        (measured - np.stack(one.at(there))) / ARCSEC
        for one, there in zip((old, new), met, strict=True)
    ]
    was, now = (np.sqrt(np.nansum(one**2, axis=0)) for one in left)
    before, after = (rms_of(one) for one in left)
    return Rows(recordings.line, was, now, before, after, spoken_axes(recordings.at.mount))


def spoken_axes(mount: Mount) -> dict[str, str]:
    """Return what `xel`, `el` and `sky` are called on a mount."""
    names = ("xel", "el") if mount is ALTAZ else mount.names
    return dict(zip(("xel", "el", "sky"), (*names, "sky"), strict=True))


def rms_of(left: Array) -> dict[str, float]:
    """Return the rms by axis, and over both by the recording [arcsec]."""
    found = {
        name: float(np.sqrt(np.nanmean(one**2)))
        for name, one in zip(("xel", "el"), left, strict=True)
        if np.isfinite(one).any()
    }
    there = np.isfinite(left).any(axis=0)
    return found | {"sky": float(np.sqrt(np.nansum(left**2) / max(int(there.sum()), 1)))}


def _unsound(new: PointingModel, scatter: float | None) -> tuple[Unsound, ...]:
    """Return the changes without significance that move horizon or zenith beyond the scatter."""
    if scatter is None:
        return ()
    rows = iter(new.values)
    found = []
    for term in new.model.terms:
        for _ in range(max(1, len(term.by))):
            for n, coefficient in enumerate(term.effect.coefficients):
                one = next(rows, None)
                if one is None or one.sigma is None or abs(one.change) >= SIGNIFICANT * one.sigma:
                    continue
                size = one.change * coefficient.scale / ARCSEC
                moved = [
                    _moves(new, term.effect, n, band) * abs(size)
                    for band in (HORIZON_DEG, ZENITH_DEG)
                ]
                if max(moved) > scatter:
                    found.append(Unsound(one, *moved))
    return tuple(found)


def _moves(new: PointingModel, effect: Any, n: int, band: tuple[float, float]) -> float:  # noqa: ANN401
    """Return how far one of a coefficient moves a band of elevations at most, 0 if unknown."""
    az, el = np.meshgrid(np.arange(0, 360, 10.0) * DEG, np.linspace(*band, 5) * DEG)
    at = Circumstances(az.ravel(), el.ravel(), new.model.site)
    try:
        x, y = effect.columns(at)
    except MissingColumn:
        return 0.0
    return float(np.hypot(x[:, n], y[:, n]).max())
