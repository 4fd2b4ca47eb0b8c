"""The fit of the RT32 Pointing Model (2004), and robust ones beside it."""

from __future__ import annotations

from pyport.studies.rt32.fit import Rt32Fit, fit_rt32
from pyport.studies.rt32.losses import LEVEL, METHODS, BoxStep, box_step

__all__ = ["LEVEL", "METHODS", "BoxStep", "Rt32Fit", "box_step", "fit_rt32"]
