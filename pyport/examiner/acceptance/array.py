"""The GMRT: what all antennas share, what is each one's own, where each stands."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pyport.angles import ARCMIN
from pyport.diagnosis.arrays.unseen import medians
from pyport.examiner.acceptance.drawn import Line
from pyport.recordings.antennas import Survey
from pyport.studies.gmrt.array import GAINED, evidence


def lines(survey: Survey | None) -> Iterator[Line]:
    """Yield the figures of the GMRT's recordings; without a survey no place is compared."""
    found = evidence(survey)
    array = found.array
    tags = [
        f"{one.name} {one.tag[0]:+.2f} +- {one.tag[1]:.2f} s" for one in array.sessions if one.tag
    ]
    yield Line("GMRT, time tags of scans, for all antennas", ", ".join(tags), "shown", None)
    for check in found.checks:
        yield Line(f"GMRT, {check.what}", f"{check.value:.3f}", check.wanted, check.passed)
    if array.unseen is not None:
        median = medians(array.unseen.of(GAINED))
        told = f"{median.fitted_before / ARCMIN:.2f}' to {median.fitted_after / ARCMIN:.2f}'"
        factor = median.fitted_before / median.fitted_after
        what = f"GMRT, {GAINED}: rms of the median antenna in the fit falls by"
        yield Line(what, f"{factor:.3f} ({told})", "shown", None)
        weak = [one for one in array.unseen.days if one.why]
        told = f"{len(weak)} of {len(array.unseen.days)}; `pyport study gmrt-array` has the reasons"
        yield Line("GMRT, antenna-days that gain less than twice", told, "shown", None)
    for name, crab in found.crab.items():
        if not crab.days:
            yield Line(f"{name}, the Crab, from Cyg A", "no antenna", "shown", None)
            continue
        median = medians(crab.days)
        numbers = np.array([median.before, median.after, median.fitted_before]) / ARCMIN
        told = "{:.2f}' to {:.2f}'; the model fitted to that very day {:.2f}'".format(*numbers)
        yield Line(f"{name}, the Crab, from Cyg A: rms of the median antenna", told, "shown", None)
