"""A model made ready to be asked often: one direction in microseconds, a million in a second.

What depends on directions alone is a sum of waves exp(i (m A + n E)) for nearly every term of
a pointing model. Their coefficients come out of a Fourier transform of the terms themselves,
and are held against them; what is no such sum (refraction, an edge, a temperature) is computed
as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects import Circumstances, Effect, MissingColumn, Site
from pyport.effects.empirical.fields import UNKNOWN, field
from pyport.effects.telescope.structure import jump_at
from pyport.models.labels import refuse_unknown, split_of
from pyport.models.members import apart
from pyport.models.model import Model, rt32_values
from pyport.pointing.approximate import RT32_JUMP, effect_of
from pyport.pointing.jump import has_jumped_one
from pyport.pointing.one import exact_one
from pyport.pointing.parameters import PARAMETERS

#: Waves up to this many turns in azimuth and in elevation: the highest harmonic of any term is 9.
HIGHEST = 11
#: A sum of waves may differ from its term by this share of the term.
TOLERANCE = 1e-12
#: Waves below this share of the strongest are rounding.
NEGLIGIBLE = 1e-15
#: Directions that are computed at a time: their waves fit a processor's cache.
BLOCK = 8192

Numbers = NDArray[Any]
_Jump = Callable[[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Kernel:
    """A model with one set of coefficients."""

    #: (m, n, x, y): how often around and up, and the complex amplitudes on both axes [rad].
    waves: tuple[tuple[int, int, complex, complex], ...]
    #: Effects that are no sum of waves, each with its values.
    rest: tuple[tuple[Effect, Array], ...]
    model: Model  #: the model itself, for directions in plunge or below the horizon where `folded`
    folded: bool  #: whether the waves hold between the horizon and the zenith only: the RT32's do

    def one(
        self, az: float, el: float, columns: dict[str, Any], site: Site | None
    ) -> tuple[float, float]:
        """Return the offsets across and along elevation of one direction [rad]."""
        if self.folded and not 0 <= el <= math.pi / 2:
            both = self.many(np.array([az]), np.array([el]), _arrays(columns), site)
            return float(both[0][0]), float(both[1][0])
        around, up = complex(math.cos(az), math.sin(az)), complex(math.cos(el), math.sin(el))
        x = y = 0.0
        circles, arcs = {0: 1 + 0j, 1: around}, {0: 1 + 0j, 1: up, -1: up.conjugate()}
        for m, n, in_x, in_y in self.waves:
            circle = circles.get(m)
            if circle is None:
                circle = circles[m] = around**m
            arc = arcs.get(n)
            if arc is None:
                arc = arcs[n] = up**n
            wave = circle * arc
            x += wave.real * in_x.real - wave.imag * in_x.imag
            y += wave.real * in_y.real - wave.imag * in_y.imag
        if self._base is not None:
            d_az, d_alt = self._base(az - math.pi, el)
            x, y = x + d_az * up.real, y + d_alt
        for jump, size in self._jumps:
            across, along = jump(az, el)
            x, y = x + size * across, y + size * along
        if self._slow:
            at = Circumstances(np.array([az]), np.array([el]), site, _arrays(columns))
            for effect, values in self._slow:
                more_x, more_y = effect.columns(at)
                refuse_unknown(effect, columns)
                x += float(more_x[0] @ values)
                y += float(more_y[0] @ values)
        return x, y

    def many(
        self, az: Array, el: Array, columns: dict[str, Numbers], site: Site | None
    ) -> tuple[Array, Array]:
        """Return the offsets of n directions [rad], shape (n,) each."""
        if self.folded and not (np.all(el >= 0) and np.all(el <= math.pi / 2)):
            return self.model.offsets(Circumstances(az, el, site, columns))
        x, y = self._summed(az, el)
        if self.model.given is not None:
            more_x, more_y = self.model.given(Circumstances(az, el, site, columns))
            x, y = x + more_x, y + more_y
        back = any(effect.looks_back for effect, _ in self.rest)
        size = max(len(az), 1) if back else BLOCK
        for start in range(0, len(az), size) if self.rest else ():
            rows = slice(start, start + size)
            these = {name: values[rows] for name, values in columns.items()}
            at = Circumstances(az[rows], el[rows], site, these)
            for effect, values in self.rest:
                across, along = effect.columns(at)
                refuse_unknown(effect, these)
                x[rows] += across @ values
                y[rows] += along @ values
        return x, y

    def _summed(self, az: Array, el: Array) -> tuple[Array, Array]:
        """Return the sums of the waves, block by block."""
        x, y = np.zeros(len(az)), np.zeros(len(az))
        if not self.waves:
            return x, y
        amplitudes = np.array([[one[2], one[3]] for one in self.waves])
        parts = np.concatenate([amplitudes.real, -amplitudes.imag])
        for start in range(0, len(az), BLOCK):
            rows = slice(start, start + BLOCK)
            around, up = np.exp(1j * az[rows]), np.exp(1j * el[rows])
            circles = {m: around**m for m in {one[0] for one in self.waves}}
            arcs = {n: up**n for n in {one[1] for one in self.waves}}
            wave = np.stack([circles[m] * arcs[n] for m, n, _, _ in self.waves])
            both = np.concatenate([wave.real, wave.imag]).T @ parts
            x[rows], y[rows] = both[:, 0], both[:, 1]
        return x, y

    @cached_property
    def _jumps(self) -> tuple[tuple[_Jump, float], ...]:
        """Return the steps at edges, each for one direction at a time, and their sizes."""
        return tuple(
            (_rt32_jump if effect is RT32_JUMP else jump_at(effect.member), float(values[0]))
            for effect, values in self.rest
            if effect.id == RT32_JUMP.id
        )

    @cached_property
    def _slow(self) -> tuple[tuple[Effect, Array], ...]:
        return tuple(one for one in self.rest if one[0].id != RT32_JUMP.id)

    @cached_property
    def _base(self) -> Callable[[float, float], tuple[float, float]] | None:
        """Return what the model adds before its terms, for one direction."""
        if self.model.given is None:
            return None
        p = rt32_values(self.model.base)
        if p and self.model.base != "rt32-approximate":
            return exact_one(np.array(list(p.values())))
        given = self.model.given

        def one(az_south: float, el: float) -> tuple[float, float]:
            x, y = given(Circumstances(np.array([az_south + math.pi]), np.array([el])))
            return float(x[0]) / math.cos(el), float(y[0])

        return one


def _rt32_jump(az: float, el: float) -> tuple[float, float]:
    return 0.0, float(has_jumped_one(az - math.pi, el))


def _arrays(columns: dict[str, Any]) -> dict[str, Numbers]:
    return {name: np.asarray(value).reshape(1) for name, value in columns.items()}


def kernel(model: Model, labels: dict[str, str], site: Site | None) -> Kernel:
    """Return a model made ready, for one value of each label.

    Raises `BadInput`: a term has no coefficients for these labels.
    """
    nobody = {name: np.array([labels.get(name, "")]) for term in model.terms for name in term.per}
    total = np.zeros((2 * HIGHEST + 2, 2 * HIGHEST + 2, 2), complex)
    rest: list[tuple[Effect, Array]] = []
    folded = False
    for term in model.terms:
        if not term.has_values:
            continue
        values = term.values_of(nobody)
        for effect, own, mirrored in _plain(term.effect, values):
            folded |= mirrored
            # labels are refused of a term of zeros too
            if not own.any() and not split_of(effect)[0]:
                continue
            waves = _waves(effect, own, site)
            if waves is None:
                rest.append(_single(effect, own))
            else:
                total += waves
    return Kernel(_strongest(total), _joined(rest), model, folded)


def _plain(effect: Effect, values: Array) -> list[tuple[Effect, Array, bool]]:
    """Return effects of the catalogue for a term, each with values and whether it is the RT32's.

    Between horizon and zenith p1..p12 are effects of the catalogue, with a sign.
    """
    number = effect.member.get("rt32")
    if number is None:
        return [(effect, values, False)]
    parameter = PARAMETERS[number - 1]
    effect = effect_of(number)
    # one object for the jump, so that several terms of it are known to be one
    own = effect if effect is RT32_JUMP else apart(effect)[parameter.column]
    return [(own, values * parameter.sign, True)]


def _waves(effect: Effect, values: Array, site: Site | None) -> NDArray[np.complex128] | None:
    """Return the amplitudes (m, n, axis) of an effect, None where it is no sum of waves."""
    size = 2 * HIGHEST + 2
    circle = np.arange(size) * 2 * np.pi / size
    az, el = (one.ravel() for one in np.meshgrid(circle, circle, indexing="ij"))
    rng = np.random.default_rng(0)
    check = rng.uniform(-math.pi, math.pi, 64), rng.uniform(0.0, math.pi / 2, 64)
    try:
        everywhere = _of(effect, values, az, el, site)
        there = _of(effect, values, *check, site)
    except MissingColumn:
        return None
    amplitudes = np.fft.fft2(everywhere.reshape(size, size, 2), axes=(0, 1)) / size**2
    m = np.fft.fftfreq(size, 1 / size)
    phase_az, phase_el = (np.exp(1j * np.outer(one, m)) for one in check)
    back = np.einsum("pm,mna,pn->pa", phase_az, amplitudes, phase_el).real
    if np.abs(back - there).max() > TOLERANCE * max(np.abs(there).max(), 1e-300):
        return None
    return np.asarray(amplitudes)


def _of(effect: Effect, values: Array, az: Array, el: Array, site: Site | None) -> Array:
    x, y = effect.columns(Circumstances(az, el, site))
    return np.stack([x @ values, y @ values], axis=-1)


def _strongest(total: NDArray[np.complex128]) -> tuple[tuple[int, int, complex, complex], ...]:
    """Return the waves that count, those of negative m folded onto the others."""
    size = len(total)
    turns = np.fft.fftfreq(size, 1 / size).round().astype(int)
    least = NEGLIGIBLE * max(float(np.abs(total).max()), 1e-300)
    found = []
    for i, m in enumerate(turns.tolist()):
        for j, n in enumerate(turns.tolist()):
            twice = 1 if m == n == 0 else 2
            if m < 0 or (m == 0 and n < 0) or np.abs(total[i, j]).max() <= least:
                continue
            found.append((m, n, complex(twice * total[i, j, 0]), complex(twice * total[i, j, 1])))
    return tuple(found)


def _single(effect: Effect, values: Array) -> tuple[Effect, Array]:
    """Return a field with its values as one of a single coefficient, anything else as it is."""
    if effect.id != UNKNOWN:
        return effect, values
    changed = dict(effect.member)
    changed.pop("spread", None)  # of the directions
    changed["directions"] = (np.array(changed["directions"]) @ values)[:, None].tolist()
    return field(**changed), np.ones(1)


def _joined(rest: Sequence[tuple[Effect, Array]]) -> tuple[tuple[Effect, Array], ...]:
    """Return effects of which the same stand once, their values added up."""
    found: list[tuple[Effect, Array]] = []
    for effect, values in rest:
        same = [n for n, (one, _) in enumerate(found) if one is effect]
        if same:
            found[same[0]] = effect, found[same[0]][1] + values
        else:
            found.append((effect, values))
    return tuple(found)
