"""The published table of the RT32's parameters, with honest sigmas beside the formal ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.pointing import PARAMETERS, printed
from pyport.studies.rt32.fit import Rt32Fit
from pyport.studies.rt32.losses import cut_factor

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
        lines.append(f"{f'p{k + 1}':>4s} " + "".join(map(_share, row[: k + 1])))
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


def _share(correlation: float) -> str:
    return f"{correlation:6.2f}".replace("nan", "  -")


def as_json(fit: Rt32Fit, honest: Array) -> dict[str, object]:
    """Return the fit for other programs, angles in arcseconds."""
    return {
        "model": "rt32-exact" if fit.exact else "rt32-approximate",
        "method": fit.method,
        "simulated": "simulated" in fit.recordings.meta,
        "points": len(fit.stack),
        "within_level": int(fit.inside.sum()),
        "level_deg": fit.level / DEG,
        "rms_arcsec": _number(fit.rms / ARCSEC),
        "parameters": [
            {
                "name": f"p{k + 1}" if k < len(PARAMETERS) else "box_step",
                "value": _number(value / ARCSEC),
                "sigma": _number(fit.sigmas[k] / ARCSEC),
                "sigma_by_sessions": _number(honest[k] / ARCSEC),
                "unit": "arcsec",
            }
            for k, value in enumerate(fit.values)
        ],
        "correlation": [[_number(one) for one in row] for row in fit.correlation],
        "condition_number": _number(fit.condition),
        "warnings": fit.doubts,
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
