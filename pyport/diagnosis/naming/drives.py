"""What is stated of a drive's wave: its period, whether it is even, and its like on grids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.evidence import at_best
from pyport.diagnosis.joint import excess_of
from pyport.diagnosis.naming.finding import Parameter
from pyport.diagnosis.naming.scene import Check, Scene
from pyport.diagnosis.shapes import drive_waves
from pyport.diagnosis.shapes.fields import Ground
from pyport.effects.base import Effect
from pyport.effects.telescope.encoders import SHORTEST_DEG
from pyport.thresholds import CONVINCING

#: Order of the curve by which the amplitude of a drive's wave may change along its angle.
ORDER = 3


def alias(effect: Effect, grid_deg: float) -> str | None:
    """Return what would tell a wave from its like on a grid of some step [deg]; None without.

    One that is too short to be looked for is none.
    """
    if not grid_deg:
        return None
    like = 360 / grid_deg - effect.member["k"]
    if like > 360 / SHORTEST_DEG:
        return None
    return (
        f"observe between the steps of {grid_deg:.4g} deg that the angles lie on: there a wave of "
        f"{360 / like:.4g} deg, {like:.5g} per turn, looks the same"
    )


def throughout(scene: Scene, chosen: Chosen) -> Check:
    """Check that a wave of a drive is as large, and its period as long, all along its angle.

    A notch or a ridge has short waves too, of amplitudes that are its own at each of them.
    """
    setup, effect = scene.setup, chosen.candidate.effect
    angle = drive_waves.angles_of(setup, effect)
    span = max(float(np.ptp(angle)), 1e-300)
    # What is uneven has neighbours: beside them each would look even.
    apart = tuple(
        one
        for one in scene.outcome.chosen
        if one is chosen
        or one.candidate.effect.id != effect.id
        or abs(one.candidate.effect.member["k"] - effect.member["k"]) > ORDER * 360 / span
    )
    ground = Ground(setup, scene.weighed, apart)
    place = 2 * (angle - angle.min()) / span - 1
    wave = setup.stack.columns(effect, setup.recordings.at)
    bent = np.polynomial.legendre.legvander(place, ORDER)[:, 1:]
    columns = (wave[:, :, None] * bent[:, None]).reshape(len(wave), -1)
    information, _, moments = ground.products(columns)
    power, vectors = np.linalg.eigh(information)
    found = at_best(np.maximum(power, 0.0), vectors.T @ moments)[0]
    uneven = found > CONVINCING
    how = f"not the same all along, evidence {found:.0f}" if uneven else "the same all along"
    return Check(not uneven, f"the wave is {how}")


def parameters(scene: Scene, choice: int, plain: Sequence[Parameter]) -> list[Parameter]:
    """Return the period of a drive's wave [deg], amplitude and phase, and its coefficients.

    An error of the number in a turn turns the phase at angle zero, where the recordings may not
    reach; a whole number has none.
    """
    chosen = scene.joint.choices[choice]
    effect, where = chosen.candidate.effect, scene.joint.slice(choice)
    others = [one for one in scene.outcome.chosen if one is not chosen]
    turns_of, noise = float(effect.member["k"]), scene.weighed.covariance
    sigma = drive_waves.sigma_of(scene.setup, noise, others, effect)
    period = Parameter("period", 360 / turns_of, 360 / turns_of**2 * sigma, "deg")
    value = scene.joint.solution.values[where]
    excess = excess_of(scene.joint, len(scene.setup.residual))
    covariance = excess * scene.joint.solution.covariance[where, where]
    amplitude, phase = of_axis("", value, covariance, held=True)
    free = 0.0 if turns_of.is_integer() else sigma
    turned = free * abs(float(np.mean(drive_waves.angles_of(scene.setup, effect))))
    return [
        period,
        replace(amplitude, name="amplitude"),
        replace(phase, name="phase", sigma=min(float(np.hypot(phase.sigma, turned)), 180.0)),
        *(
            replace(one, sigma=float(np.hypot(one.sigma, amplitude.value * turned * DEG)))
            for one in plain
        ),
    ]


def of_axis(axis: str, value: Array, covariance: Array, *, held: bool) -> list[Parameter]:
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
