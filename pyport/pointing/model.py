"""The RT32's models in the program's own frame: azimuth from north, offsets on the sky."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances
from pyport.pointing.approximate import approximate_columns, approximate_offsets
from pyport.pointing.exact import exact_offsets

#: The parameters that the exact form is not linear in: skew, box and the two tilts.
_NONLINEAR = (2, 3, 4, 5)

#: Step of the central differences for those [rad]: 20 arcsec, as large as the parameters.
_STEP = 1e-4


@dataclass(frozen=True)
class Rt32Model:
    """The RT32's model with twelve parameters p1..p12 [rad], exact or approximate."""

    parameters: Array
    exact: bool = True

    def offsets(self, at: Circumstances) -> tuple[Array, Array]:
        """Return the offsets (x, y) across and along elevation [rad], shape (n,) each."""
        return self._offsets(at, self.parameters)

    def columns(self, at: Circumstances) -> tuple[Array, Array]:
        """Return d(x, y)/dp at these parameters, shape (n, 12) each, for a fit's next step.

        The approximate form is its own derivative; of the exact one the four
        parameters that are not linear are differenced centrally.
        """
        x, y = approximate_columns(at)
        if self.exact:
            for k in _NONLINEAR:
                step = np.zeros(len(self.parameters))
                step[k] = _STEP
                ahead = self._offsets(at, self.parameters + step)
                behind = self._offsets(at, self.parameters - step)
                x[:, k] = (ahead[0] - behind[0]) / (2 * _STEP)
                y[:, k] = (ahead[1] - behind[1]) / (2 * _STEP)
        return x, y

    def _offsets(self, at: Circumstances, p: Array) -> tuple[Array, Array]:
        form = exact_offsets if self.exact else approximate_offsets
        d_az, d_alt = form(at.az - math.pi, at.el, p)
        return d_az * np.cos(at.el), d_alt
