"""What is stated of waves in time and of drives: periods, amplitudes, phases; what refutes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.joint import excess_of
from pyport.diagnosis.naming.finding import Parameter
from pyport.diagnosis.naming.guards import nights
from pyport.diagnosis.naming.scene import Check, Scene
from pyport.diagnosis.shapes import drive_waves
from pyport.diagnosis.shapes.edges import levels_of
from pyport.diagnosis.shapes.fields import Ground
from pyport.diagnosis.shapes.wave_fits import likeliest_direction, likeliest_period
from pyport.diagnosis.trial import at_best
from pyport.effects.base import Effect
from pyport.effects.circumstances import DAY_S
from pyport.effects.telescope.encoders import SHORTEST_DEG
from pyport.thresholds import CONVINCING, FEWEST, NAME_PRICE, NOT_EXCLUDED, REFUTES, VISIBLE

#: Order of the curve by which the amplitude of a wave may change along an angle: a third of the
#: range with the wave and two thirds without show in it.
ORDER = 3
#: Share of the power of a wave that a constant draws where angles gather in rings, from which on it
#: is no name alone: thirty pointings all over a circle reach it once in four hundred.
RINGS = 0.2
#: What is said of a bend where too few readings lie on either side of any.
_NO_BEND = Check(passed=True, words="no bend could be seen")
#: So many times its period is what an oscillation may be an overtone of, and overtones of each.
MULTIPLES, OVERTONES = 5, 3


def alias(effect: Effect, way: drive_waves.Way) -> str | None:
    """Return what would distinguish a wave from its like where its angles lie; None without.

    On a grid that is another wave, none too short to be looked for; where they gather in rings as
    far apart as its crests it is what is the same at every ring, and a little off beside them.
    """
    turns, grid_deg = float(effect.member["k"]), way.step
    if drive_waves.in_rings(way, turns) > RINGS:
        return (
            f"observe between the rings, about {360 / turns:.3g} deg apart, that the angles gather "
            "in: there what is no wave draws nearly the same"
        )
    if not grid_deg:
        return None
    like = 360 / grid_deg - turns
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
    effect = chosen.candidate.effect
    angle = drive_waves.angles_of(scene.problem, effect)
    span = max(float(np.ptp(angle)), 1e-300)
    # What is uneven has neighbours: beside them each would look even.
    apart = tuple(
        one
        for one in scene.outcome.chosen
        if one is chosen
        or one.candidate.effect.id != effect.id
        or abs(one.candidate.effect.member["k"] - effect.member["k"]) > ORDER * 360 / span
    )
    return _the_same(scene, effect, angle, apart, "all along")


def everywhere(scene: Scene, chosen: Chosen) -> Check:
    """Check that a wave in one angle is as large as its name says wherever the other angle is.

    Petals that turn over with elevation have as many waves in a turn as a track.
    """
    effect, at = chosen.candidate.effect, scene.problem.recordings.at
    along_second = _of_second(effect)
    angle = (at.axes.az if along_second else at.axes.el)[scene.problem.stack.row]
    other = at.mount.first if along_second else at.mount.second
    return _the_same(scene, effect, angle, scene.outcome.chosen, f"at every {other.name}")


def _the_same(
    scene: Scene, effect: Effect, angle: Array, beside: tuple[Chosen, ...], where: str
) -> Check:
    """Check that a wave times no curve of an angle (m,) has evidence beside what was found."""
    place = 2 * (angle - angle.min()) / max(float(np.ptp(angle)), 1e-300) - 1
    wave = scene.problem.stack.columns(effect, scene.problem.recordings.at)
    bent = np.polynomial.legendre.legvander(place, ORDER)[:, 1:]
    columns = (wave[:, :, None] * bent[:, None]).reshape(len(wave), -1)
    found = Ground(scene.problem, scene.weighed, beside).evidence(columns)
    uneven = found > CONVINCING
    how = f"not the same {where}, evidence {found:.0f}" if uneven else f"the same {where}"
    return Check(not uneven, f"the wave is {how}")


def may_be_a_bend(effect: Effect) -> bool:
    """Tell whether an effect follows the second angle: its harmonics, and steps of its axis."""
    return _of_second(effect) or effect.member.get("axis") == "second"


def _of_second(effect: Effect) -> bool:
    """Tell whether an effect is a wave of the second angle."""
    return effect.on_altaz == "elevation_encoder_harmonics"


def bend(scene: Scene, kind: str) -> tuple[Check, str | None]:
    """Check that no curve that bends once explains what a kind of effect does: it may be a bend.

    A harmonic that takes more than was observed for a period was not seen to come again, and two
    steps are a ramp: what begins at some elevation draws them too. All of their kind together are
    held against one term that begins there and grows with the angle, or with its sine. Returns also
    what would distinguish the two where the recordings exclude neither.
    """
    problem, at = scene.problem, scene.problem.recordings.at
    chosen_in = scene.outcome.chosen
    alike = [
        one
        for one in chosen_in
        if one.candidate.effect.id == kind and not drive_waves.is_short(one.candidate.effect)
    ]
    effect = next(one.candidate.effect for one in alike if may_be_a_bend(one.candidate.effect))
    others = tuple(one for one in chosen_in if not any(one is each for each in alike))
    ground = Ground(problem, scene.weighed, others)
    prices = sum(scene.outcome.step_of(one).price for one in alike)
    held = ground.evidence(problem.expanded(alike)) - prices - NAME_PRICE * (len(alike) - 1)
    is_y, angle = problem.stack.is_y[:, None], at.axes.el[problem.stack.row, None]
    from_rad = levels_of(at.axes, effect) * DEG
    beyond = (is_y & (angle > from_rad)).sum(axis=0)
    from_rad = from_rad[(beyond >= FEWEST) & (is_y.sum() - beyond >= FEWEST)]
    if len(from_rad) == 0:
        return _NO_BEND, None
    rises = [angle - from_rad, np.sin(angle) - np.sin(from_rad)]
    bends = is_y * (angle > from_rad) * np.stack(rises)
    information, alone, moments = ground.products(np.concatenate(bends, axis=1))
    power, length = np.diag(information), np.diag(alone)
    seen = np.flatnonzero(power > VISIBLE**2 * length)
    if len(seen) == 0:
        return _NO_BEND, None
    best = seen[[np.argmax(moments[seen] ** 2 / power[seen])]]
    lead = at_best(power[best], moments[best])[0] - 2 * float(np.log(len(power))) - held
    where = f"{from_rad[best[0] % len(from_rad)] / DEG:.0f} deg of {at.mount.second.name}"
    like = f"follow sources through {where}, from which on something else may act: a bend is sudden"
    how = "more" if lead > 0 else "less"
    words = f"a bend at {where} has {how} evidence, by {abs(lead):.0f}"
    return Check(lead <= CONVINCING, words), like if lead > -NOT_EXCLUDED else None


def of_drive(scene: Scene, choice: int, plain: Sequence[Parameter]) -> list[Parameter]:
    """Return the period of a drive's wave [deg], amplitude and phase, and its coefficients.

    An error of the number in a turn turns the phase at angle zero, where the recordings may not
    reach; a whole number has none.
    """
    chosen = scene.joint.choices[choice]
    effect = chosen.candidate.effect
    others = scene.outcome.others(chosen)
    turns_of, noise = float(effect.member["k"]), scene.weighed.covariance
    sigma = drive_waves.sigma_of(scene.problem, noise, others, effect)
    period = Parameter("period", 360 / turns_of, 360 / turns_of**2 * sigma, "deg")
    value, covariance = _solved(scene, choice)
    amplitude, phase = of_axis("", value, covariance)
    free = 0.0 if turns_of.is_integer() else sigma
    turned = free * abs(float(np.mean(drive_waves.angles_of(scene.problem, effect))))
    return [
        period,
        replace(amplitude, name="amplitude"),
        replace(phase, name="phase", sigma=min(float(np.hypot(phase.sigma, turned)), 180.0)),
        *(
            replace(one, sigma=float(np.hypot(one.sigma, amplitude.value * turned * DEG)))
            for one in plain
        ),
    ]


def own_period(scene: Scene, chosen: Chosen) -> Check:
    """Check that what is left, folded at the period of an oscillation, repeats no slower.

    Short pulses have overtones as strong as themselves, and one of them may be what was found.
    Beside the oscillation a free curve at a multiple of its period has then more evidence than one
    at the period itself.
    """
    problem, period_s = scene.problem, chosen.candidate.effect.member["period_s"]
    ground = Ground(problem, scene.weighed, scene.outcome.chosen)
    time_s = problem.recordings.at.numbers("time")[problem.stack.row]
    turns_of = 2 * np.pi * (time_s - time_s.min()) / period_s
    upward = problem.stack.is_y[:, None]
    found = []
    for times in range(1, MULTIPLES + 1):
        orders = [n for n in range(1, OVERTONES * times + 1) if n != times]
        angles = turns_of[:, None] * np.array(orders) / times
        waves = np.concatenate([np.sin(angles), np.cos(angles)], axis=1)
        both = np.concatenate([waves * upward, waves * ~upward], axis=1)
        found.append(ground.evidence(both))
    best = int(np.argmax(found))
    slower = found[best] - max(found[0], 0.0)
    slow = slower > CONVINCING
    how = f"every {best + 1} periods, evidence {slower:.0f}" if slow else "no slower"
    return Check(not slow, f"what it leaves repeats {how}")


def of_a_day(scene: Scene, effect: Effect, period: Parameter) -> Check:
    """Check that the period of an oscillation is no overtone of a day, which nights have in common.

    What goes with the time of day is seldom one sine, and what a sine leaves of it has overtones.
    Beyond `MULTIPLES` of them periods that have nothing to do with the day come near one.
    """
    minutes = DAY_S / 60
    times = round(minutes / period.value)
    off = abs(times * period.value - minutes) > REFUTES * times * period.sigma
    in_phase = effect.changes_with != "stretch" and nights(scene) > 1
    if off or times > MULTIPLES or not in_phase:
        return Check(passed=True, words="its period is no overtone of a day")
    words = f"{times} of its periods are a day: what goes with the time of day has such overtones"
    return Check(passed=False, words=words)


def of_oscillation(scene: Scene, choice: int) -> list[Parameter]:
    """Return the period of an oscillation [min], its amplitudes, and phases where one holds.

    Of one that wanders they are the line that it swings along, and the root mean square of the
    amplitudes of its stretches, less what their errors add. A phase of 0 has the sine begin at the
    moment that the variant names.
    """
    chosen, problem = scene.joint.choices[choice], scene.problem
    effect = chosen.candidate.effect
    others = scene.outcome.others(chosen)
    _, sigma, _ = likeliest_period(problem, scene.weighed.covariance, others, effect)
    found = [Parameter("period", effect.member["period_s"] / 60, sigma / 60, "min")]
    known = scene.joint.solution.known[scene.joint.slice(choice)]
    value, covariance = _solved(scene, choice)
    value, covariance = value[known], covariance[np.ix_(known, known)]
    if "direction_deg" in effect.member:
        line = likeliest_direction(problem, scene.weighed.covariance, others, effect)[:2]
        measured = np.unique(problem.stack.is_y).astype(int)
        swing = _along(*line, *_wandering(value, covariance))
        return found + ([swing[1 + measured[0]]] if len(measured) == 1 else swing)
    names = [effect.coefficients[n].name for n in np.array(chosen.candidate.coefficients)[known]]
    for axis in ("xel", "el"):
        own = [n for n, name in enumerate(names) if name.partition("[")[0].endswith(f"_{axis}")]
        if len(own) == 2:
            found += of_axis(axis, value[own], covariance[np.ix_(own, own)])
    return found


def _wandering(value: Array, covariance: Array) -> tuple[float, float]:
    """Return the root mean square of amplitudes (2 n,), less what errors add, and its sigma."""
    waves = len(value) / 2
    size = float(np.sqrt(value @ value / waves))
    along = value / (waves * max(size, 1e-300))
    size = float(np.sqrt(max(size**2 - np.trace(covariance) / waves, 0.0)))
    return size, float(np.sqrt(along @ covariance @ along))


def _along(direction_deg: float, error_deg: float, size: float, sigma: float) -> list[Parameter]:
    """Return a line and its error, and what an amplitude along it is in either axis."""
    angle, error = direction_deg * DEG, error_deg * DEG
    shares = {"xel": (np.cos(angle), np.sin(angle)), "el": (np.sin(angle), np.cos(angle))}
    return [
        Parameter("direction", direction_deg, error_deg, "deg"),
        *(
            Parameter(
                f"amplitude_{axis}",
                size * abs(along) / ARCSEC,
                float(np.hypot(sigma * along, size * across * error)) / ARCSEC,
                "arcsec",
            )
            for axis, (along, across) in shares.items()
        ),
    ]


def _solved(scene: Scene, choice: int) -> tuple[Array, Array]:
    """Return the coefficients of a choice (P,) and their covariance, (P, P)."""
    where = scene.joint.slice(choice)
    excess = excess_of(scene.joint)
    solution = scene.joint.solution
    return solution.values[where], excess * solution.covariance[where, where]


def of_axis(axis: str, value: Array, covariance: Array) -> list[Parameter]:
    """Return the amplitude in an axis and the phase, of a sine and a cosine (2,)."""
    size = float(np.hypot(*value))
    along = value / max(size, 1e-300)
    sigma = float(np.sqrt(along @ covariance @ along))
    across = np.array([-along[1], along[0]])
    phase = float(np.arctan2(value[1], value[0]))
    error = float(np.sqrt(across @ covariance @ across)) / max(size, 1e-300)
    return [
        Parameter(f"amplitude_{axis}", size / ARCSEC, sigma / ARCSEC, "arcsec"),
        Parameter(f"phase_{axis}", phase / DEG, min(error, np.pi) / DEG, "deg"),
    ]
