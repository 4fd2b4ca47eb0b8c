"""What is told of an oscillation: its period, and amplitude and phase in each axis."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis.finding import Parameter
from pyport.diagnosis.joint import excess_of
from pyport.diagnosis.oscillations import likeliest_period
from pyport.diagnosis.scene import Scene


def parameters(scene: Scene, choice: int) -> list[Parameter]:
    """Return the period of an oscillation [min], its amplitudes, and phases where one holds.

    The amplitude of a wandering one is the root mean square of those of its stretches, less what
    their errors add. A phase of 0 has the sine begin at the moment that the variant names.
    """
    chosen, setup = scene.joint.choices[choice], scene.setup
    effect = chosen.candidate.effect
    others = [one for one in scene.outcome.chosen if one is not chosen]
    _, sigma, _ = likeliest_period(setup, scene.weighed.covariance, others, effect)
    found = [Parameter("period", effect.member["period_s"] / 60, sigma / 60, "min")]
    where = scene.joint.slice(choice)
    known = scene.joint.solution.known[where]
    value = scene.joint.solution.values[where][known]
    excess = excess_of(scene.joint, len(setup.residual))
    covariance = excess * scene.joint.solution.covariance[where, where][np.ix_(known, known)]
    names = [effect.coefficients[n].name for n in np.array(chosen.candidate.coefficients)[known]]
    for axis in ("xel", "el"):
        own = [n for n, name in enumerate(names) if name.partition("[")[0].endswith(f"_{axis}")]
        if own:
            found += _of_axis(axis, value[own], covariance[np.ix_(own, own)], held=len(own) == 2)
    return found


def _of_axis(axis: str, value: Array, covariance: Array, *, held: bool) -> list[Parameter]:
    """Return the amplitude in an axis, and the phase where one is `held`."""
    waves = max(len(value) // 2, 1)
    size = float(np.sqrt(value @ value / waves))
    along = value / (waves * max(size, 1e-300))
    sigma = float(np.sqrt(along @ covariance @ along))
    if not held:
        size = float(np.sqrt(max(size**2 - np.trace(covariance) / waves, 0.0)))
        return [Parameter(f"amplitude_{axis}", size / ARCSEC, sigma / ARCSEC, "arcsec")]
    across = np.array([-along[1], along[0]])
    phase = float(np.arctan2(value[1], value[0]))
    error = float(np.sqrt(across @ covariance @ across)) / max(size, 1e-300)
    return [
        Parameter(f"amplitude_{axis}", size / ARCSEC, sigma / ARCSEC, "arcsec"),
        Parameter(f"phase_{axis}", phase / DEG, min(error, np.pi) / DEG, "deg"),
    ]
