"""The document's figures beside those of a fit, and what was put into a simulation beside both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.pointing import PARAMETERS, printed, printed_sigmas
from pyport.studies.rt32.fit import Rt32Fit
from pyport.studies.rt32.losses import LEVEL

#: How many altitude and azimuth offsets the document had, and how many were below `SMALL`.
ROWS = (2758, 2857)
SMALL_ROWS = (2376, 2611)
SMALL = 0.01 * DEG

#: How many the document fitted, and their rms [rad].
FITTED = 3684
RMS = 12.8 * ARCSEC

#: A fit, its honest sigmas, and what each offset was really off by, shape (m,) [rad].
Made = tuple[Rt32Fit, Array, Array]


def beside(fit: Rt32Fit) -> str:
    """Return the counts, the rms and the correlations that the document tells, and the fit's."""
    is_y, size = fit.stack.is_y, np.abs(fit.residual)
    correlation = np.abs(fit.correlation)

    def among(*pairs: tuple[int, int]) -> str:
        return ", ".join(f"{correlation[i - 1, k - 1]:.2f}" for i, k in pairs)

    share = fit.sigmas[: len(PARAMETERS)] / printed_sigmas()
    rows = [
        ("points fitted", _count(FITTED, sum(ROWS)), _count(int(fit.inside.sum()), len(is_y))),
        ("their rms", f'{RMS / ARCSEC:.1f}"', f'{fit.rms / ARCSEC:.1f}"'),
    ]
    for name, axis, small, every in (
        ("altitude", is_y, SMALL_ROWS[0], ROWS[0]),
        ("azimuth", ~is_y, SMALL_ROWS[1], ROWS[1]),
    ):
        if axis.any():
            ours = _count(int((size[axis] < SMALL).sum()), int(axis.sum()))
            rows.append((f"below {SMALL / DEG:g} deg, {name}", _count(small, every), ours))
    rows += [
        ("correlation of p1 with p3, p4", "about 0.95", among((1, 3), (1, 4))),
        ("correlation of p2, p7, p8", "still higher", among((2, 7), (2, 8), (7, 8))),
        ("formal sigmas over its own", "1", f"{np.nanmin(share):.1f} to {np.nanmax(share):.1f}"),
    ]
    lines = [f"{'':32s}{'document':22s}here"]
    lines += [f"{name:32s}{theirs:22s}{ours}" for name, theirs, ours in rows]
    inside, within = FITTED / sum(ROWS), sum(SMALL_ROWS) / sum(ROWS)
    least = least_rms(LEVEL, inside, SMALL, within)
    low, high = f"{LEVEL / DEG:g}", f"{SMALL / DEG:g} deg"
    lines += [
        "The document's counts and its rms are not of one kind of error: where errors get rarer",
        f"as they get larger, with {inside:.0%} below {low} and {within:.0%} below {high},",
        f'those below {low} have an rms of {least / ARCSEC:.1f}" or more.',
    ]
    if "simulated" in fit.recordings.meta:
        lines.append(
            "The simulated errors were chosen by the count of points fitted and their rms."
        )
    return "\n".join(lines).replace("nan", "  -")


def least_rms(level: float, inside: float, wider: float, within: float) -> float:
    """Return the least rms of the errors below a level, were larger errors always rarer.

    The density below the level is nowhere less than the mean one from there to
    `wider`; what is more than that lies at zero at best.

    `level`, `wider`: two sizes of error.
    `inside`, `within`: the shares of all errors below each.
    """
    density = (within - inside) / (wider - level)
    return float(np.sqrt(density * level**3 / 3 / inside))


def recovered(made: Sequence[Made]) -> str:
    """Return how campaigns of known errors came back: points, rms, parameters."""
    lines = []
    for k, (fit, honest, error) in enumerate(made):
        small = np.abs(error) <= fit.level
        miss = np.abs(fit.values[: len(PARAMETERS)] - printed()) / honest[: len(PARAMETERS)]
        lines.append(
            f"{k:3d}  {small.sum():5d} {fit.inside.sum():5d}   "
            f"{np.sqrt(np.mean(error[small] ** 2)) / ARCSEC:5.2f} {fit.rms / ARCSEC:5.2f}   "
            f"{_rms(miss):5.2f} {miss.max():5.2f} (p{miss.argmax() + 1})"
        )
    head = [
        f"     below {made[0][0].level / DEG:g} deg   rms [arcsec]   Model3 missed [honest sigmas]",
        "     put in found   put in found   rms  largest",
    ]
    return "\n".join([*head, *lines, *_over_all(made)])


def _over_all(made: Sequence[Made]) -> list[str]:
    """Return how far parameters are off over all campaigns, in honest and in formal sigmas."""
    size = len(PARAMETERS)
    off = np.array([fit.values[:size] - printed() for fit, _, _ in made])
    honest = np.array([sigma[:size] for _, sigma, _ in made])
    formal = np.array([fit.sigmas[:size] for fit, _, _ in made])
    honestly, formally = _rms(off / honest), _rms(off / formal)
    worst, ratio = np.abs(off / honest).max(), np.median(honest / formal)
    return [
        f"Model3 was missed by {honestly:.2f} honest sigmas (rms; at most {worst:.1f}), by",
        f"{formally:.1f} formal ones. Honest sigmas are {ratio:.1f} times the formal (median).",
    ]


def _count(part: int, whole: int) -> str:
    return f"{part} of {whole} ({part / whole:.0%})"


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
