"""What is said of the noise: what sessions and sources do, where it grows, what was derived."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.recordings.sky import ORDER, SESSIONS

if TYPE_CHECKING:
    from pyport.diagnosis.diagnose import Diagnosis

_HOW = {"session": "Night-to-night", "source": "Source-to-source"}
#: Scatter that differs by less than a quarter between low and high is not worth a word.
GROWS = 1.25
#: The lowest and the highest share of the readings that are compared.
END = 0.2


def departures(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return the random departures of sessions and sources, for reports."""
    return [
        {
            "term": one.term,
            "of": one.of,
            "antenna": one.antenna,
            "sigma_arcsec": one.sigma / ARCSEC,
            "labels": list(dict.fromkeys(one.labels)),
        }
        for one in diagnosis.weighed.covariance.departures
        if one.sigma > 0
    ]


def by_elevation(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return how many times the scatter at the lowest elevations is that at the highest, by axis.

    Of the fifth of the readings at either end; only where it differs by a quarter and more.
    """
    setup, floor = diagnosis.setup, diagnosis.weighed.covariance.floor
    el = setup.recordings.at.el[setup.stack.row]
    found = []
    for is_y, name in zip((False, True), setup.recordings.at.mount.names, strict=True):
        rows = np.flatnonzero((setup.stack.is_y == is_y) & diagnosis.weighed.used)
        end = int(END * len(rows))
        if end == 0:
            continue
        order = rows[np.argsort(el[rows], kind="stable")]
        low, high = (float(np.median(floor[part])) for part in (order[:end], order[-end:]))
        ratio = low / max(high, 1e-300)
        if max(ratio, 1 / ratio) >= GROWS:
            found.append(
                {
                    "axis": name,
                    "low_el_deg": float(np.median(el[order[:end]])) / DEG,
                    "high_el_deg": float(np.median(el[order[-end:]])) / DEG,
                    "low_arcsec": low / ARCSEC,
                    "high_arcsec": high / ARCSEC,
                }
            )
    return found


def sentences(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence for everything that the noise does beyond scattering evenly."""
    said = [
        f"{_HOW[one['of']]} scatter of the {one['term']}: {one['sigma_arcsec']:.2g} arcsec "
        f"({len(one['labels'])} {one['of']}s)"
        for one in departures(diagnosis)
    ]
    said += [
        f"Scatter in {one['axis']} is {one['low_arcsec']:.2g} arcsec near "
        f"{one['low_el_deg']:.0f} deg of elevation and {one['high_arcsec']:.2g} near "
        f"{one['high_el_deg']:.0f} deg"
        for one in by_elevation(diagnosis)
    ]
    meta = diagnosis.setup.recordings.meta
    if SESSIONS in meta:
        said.append(f"Sessions are not recorded: they are taken from {meta[SESSIONS]}")
    if ORDER in meta:
        said.append(f"Time is not recorded: the order is {meta[ORDER].partition(',')[0]}")
    return said
