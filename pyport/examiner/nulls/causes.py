"""The hidden model of a drawn telescope, and the one cause that may act beside it.

Formulae: `terms`; Mangum & Wallace 2015 (r cot E); Greve et al. 1996 (eccentricity).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pyport.examiner import scores
from pyport.examiner.nulls.schedule import Array, Pointings

#: Coefficients of the hidden model are normal with this sigma. [arcsec]
TERM_ARCSEC = 60.0
#: A cause of which the model leaves less than this share visible is not drawn.
LEAST_SHARE = 0.1
#: The terms that take in a constant of an axis.
CONSTANTS = ("collimation", "elevation_zero")


def columns(at: Pointings) -> Array:
    """Return the hidden model's columns, shape (n, 2, 7)."""
    return scores.altaz(at.az, at.el)


def _both(at: Pointings, across: Array | float, along: Array | float) -> Array:
    return scores.both(across, along, len(at))


@dataclass(frozen=True)
class Cause:
    """One cause at its drawn size."""

    effect: str  #: the id that the program should call it by
    offset: Array  #: what it does [arcsec], shape (n, 2)
    #: Coefficient -> its value in the unit of the program's report. The coefficients of a change
    #: between nights are keyed by name alone: see `expected`.
    truth: dict[str, float]
    #: The first night of the changed state; None for a cause that is always there.
    begins: int | None = None

    def expected(self, name: str) -> float | None:
        """Return what a coefficient of the report should be, None for one it may not have.

        A change is given since a moment ("tilt_north[since ...]"), or for each session against
        the first one ("tilt_north[night 05]").
        """
        bare, _, label = name.partition("[")
        value = self.truth.get(bare)
        if value is None or self.begins is None or not label.startswith("night"):
            return value
        return value if int(label.strip("night ]")) >= self.begins else 0.0


#: The member of a family that is drawn, as the report spells it.
VARIANTS = {"azimuth_harmonics": "k = 2", "temperature": "the same everywhere"}

#: Draws the shape of a cause, shape (n, 2) in arcsec for unit coefficients, and those.
_Shape = Callable[[np.random.Generator, Pointings], tuple[Array, dict[str, float], int | None]]


def _refraction(
    _: np.random.Generator, at: Pointings
) -> tuple[Array, dict[str, float], int | None]:
    return _both(at, 0.0, 1 / np.tan(at.el)), {"refraction": 1.0}, None


def _azimuth_wave(
    rng: np.random.Generator, at: Pointings, name: str, k: int
) -> tuple[Array, dict[str, float], int | None]:
    phase = rng.uniform(0, 2 * np.pi)
    truth = {f"{name}_sine": float(np.cos(phase)), f"{name}_cosine": float(np.sin(phase))}
    return _both(at, np.cos(at.el) * np.sin(k * at.az + phase), 0.0), truth, None


def _tilt_change(
    rng: np.random.Generator, at: Pointings
) -> tuple[Array, dict[str, float], int | None]:
    begins = (at.sessions + 1) // 2
    toward = rng.uniform(0, 2 * np.pi)
    after = (at.night >= begins)[:, None] & (begins > 0)
    truth = {"tilt_north": float(np.cos(toward)), "tilt_east": float(np.sin(toward))}
    return after * _both(at, *scores.lean(at.az, at.el, toward)), truth, begins


def _temperature(
    _: np.random.Generator, at: Pointings
) -> tuple[Array, dict[str, float], int | None]:
    excess = at.weather["temperature_c"] - at.weather["temperature_c"].mean()
    return _both(at, 0.0, excess), {"temperature_xel": 0.0, "temperature_el": 1.0}, None


#: The program's id of a cause -> how it is drawn. A wrong clock is none of them: it is an azimuth
#: zero and a tilt toward east, to the last digit, and nothing of it is left to be seen.
CAUSES: dict[str, _Shape] = {
    "refraction": _refraction,
    "azimuth_eccentricity": lambda rng, at: _azimuth_wave(rng, at, "azimuth_eccentricity", 1),
    "azimuth_harmonics": lambda rng, at: _azimuth_wave(rng, at, "azimuth_harmonic", 2),
    "epoch_tilt": _tilt_change,
    "temperature": _temperature,
}


def draw(rng: np.random.Generator, at: Pointings, first: int, visible_arcsec: float) -> Cause:
    """Draw a cause that shows `visible_arcsec` rms once the model took its share.

    The rms is over the axes that it acts on. `first` says which cause is meant; where the model
    would take in nearly all of that one, or the nights are too few, the next one is drawn.
    """
    base = columns(at).reshape(-1, len(scores.ALTAZ))
    order = [*list(CAUSES.items())[first % len(CAUSES) :], *list(CAUSES.items())]
    for effect, shape in order:
        offset, truth, begins = shape(rng, at)
        if begins is not None and at.sessions < 2:
            continue
        flat = offset.ravel()
        left = flat - base @ np.linalg.lstsq(base, flat, rcond=None)[0]
        share = np.linalg.norm(left) / np.linalg.norm(flat)
        if share < LEAST_SHARE:
            continue
        acts = np.any(offset != 0, axis=0).sum()
        rms = np.linalg.norm(left) / np.sqrt(len(at) * acts)
        sign = rng.choice([-1.0, 1.0])
        size = sign * visible_arcsec / rms
        return Cause(effect, size * offset, {k: size * v for k, v in truth.items()}, begins)
    raise RuntimeError("no cause of the list can be seen in these pointings")
