"""The RT32's jump: on simulated campaigns, with everything but the jump in the model."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import DEG
from pyport.examiner.acceptance.drawn import Line, reported
from pyport.examiner.sealed.files import write_recordings
from pyport.examiner.worlds.faults.mount import rt32_edge_on_the_cable
from pyport.examiner.worlds.kinds import make_case

#: The published model without its last parameter.
TERMS = (
    *("azimuth_zero", "elevation_zero", "collimation", "skew", "tilt", "sag_cosine"),
    *("sag_sine", "azimuth_harmonics", "elevation_harmonics"),
)
CAMPAIGNS = 3
#: The published p12, which the campaigns are made with.
SIZE_ARCSEC = -73.4
#: Where the edge must be, how far off the size may be, how long it may take.
NEAR_DEG, SIGMAS, SECONDS = 2.0, 2.0, 5.0


def lines(seed: int) -> Iterator[Line]:
    """Yield the figures of some campaigns; `seed` is that of the first."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        model = folder / "without-p12.toml"
        model.write_text("".join(f'[[term]]\neffect = "{one}"\n' for one in TERMS), "utf-8")
        for n in range(CAMPAIGNS):
            yield from _campaign(seed + n, folder, str(model))


def _campaign(seed: int, folder: Path, model: str) -> Iterator[Line]:
    made = make_case("rt32-campaign", seed)
    path = folder / f"campaign-{seed}.csv"
    write_recordings(made, path)
    started = time.perf_counter()
    report = reported(made, path, model)
    took = time.perf_counter() - started
    head = f"RT32 campaign {seed}"
    jumps = [one for one in report["findings"] if one["effect"] == "subreflector_jump"]
    named = bool(jumps) and jumps[0]["verdict"] == "named"
    yield Line(f"{head}: jump named", "yes" if named else "no", "yes", named)
    if jumps:
        edge = _edge_off_deg(jumps[0])
        size = jumps[0]["parameters"][0]
        off = abs(size["value"] - SIZE_ARCSEC) / size["sigma"]
        near = edge is not None and edge <= NEAR_DEG
        told = "no curve" if edge is None else f"{edge:.2f} deg"
        yield Line(f"{head}: its edge is off by", told, f"at most {NEAR_DEG:g} deg", near)
        told = f"{size['value']:.1f} +- {size['sigma']:.1f} arcsec, {off:.1f} sigma off"
        yield Line(f"{head}: its size", told, f"within {SIGMAS:g} sigma", off <= SIGMAS)
    others = [one["effect"] for one in report["findings"] if one not in jumps]
    yield Line(f"{head}: found besides", ", ".join(others) or "nothing", "shown", None)
    rows = report["input"]["rows"]
    yield Line(
        f"{head}: {rows} rows diagnosed in",
        f"{took:.1f} s",
        f"{SECONDS:g} s",
        took < SECONDS,
    )


def _edge_off_deg(jump: dict[str, Any]) -> float | None:
    """Return the median distance in elevation between the curve that was found and the true one."""
    curve = jump["where"]["curve"]
    if not curve:
        return None
    # The cable's azimuth counts from south, the report's from north.
    az_south = np.radians([point["az_deg"] - 180 for point in curve])
    el = np.array([point["el_deg"] for point in curve])
    return float(np.median(np.abs(el - rt32_edge_on_the_cable(az_south) / DEG)))
