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
from pyport.pointing.leaning import Axis
from pyport.pointing.swift import Columns


@dataclass(frozen=True)
class Linear:
    """The approximate form's columns in x and in y, and the axes that they were made of."""

    az: Axis
    alt: Axis
    x: Columns
    y: Columns

    @classmethod
    def of(cls, at: Circumstances) -> Linear:
        """Return them for some pointings; by effects where points are means."""
        az, alt = Axis.of(at.az - math.pi), Axis.of_altitudes(at.el)
        if at.fine is None:
            return cls(az, alt, *swift.approximate_columns(az, alt))
        return cls(az, alt, *(dict(enumerate(one.T)) for one in approximate_columns(at)))


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

    def slopes(self, at: Circumstances, linear: Linear | None = None) -> tuple[Columns, Columns]:
        """Return d(x, y)/dp at these parameters for a fit's next step, columns of zeros left out.

        The approximate form is its own derivative; the exact one differs from it in
        the four parameters that it is not linear in. `linear` are the columns of the
        approximate form, where they are at hand.
        """
        linear = linear or Linear.of(at)
        if not self.exact:
            return linear.x, linear.y
        slopes = exact_slopes(linear.az, linear.alt, self.parameters)
        across = {k: turn * linear.alt.cosine for k, (turn, _) in slopes.items()}
        return linear.x | across, linear.y | {k: rise for k, (_, rise) in slopes.items()}
