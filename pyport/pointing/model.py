"""The RT32's models in the program's own frame: azimuth from north, offsets on the sky."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances
from pyport.pointing import swift
from pyport.pointing.approximate import approximate_columns, approximate_offsets
from pyport.pointing.exact import exact_offsets
from pyport.pointing.jacobian import exact_slopes


def linear_columns(at: Circumstances) -> tuple[Array, Array]:
    """Return the approximate form's columns, (n, 12) each; by effects where points are means."""
    if at.fine is not None:
        return approximate_columns(at)
    return swift.approximate_columns(at.az - math.pi, at.el)


@dataclass(frozen=True)
class Rt32Model:
    """The RT32's model with twelve parameters p1..p12 [rad], exact or approximate."""

    parameters: Array
    exact: bool = True

    def offsets(self, at: Circumstances) -> tuple[Array, Array]:
        """Return the offsets (x, y) across and along elevation [rad], shape (n,) each."""
        form = exact_offsets if self.exact else approximate_offsets
        d_az, d_alt = form(at.az - math.pi, at.el, self.parameters)
        return d_az * np.cos(at.el), d_alt

    def columns(
        self, at: Circumstances, linear: tuple[Array, Array] | None = None
    ) -> tuple[Array, Array]:
        """Return d(x, y)/dp at these parameters, shape (n, 12) each, for a fit's next step.

        The approximate form is its own derivative; the exact one differs from it in
        the four parameters that it is not linear in. `linear` are the columns of the
        approximate form, where they are at hand.
        """
        x, y = linear_columns(at) if linear is None else (one.copy("K") for one in linear)
        if self.exact:
            cosine = np.cos(at.el)
            slopes = exact_slopes(at.az - math.pi, at.el, self.parameters)
            for k, (turn, rise) in slopes.items():
                x[:, k], y[:, k] = turn * cosine, rise
        return x, y
