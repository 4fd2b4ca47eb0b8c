"""The document's figures beside those of a fit, and what was put into a simulation beside both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis.joint import rms
from pyport.pointing import PARAMETERS, printed, printed_sigmas
from pyport.recordings.schema import as_input, counted
from pyport.report import typed
from pyport.studies.rt32.fit import Rt32Fit
from pyport.studies.rt32.losses import LEVEL, cut_factor

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
            f"{rms(miss):5.2f} {miss.max():5.2f} (p{miss.argmax() + 1})"
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
    honestly, formally = rms((off / honest).ravel()), rms((off / formal).ravel())
    worst, ratio = np.abs(off / honest).max(), np.median(honest / formal)
    return [
        f"Model3 was missed by {honestly:.2f} honest sigmas (rms; at most {worst:.1f}), by",
        f"{formally:.1f} formal ones. Honest sigmas are {ratio:.1f} times the formal (median).",
    ]


def _count(part: int, whole: int) -> str:
    return f"{part} of {whole} ({part / whole:.0%})"


#: What the table says that each parameter multiplies.
_DERIVATIVES = (
    "(1)", "(1)", "(tg Alt)", "(1/cos Alt)", "Az,Alt", "Az,Alt",
    "(cos Alt)", "(sin Alt)", "(sin 2Az)", "(cos 2Az)", "(sin 2Az)", "(1)",
)  # fmt: skip


def text(fit: Rt32Fit, honest: Array) -> str:
    """Return the document's table, and beside it what sessions drawn anew say.

    `fit`: a fit by any method.
    `honest`: standard errors by bootstrap [rad], shape (P,); NaN where there are none.
    """
    lines = [*_head(fit), ""]
    beside = "     by sessions   ratio" if np.isfinite(honest).any() else ""
    lines.append(f" p Parameter       (deriv.)                   Value{'':35s}{beside}".rstrip())
    for k, value in enumerate(fit.values):
        line = f"{k + 1:2d} {_name(k)} {_value(value, fit.sigmas[k])}"
        if np.isfinite(value) and np.isfinite(honest[k]):
            line += f'  +/-{honest[k] / ARCSEC:6.1f}"  {honest[k] / fit.sigmas[k]:6.2f}'
        lines.append(line)
    lines += ["", f"condition number {fit.condition:.1f}"]
    if fit.method == "document":
        factor = cut_factor(fit.residual, fit.level)
        by = f"by {factor:.2f}" if np.isfinite(factor) else "by any factor"
        lines.append(
            f"formal sigmas are too small {by} through the cut alone: "
            "the fit decides itself which points vote"
        )
    lines += [f"warning: {sentence}" for sentence in fit.doubts]
    return "\n".join(lines)


def _head(fit: Rt32Fit) -> list[str]:
    """Return what was fitted, how, and how well."""
    simulated = fit.recordings.meta.get("simulated")
    form = "exact" if fit.exact else "approximate"
    lines = [f"RT32 parameters (without refraction): {form} form, method {fit.method}"]
    lines.insert(0, counted(as_input(fit.recordings)))
    if simulated:
        lines.insert(0, f"SIMULATED: {simulated}")
    is_y, inside = fit.stack.is_y, fit.inside.sum()
    voted = "fitted" if fit.method == "document" else f"within {fit.level / DEG:.4f} deg"
    rms = f'RMS of {fit.rms / ARCSEC:.1f}" = {fit.rms / DEG:.6f} deg' if inside else "no RMS"
    lines += [
        f"{len(is_y)} offsets ({is_y.sum()} of altitude, {(~is_y).sum()} of azimuth) were analysed",
        f"and {inside} points {voted} with {rms}",
        f"({fit.tuned.text}; {fit.rounds} rounds)",
    ]
    if fit.step:
        done = "fitted" if np.isnan(fit.step) else f"{fit.step / DEG:.4f} deg, subtracted"
        lines.append(f"step of the box offset between the campaigns: {done}")
    return lines


def _name(k: int) -> str:
    if k >= len(PARAMETERS):
        return f"{'Box step':15s} {'(1/cos Alt)':11s}"
    return f"{PARAMETERS[k].name.partition(' (')[0]:15s} {_DERIVATIVES[k]:11s}"


def _value(value: float, sigma: float) -> str:
    if not np.isfinite(value):
        return "not determined by these recordings"
    return (
        f'{value / ARCSEC:8.1f}+/-{sigma / ARCSEC:5.1f}" ='
        f" {value / DEG:10.6f}+/-{sigma / DEG:.6f} deg"
    )


def correlations(fit: Rt32Fit) -> str:
    """Return the correlation matrix, a row and a column for each parameter."""
    size = len(fit.values)
    lines = ["     " + "".join(f"{f'p{k + 1}':>6s}" for k in range(size))]
    for k, row in enumerate(fit.correlation):
        cells = [f"{one:6.2f}".replace("nan", "  -") for one in row[: k + 1]]
        lines.append(f"{f'p{k + 1}':>4s} " + "".join(cells))
    return "\n".join(lines)


def compared(fits: Sequence[Rt32Fit], honest: Sequence[Array]) -> str:
    """Return the methods side by side: values and honest sigmas [arcsec]."""
    lines = [f"{'':20s} {'published':>10s}" + "".join(f"{fit.method:>17s}" for fit in fits)]
    published = printed()
    for k in range(len(PARAMETERS)):
        line = f"{PARAMETERS[k].name:20s} {published[k] / ARCSEC:10.1f}"
        for fit, sigma in zip(fits, honest, strict=True):
            line += f"{fit.values[k] / ARCSEC:9.1f} +-{sigma[k] / ARCSEC:5.1f}".replace(
                "nan", "  -"
            )
        lines.append(line)
    rows = {
        "formal/honest": [_middle(f.sigmas / s) for f, s in zip(fits, honest, strict=True)],
        "within level": [f.inside.sum() for f in fits],
        "rms of them": [f.rms / ARCSEC for f in fits],
    }
    for name, values in rows.items():
        shown = (f"{v:17d}" if isinstance(v, np.integer) else f"{v:17.2f}" for v in values)
        lines.append(f"{name:20s} {'':10s}" + "".join(shown).replace("nan", "  -"))
    return "\n".join(lines)


def _middle(ratios: Array) -> float:
    """Return the median of what is known, NaN where nothing is."""
    known = ratios[np.isfinite(ratios)]
    return float(np.median(known)) if len(known) else float("nan")


def as_json(fit: Rt32Fit, honest: Array) -> dict[str, object]:
    """Return the fit for other programs, angles in arcseconds."""
    found: dict[str, object] = typed.as_json(
        {
            "model": "rt32-exact" if fit.exact else "rt32-approximate",
            "input": as_input(fit.recordings),
            "method": fit.method,
            "simulated": "simulated" in fit.recordings.meta,
            "points": len(fit.stack),
            "within_level": int(fit.inside.sum()),
            "level_deg": fit.level / DEG,
            "rms_arcsec": fit.rms / ARCSEC,
            "parameters": [
                {
                    "name": f"p{k + 1}" if k < len(PARAMETERS) else "box_step",
                    "value": value / ARCSEC,
                    "sigma": fit.sigmas[k] / ARCSEC,
                    "sigma_by_sessions": honest[k] / ARCSEC,
                    "unit": "arcsec",
                }
                for k, value in enumerate(fit.values)
            ],
            "correlation": fit.correlation.tolist(),
            "condition_number": fit.condition,
            "warnings": fit.doubts,
        }
    )
    return found
