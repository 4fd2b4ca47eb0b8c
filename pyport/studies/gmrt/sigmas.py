"""How much too small the printed sigmas are, told by Table 18 alone."""

from __future__ import annotations

import numpy as np

from pyport.studies.gmrt.published import table_18

#: A normal sample's median of absolute values is this share of its sigma.
_HALF = 0.6744897501960817


def printed_sigma_factors(first: str, second: str) -> dict[str, float]:
    """Return by how much a, b and d differ between two days, in units of their printed sigmas.

    One would say that the sigmas are honest and the antennas repeat. The median
    over antennas, so that a few that do not repeat have no say.
    """
    curves = {(wave.antenna, wave.session): wave for wave in table_18()}
    pairs = [
        (wave, curves[wave.antenna, second])
        for (_, session), wave in curves.items()
        if session == first and (wave.antenna, second) in curves
    ]
    factors = {}
    for name in ("a", "b", "d"):
        apart = [
            abs(getattr(one, name) - getattr(other, name))
            / np.hypot(getattr(one, f"sigma_{name}"), getattr(other, f"sigma_{name}"))
            for one, other in pairs
        ]
        factors[name] = float(np.median(apart)) / _HALF
    return factors
