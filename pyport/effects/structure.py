"""The structure: a part that is loose, and jumps when the load turns over."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Circumstances, Coefficient, Effect, stack

Edge = Callable[[Array], Array]


def subreflector_jump(edge: Edge, name: str) -> Effect:
    """Return a step in elevation above a curve in the sky.

    Parameters
    ----------
    edge
        Azimuth (from north through east, unwrapped) -> elevation of the curve [rad].
    name
        What to call this curve in a report.
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (0, np.where(at.el >= edge(at.az), 1.0, 0.0)))

    return Effect(
        "subreflector_jump",
        "the offset steps where the telescope crosses a curve in the sky (loose secondary)",
        "Borkowski, RT32 Pointing Model (2004), eq. 19 and routine Hjump",
        (Coefficient("jump"),),
        basis,
        variant=name,
    )


EFFECTS: tuple[Effect, ...] = ()
