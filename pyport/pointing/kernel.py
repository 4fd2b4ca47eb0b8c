"""The compiled kernel where it is installed: the same formulae in one loop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.least_squares import robust
from pyport.pointing import compiled
from pyport.pointing.leaning import Leaning

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: The kernel in use, None where numpy does the work.
KERNEL = compiled.KERNEL


def path() -> str:
    """Return what computes: `numpy`, or the kernel and its instruction set."""
    return "numpy" if KERNEL is None else f"kernel, {KERNEL.level()}"


def offsets(az: Array, alt: Array, p: Leaning, *, exact: bool) -> tuple[Array, Array] | None:
    """Return both offsets [rad] in the angles' broadcast shape.

    None where numpy has to: no kernel, or angles of more than a million radians.
    """
    if KERNEL is None:
        return None
    shape = np.broadcast_shapes(az.shape, alt.shape)
    given = _given(p)
    if len(shape) == 2 and az.shape == (shape[0], 1) and alt.shape[-1] == alt.size:
        d_az, d_alt = np.empty((2, shape[1], shape[0]))
        large = KERNEL.grid(exact, given, _flat(az), _flat(alt), d_az, d_alt)
        return None if large else (d_az.T, d_alt.T)
    d_az, d_alt = np.empty(shape), np.empty(shape)
    az, alt = (np.broadcast_to(one, shape) for one in (az, alt))
    large = KERNEL.scattered(exact, given, _flat(az), _flat(alt), d_az, d_alt)
    return None if large else (d_az[()], d_alt[()])


def look_up(
    nodes: tuple[Array, Array], of: Array, at: Sequence[Array], out: Sequence[Array]
) -> bool:
    """Write what a table's offsets are between its nodes; tell whether that could be done.

    `nodes`: the table's two axes, of equal steps, shapes (n,) and (m,).
    `of`: both offsets at the nodes, side by side, shape (n, m, 2).
    `at`, `out`: two places and the room for two offsets, shape (k,) each.

    Notes
    -----
    It cannot be done without the kernel, nor where a place lies beyond the table.
    """
    if KERNEL is None or min(map(len, nodes)) < 2:
        return False
    nodes_and_all = (*nodes, of.reshape(-1), *at)
    return not KERNEL.look_up(*map(np.ascontiguousarray, nodes_and_all), *out)


def table_offsets(
    p_deg: Array, az_deg: Array, zd_deg: Array, lift_deg: Array
) -> tuple[Array, Array] | None:
    """Return both offsets of :mod:`pyport.steering.as_written` [deg], None without the kernel.

    `p_deg`: p1..p12 [deg].
    `az_deg`, `zd_deg`: the axes of a grid, (n, 1) and (1, m), or points, of shapes that broadcast
      [deg].
    `lift_deg`: the refraction at each zenith distance [deg], of its shape.
    """
    if KERNEL is None:
        return None
    shape = np.broadcast_shapes(az_deg.shape, zd_deg.shape)
    if not (len(shape) == 2 and az_deg.shape == (shape[0], 1) and zd_deg.shape == (1, shape[1])):
        az_deg, zd_deg, lift_deg = (
            np.broadcast_to(one, shape) for one in (az_deg, zd_deg, lift_deg)
        )
    d_az_deg, d_zd_deg = np.empty(shape), np.empty(shape)
    given = p_deg, *map(_flat, (az_deg, zd_deg, lift_deg))
    KERNEL.table_offsets(*given, d_az_deg, d_zd_deg)
    return d_az_deg, d_zd_deg


def gram(columns: Array, weight: Array, target: Array) -> tuple[Array, Array]:
    """Return the products of weighted columns with each other, and of columns with a target.

    `columns`, `weight`, `target`: shapes (k, n), contiguous, (n,) and (n,).
    Returns `normal`, `right`: shapes (k, k) and (k,).
    """
    if KERNEL is None:
        return columns * weight @ columns.T, columns @ target
    normal, right = np.empty((len(columns),) * 2), np.empty(len(columns))
    KERNEL.gram(columns, weight, target, normal, right)
    return normal, right


def median(values: Array) -> float:
    """Return the median of finite numbers, shape (n,), one at least."""
    if KERNEL is None:
        return robust.median(values)
    return float(KERNEL.median(np.ascontiguousarray(values)))


def whiten(
    columns: Array,
    variance: Array,
    time: Array | None,
    drifts: Sequence[tuple[float, float]],
    among: tuple[Codes, Array] | None = None,
) -> tuple[Array, Array] | None:
    """Return what :func:`pyport.noise.whitening.factor` does; None where numpy has to.

    `among` says which rows of the columns are meant, shape (n,), and where the result goes, an
    array of the columns' shape, whose other rows stay as they are.
    """
    if KERNEL is None:
        return None
    amplitude, memory = np.array(drifts, float).reshape(-1, 2).T
    time = np.zeros(len(variance)) if time is None else time
    rows, white = among or (np.arange(len(variance)), np.empty(columns.shape))
    d = np.empty(len(variance))
    given = time, 1 / memory, amplitude**2, variance, columns
    done = KERNEL.whiten(columns.shape[1], rows, *map(np.ascontiguousarray, given), d, white)
    return (d, white) if done else None


@dataclass(frozen=True)
class Columns:
    """Columns (n, q + p): of the first q the numbers that are not zero, of the others all.

    `starts`, `places`, `numbers`: where each row starts among the numbers, and the end, (n + 1,);
      the column of each number, and the number, (N,).
    `full`: the other columns, shape (n, p).
    `q`: how many columns there are of the first kind.
    """

    starts: Codes
    places: Codes
    numbers: Array
    full: Array
    q: int

    @classmethod
    def of(cls, columns: Array, q: int) -> Columns:
        """Return columns (n, q + p) of which the first q are mostly zero."""
        rows, places = np.nonzero(columns[:, :q])
        starts = np.searchsorted(rows, np.arange(len(columns) + 1))
        numbers = columns[rows, places]
        full = np.ascontiguousarray(columns[:, q:])
        return cls(starts, np.ascontiguousarray(places), numbers, full, q)

    @cached_property
    def there(self) -> NDArray[np.bool_]:
        """Tell which of the first q columns are not zero, shape (q,)."""
        return np.bincount(self.places, minlength=self.q) > 0

    def scaled(self, by: Array) -> Columns:
        """Return the first q columns times numbers (q,), without those that are zero then."""
        there = (by != 0) & self.there
        held = there[self.places]
        starts = np.concatenate([[0], np.cumsum(held)])[self.starts]
        places, numbers = self.places[held], self.numbers[held] * by[self.places[held]]
        new = np.cumsum(there) - 1
        return Columns(starts, new[places], numbers, self.full[:, :0], int(there.sum()))

    def beside(self, full: Array) -> Columns:
        """Return the first q columns and others, (n, p)."""
        return replace(self, full=np.ascontiguousarray(full))

    @cached_property
    def few(self) -> csr_array:
        """Return the first q columns, (n, q)."""
        from scipy.sparse import csr_array

        return csr_array((self.numbers, self.places, self.starts), (len(self.full), self.q))

    def _with(self, few: csr_array, full: Array) -> Columns:
        """Return other rows of as many columns."""
        places = few.indptr.astype(np.intp), few.indices.astype(np.intp)
        return Columns(*places, few.data, np.ascontiguousarray(full), self.q)

    def of_rows(self, rows: NDArray[np.bool_]) -> Columns:
        """Return some of the rows."""
        return self._with(self.few[rows], self.full[rows])

    def summed(self, sums: csr_array, by: Array) -> Columns:
        """Return sums (s, q + p) of the rows times numbers (n,)."""
        numbers = self.numbers * np.repeat(by, np.diff(self.starts))
        few = sums @ replace(self, numbers=numbers).few
        return self._with(few.sorted_indices(), sums @ (by[:, None] * self.full))

    def beside_means(self, means: Columns, rows: Codes, whose: Codes, by: Array) -> Columns:
        """Return some rows (r,) less those means that are theirs (r,), times numbers (r,)."""
        few = (self.few[rows] - means.few[whose]).sorted_indices()
        few.data *= np.repeat(by, np.diff(few.indptr))
        return self._with(few, by[:, None] * (self.full[rows] - means.full[whose]))

    def products(self) -> Array:
        """Return the products of all columns, (q + p, q + p)."""
        found = products(self, np.ones(len(self.full)), None, ())
        return self.dense().T @ self.dense() if found is None else found[1]

    def dense(self) -> Array:
        """Return all columns, shape (n, q + p)."""
        out = np.zeros((len(self.full), self.q))
        out[np.repeat(np.arange(len(out)), np.diff(self.starts)), self.places] = self.numbers
        return np.concatenate([out, self.full], axis=1)


def products(
    columns: Columns, variance: Array, time: Array | None, drifts: Sequence[tuple[float, float]]
) -> tuple[Array, Array] | None:
    """Return the variance of each row given those before it, (n,), and products of columns.

    They are whitened under scatter and drifts, as by :func:`pyport.noise.whitening.factor`,
    and (q + p, q + p) products. None without the kernel.
    """
    if KERNEL is None:
        return None
    amplitude, memory = np.array(drifts, float).reshape(-1, 2).T
    time = np.zeros(len(variance)) if time is None else time
    size = columns.q + columns.full.shape[1]
    d, normal = np.empty(len(variance)), np.empty((size, size))
    given = map(np.ascontiguousarray, (time, 1 / memory, amplitude**2, variance))
    found = columns.starts, columns.places, *given, columns.numbers, columns.full
    done = KERNEL.products(columns.q, *found, d, normal)
    return (d, normal) if done else None


def _flat(angles: Array) -> Array:
    return np.ascontiguousarray(angles.reshape(-1))


def _given(p: Leaning) -> Array:
    """Return the parameters in the order of the kernel's `loops.h`."""
    cos_s, tan_s = math.cos(p.sigma), math.tan(p.sigma)
    sin_b, cos_b = math.sin(p.beta), math.cos(p.beta)
    return np.array([
        p.toward, p.lean, p.lean**2, 1 / (1 + p.upright), p.upright, p.south,
        2 * p.in_az[0], 2 * p.in_az[1], p.az0 + p.south + p.in_az[1],
        2 * p.in_alt[0], 2 * p.in_alt[1], p.alt0 + p.in_alt[1],
        p.sag, p.sag_sine, p.jump,
        p.sigma, p.beta, tan_s, sin_b / cos_s,
        sin_b * cos_s * tan_s, 1 / (cos_s * cos_b), 1 / cos_b,
    ])  # fmt: skip
