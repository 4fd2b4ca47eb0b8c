"""The finding that a survey makes: antennas that do not stand where they were computed for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import ARCMIN, ARCSEC
from pyport.diagnosis.arrays.report import ArrayReport
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.finding import Evidence, Finding, HeldOut, Parameter, Where
from pyport.diagnosis.joint import rms, visible
from pyport.diagnosis.scene import axes
from pyport.effects import CATALOGUE
from pyport.thresholds import SIGNIFICANT

_DECIDE = "compute each antenna's offsets for its own coordinates; what leans still is the mount"


def with_site(diagnosis: Diagnosis, found: ArrayReport | None) -> Diagnosis:
    """Add `site_longitude` to the findings where a survey shows that it is the site."""
    if found is None or found.comparison is None or not found.comparison.is_the_site:
        return diagnosis
    site = _finding(diagnosis, found)
    strongest_first = sorted((*diagnosis.findings, site), key=lambda one: -one.evidence.delta_bic)
    p_value = min(diagnosis.p_value, site.evidence.p_value)
    return replace(diagnosis, findings=tuple(strongest_first), p_value=p_value)


def _finding(diagnosis: Diagnosis, found: ArrayReport) -> Finding:
    setup, one = diagnosis.setup, found.comparison
    site, implied = setup.recordings.at.site, found.places
    if one is None or site is None or implied is None:
        raise ValueError("no survey was compared")
    # of longitude, as the effect's coefficient is
    radius = implied.radius_m * np.cos(site.latitude)
    shift = dict(zip(one.antennas, one.slope * one.surveyed_m / radius, strict=True))
    antennas = setup.blocks.antenna[setup.block]
    column = setup.stack.columns(CATALOGUE["site_longitude"], setup.recordings.at)[:, 0]
    curve = column * np.array([shift.get(str(name), 0.0) for name in antennas])
    seen = visible(setup, diagnosis.weighed, curve)
    moved = np.isin(antennas, one.antennas)
    standing = np.abs(one.implied_m) > SIGNIFICANT * one.sigma_m
    lean = one.lean_m / implied.radius_m / ARCMIN
    return Finding(
        effect="site_longitude",
        members=("site_longitude",),
        verdict="named",
        sentence=(
            "the antennas do not stand where their offsets were computed for: hour angles shift, "
            "or verticals lean, in proportion to the distance toward east, by "
            f"{one.slope:.2f} +- {one.slope_sigma:.2f} of what the survey asks for (correlation "
            f"{one.correlation:.2f}, {len(one.antennas)} antennas); beside it each mount leans by "
            f"{lean:.2f} arcmin of its own"
        ),
        where=Where(
            axes(setup, curve),
            {"antenna": [n for n, there in zip(one.antennas, standing, strict=True) if there]},
        ),
        parameters=(
            Parameter("implied_over_surveyed", one.slope, one.slope_sigma, "", 1.0),
            *(
                Parameter(f"longitude_error[{name}]", value, sigma, "arcsec")
                for name, value, sigma in zip(
                    one.antennas,
                    one.implied_m / radius / ARCSEC,
                    one.sigma_m / radius / ARCSEC,
                    strict=True,
                )
            ),
        ),
        evidence=Evidence(one.p_value, one.delta_bic, "tilt", 0.0),
        visible_rms=rms(seen[moved], diagnosis.share[moved]),
        true_rms=rms(curve[moved], diagnosis.share[moved]),
        heldout=HeldOut(
            "each antenna's lean from the line through all others",
            one.unseen_m[0] / implied.radius_m,
            one.unseen_m[1] / implied.radius_m,
            float(np.median(one.sigma_m)) / implied.radius_m,
        ),
        decide_by=_DECIDE,
    )
