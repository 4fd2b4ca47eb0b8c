"""A comparison of two models as text, as JSON, and as a picture of the sky."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.correction.compare import LOWEST_DEG, REACH_DEG, Comparison, Sky
from pyport.files import write_whole
from pyport.recordings.schema import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def text(found: Comparison, beam_arcsec: float | None = None, worst: int = 5) -> list[str]:
    """Return lines that say what the new model changes."""
    sky = found.sky
    size = sky.size_arcsec
    most = int(np.argmax(size))
    under = ", ".join(f"{name} {value}" for name, value in sky.conditions.items())
    above = f"over the sky above {LOWEST_DEG:g} deg" + (f" ({under})" if under else "")
    where = f"azimuth {sky.az_deg[most]:g}, elevation {sky.el_deg[most]:g}"
    lines = [] if found.input is None else [counted(found.input)]
    lines += [f"{above}: moves by {sky.rms_arcsec():.2f} arcsec rms, {size[most]:.2f} at {where}"]
    if beam_arcsec is not None:
        share = sky.share(beam_arcsec)
        lines.append(
            f"by more than a beam of {beam_arcsec:g} arcsec: {_where(sky, beam_arcsec, share)}"
        )
    if not sky.observed.all():
        outside = ~sky.observed
        inside = f"{sky.rms_arcsec(sky.observed):.2f}" if sky.observed.any() else "none"
        lines.append(
            f"not observed, further than {REACH_DEG:g} deg from any recording: "
            f"{100 * outside.mean():.0f} % of the grid; moves by {sky.rms_arcsec(outside):.2f} "
            f"arcsec rms there, {inside} where it was observed"
        )
    if (rows := found.rows) is not None:
        for name, before in rows.rms_before.items():
            change = f"rms {before:.2f} -> {rows.rms_after[name]:.2f} arcsec"
            lines.append(f"recordings, {rows.axes[name]}: {change}")
        worse = rows.worse
        lines.append(f"rows that get worse: {len(worse)} of {len(rows.line)}")
        left = zip(rows.line, rows.before_arcsec, rows.after_arcsec, strict=True)
        each = [f"  line {line}: {was:.1f} -> {now:.1f} arcsec" for line, was, now in left]
        lines += [each[n] for n in worse[:worst]]
    lines += [one.words(found.scatter_arcsec or 0.0) for one in found.unsound]
    return lines


def _where(sky: Sky, beam_arcsec: float, share: float) -> str:
    """Return in which elevations the move is more than a beam."""
    beyond = sky.size_arcsec > beam_arcsec
    if not beyond.any():
        return "nowhere"
    low, high = sky.el_deg[beyond].min(), sky.el_deg[beyond].max()
    return f"{100 * share:.0f} % of the sky, elevations {low:g} to {high:g} deg"


def as_json(found: Comparison, beam_arcsec: float | None = None) -> dict[str, Any]:
    """Return the comparison for other programs."""
    sky, size = found.sky, found.sky.size_arcsec
    most = int(np.argmax(size))
    answer: dict[str, Any] = {
        "sky": {
            "rms_arcsec": sky.rms_arcsec(),
            "most_arcsec": float(size[most]),
            "most_at": {"az_deg": float(sky.az_deg[most]), "el_deg": float(sky.el_deg[most])},
            "observed_share": float(sky.observed.mean()),
            "conditions": dict(sky.conditions),
        },
        "unsound": [
            {
                "name": one.value.name,
                "change": one.value.change,
                "sigma": one.value.sigma,
                "refused": one.refused,
            }
            for one in found.unsound
        ],
        "scatter_arcsec": found.scatter_arcsec,
    }
    if found.input is not None:
        answer["input"] = found.input
    if beam_arcsec is not None:
        answer["sky"]["share_beyond_beam"] = sky.share(beam_arcsec)
    if found.rows is not None:
        worse = found.rows.worse
        answer["recordings"] = {
            "rms_before_arcsec": found.rows.rms_before,
            "rms_after_arcsec": found.rows.rms_after,
            "worse": [int(found.rows.line[n]) for n in worse],
        }
    return answer


def picture(found: Comparison, path: Path, title: str, beam_arcsec: float | None = None) -> None:
    """Draw how far the sky moves, and which way; what was not observed is hatched."""
    figure = _figure(found.sky, title, beam_arcsec)
    with write_whole(path, "wb") as file:
        figure.savefig(file, format=path.suffix[1:] or "png", dpi=110)


def _figure(sky: Sky, title: str, beam_arcsec: float | None) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4.6), layout="constrained")
    axes = figure.subplots()
    shape = len(np.unique(sky.az_deg)), len(np.unique(sky.el_deg))
    az, el, size = (one.reshape(shape) for one in (sky.az_deg, sky.el_deg, sky.size_arcsec))
    mesh = axes.pcolormesh(az, el, size, cmap="viridis", shading="nearest", rasterized=True)
    figure.colorbar(mesh, ax=axes, label="arcsec")
    few = (slice(None, None, 5), slice(None, None, 3))
    x, y = (one.reshape(shape) for one in (sky.x_arcsec, sky.y_arcsec))
    if size.any():
        axes.quiver(az[few], el[few], x[few], y[few], color="white", pivot="mid", width=0.002)
    if not sky.observed.all():
        axes.contourf(
            az, el, ~sky.observed.reshape(shape), [0.5, 1.5], colors="none", hatches=["///"]
        )
    if beam_arcsec is not None and size.max() > beam_arcsec > size.min():
        axes.contour(az, el, size, [beam_arcsec], colors="red")
    hatched = "" if sky.observed.all() else "; hatched: not observed"
    axes.set_title(f"{title}{hatched}")
    axes.set_xlabel("azimuth [deg]")
    axes.set_ylabel("elevation [deg]")
    return figure
