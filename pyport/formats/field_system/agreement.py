"""How well pyport agrees with what the Field System itself computed, in figures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.formats.field_system import ctl, err
from pyport.models.terms import field_system
from pyport.recordings.formats import csv
from pyport.recordings.formats.text import Line
from pyport.recordings.formats.xtr import read_xtr, section, sections

GRID, MODEL = "fs_fln_flt_grid.csv", "mdlpo.ctl"
_GRID_COLUMNS = ("az_deg", "el_deg", "dx_per_unit", "dy_per_unit")


@dataclass(frozen=True)
class Response:
    """The largest difference of a parameter's unit response, over directions."""

    phi_deg: float
    name: str
    directions: int
    worst: float


@dataclass(frozen=True)
class Compared:
    """A fit of the Field System's beside pyport's: degrees, (p,), correlations (p, p)."""

    name: str
    names: tuple[str, ...]
    value: tuple[Array, Array]
    sigma: tuple[Array, Array]
    correlation: tuple[Array, Array]


def responses(path: Path) -> list[Response]:
    """Compare unit responses with those that the Field System's functions returned.

    Raises `BadInput`: the file has not the columns phi_deg, param, az_deg, el_deg, dx_per_unit,
      dy_per_unit.
    """
    raw = csv.read(path)
    wanted = {"phi_deg", "param", *_GRID_COLUMNS}
    if not wanted <= set(raw.columns):
        raise BadInput(f"the columns are not {', '.join(sorted(wanted))}", path)
    numbers = np.stack([raw.numbers(name) for name in ("phi_deg", *_GRID_COLUMNS)], axis=1)
    blank = np.asarray(np.isnan(numbers).any(axis=1))
    raw.refuse(blank, "a cell is blank, expected a number in each")
    groups: dict[tuple[float, str], list[Array]] = {}
    for row, name in zip(numbers, raw.words("param").tolist(), strict=True):
        groups.setdefault((float(row[0]), name), []).append(row[1:])
    found = []
    for (phi, name), rows in groups.items():
        az, el, d_az, d_el = np.array(rows).T
        at = Circumstances(np.radians(az), np.radians(el))
        word = field_system.word(name, phi)
        if word is None:
            raise BadInput(f"{name!r} is none of P1..P30", path)
        x, y = word.columns(at)
        off = max(np.abs(x / np.cos(at.el) - d_az).max(), np.abs(y - d_el).max())
        found.append(Response(phi, name, len(rows), float(off)))
    return found


def compared(folder: Path, name: str) -> Compared:
    """Fit NAME.xtr by the folder's mdlpo.ctl and lay the fit beside NAME.err."""
    path = folder / f"{name}.err"
    theirs = sections(path)
    value, sigma = _values_and_sigmas(section(theirs, "fit_data", path))
    correlation = section(theirs, "correlation", path)
    triangle = _triangle(correlation)
    ours = err.fitted(read_xtr(folder / f"{name}.xtr"), ctl.read(folder / MODEL)).fit
    chosen = np.array(ours.numbers) - 1
    if min(len(value), len(sigma), len(triangle)) <= chosen.max():
        wanted = f"expected one of each up to P{chosen.max() + 1}"
        sizes = f"{len(value)} values, {len(sigma)} sigmas, {len(triangle)} rows of correlations"
        raise correlation[0].error(f"{sizes}, {wanted}")
    return Compared(
        name,
        tuple(f"P{n}" for n in ours.numbers),
        (value[chosen], np.degrees(ours.value)),
        (sigma[chosen], np.degrees(ours.sigma)),
        (triangle[np.ix_(chosen, chosen)], ours.correlation),
    )


def _values_and_sigmas(lines: list[Line]) -> tuple[Array, Array]:
    """Return what stands in lines of values and lines of sigmas by turns, below two others."""
    values, sigmas = (
        np.array([_number(line, word) for line in lines[first::2] for word in line.words])
        for first in (2, 3)
    )
    return values, sigmas


def _triangle(lines: list[Line]) -> Array:
    """Return a symmetric matrix from the rows of its lower triangle, wherever they are broken."""
    numbers = [_number(line, word) for line in lines for word in line.words]
    size = int(np.sqrt(2 * len(numbers)))
    if size * (size + 1) // 2 != len(numbers):
        raise lines[-1].error(f"{len(numbers)} correlations, expected those of a triangle")
    matrix = np.zeros((size, size))
    matrix[np.tril_indices(size)] = numbers
    return matrix + np.tril(matrix, -1).T


def _number(line: Line, word: str) -> float:
    return float(line.decimal(word, "a number of the fit"))


def _found(folder: Path) -> tuple[Path, list[str]]:
    """Return where the grid would be and the names of the fits, or refuse an empty folder."""
    grid = folder / GRID
    names = sorted(one.stem for one in folder.glob("*.xtr") if one.with_suffix(".err").is_file())
    if not grid.is_file() and not names:
        raise BadInput(f"neither {GRID} nor a pair NAME.xtr and NAME.err", folder)
    return grid, names


def as_json(folder: Path) -> dict[str, object]:
    """Return the comparison for other programs; errors as of `text`."""
    grid, names = _found(folder)
    fits = [compared(folder, name) for name in names]
    return {
        "responses": [vars(one) for one in responses(grid)] if grid.is_file() else [],
        "fits": [
            {
                "name": one.name,
                "parameters": list(one.names),
                "theirs_deg": one.value[0].tolist(),
                "ours_deg": one.value[1].tolist(),
                "their_sigma_deg": one.sigma[0].tolist(),
                "our_sigma_deg": one.sigma[1].tolist(),
                "worst_correlation": float(np.abs(one.correlation[1] - one.correlation[0]).max()),
            }
            for one in fits
        ],
    }


def text(folder: Path) -> Iterator[str]:
    """Yield the lines of the comparison: unit responses, then every fit in the folder.

    Raises `BadInput`: there is neither a grid of unit responses nor a pair of xtr and err.
    """
    grid, names = _found(folder)
    if grid.is_file():
        yield from _responses_text(responses(grid))
    for name in names:
        yield from _compared_text(compared(folder, name))


def _responses_text(found: list[Response]) -> Iterator[str]:
    yield "largest difference of unit responses from the Field System's own functions"
    for phi in sorted({one.phi_deg for one in found}, reverse=True):
        of_phi = [one for one in found if one.phi_deg == phi]
        yield f"phi = {phi:g} deg, {of_phi[0].directions} directions each:"
        for n in range(0, len(of_phi), 5):
            yield "  " + "  ".join(f"{one.name:>3s} {one.worst:7.1e}" for one in of_phi[n : n + 5])
    yield f"worst of all: {max(one.worst for one in found):.1e}"


def _compared_text(one: Compared) -> Iterator[str]:
    yield ""
    yield f"{one.name}: the Field System's fit, and pyport's less it [deg]"
    columns = (*one.value, *one.sigma)
    for name, theirs, ours, sigma, own in zip(one.names, *columns, strict=True):
        yield (
            f"  {name:4s} {theirs:14.10f} {ours - theirs:+.1e}"
            f"   sigma {sigma:12.10f} {own - sigma:+.1e}"
        )
    theirs, ours = one.correlation
    yield f"  correlations: largest difference {np.abs(ours - theirs).max():.1e}"
