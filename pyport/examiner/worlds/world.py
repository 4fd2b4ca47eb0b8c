"""The world of one case: the real sky, the real telescope, and what its steering believes."""

from __future__ import annotations

from dataclasses import astuple, dataclass, field, replace

import numpy as np

from pyport.angles import Array, wrap
from pyport.examiner.worlds import mount as mounts
from pyport.examiner.worlds import sky
from pyport.examiner.worlds.earth import EARTH_RADIUS_M, Site
from pyport.examiner.worlds.mount import Each, Mount
from pyport.examiner.worlds.schedule import Plan
from pyport.examiner.worlds.sky import bending

#: Time on either side over which a rate of tracking is taken. [s]
_BESIDE_S = 20.0

_IONOSPHERE_HEIGHT_M = 350e3
_IONOSPHERE_M3_S2 = 40.308


@dataclass(frozen=True)
class Steering:
    """What the steering program believes of the sky."""

    steps: frozenset[str] = sky.STEPS  #: which steps of the reduction it takes
    clock_s: Each = 0.0  #: its clock minus UTC
    #: `north`, `east`: assumed minus real place of the telescope, as angles of latitude and
    #: longitude [rad].
    north: Each = 0.0
    east: Each = 0.0
    #: `ra`, `dec`: catalogued minus real place of each source [rad].
    ra: Each = 0.0
    dec: Each = 0.0
    #: `bent`, `curved`, `wet`: what its refraction is multiplied by, see `sky.Air`.
    bent: Each = 1.0
    curved: Each = 1.0
    wet: Each = 1.0


@dataclass(frozen=True)
class Drive:
    """How the axes move; seconds and radians, scalars or one value for each pointing.

    `lag_*_s` is how late the beam is behind the encoder while tracking,
    `slack_*` half of the play that the encoder leads by, `tag_s` how late the
    time tags of scans are, `hysteresis_*` half of what forward and reverse
    scans differ by.
    """

    lag_az_s: Each = 0.0
    lag_el_s: Each = 0.0
    slack_az: Each = 0.0
    slack_el: Each = 0.0
    tag_s: Each = 0.0
    hysteresis_az: Each = 0.0
    hysteresis_el: Each = 0.0


@dataclass(frozen=True)
class World:
    """A plan carried out by a telescope under the sky."""

    #: `plan`, `mount`, `stand`, `drive`, `steering`: what was scheduled, what it is made of, how it
    #: stands, how it moves, what it believes.
    plan: Plan
    mount: Mount = field(default_factory=Mount)
    stand: mounts.Stand = field(default_factory=mounts.Stand)
    base: tuple[Mount, ...] = mounts.BASE  #: the terms of the model, each askew by an arcsecond
    drive: Drive = field(default_factory=Drive)
    steering: Steering = field(default_factory=Steering)
    #: Horizontal parallax of each target [rad]: the Earth's radius over its distance.
    near: Each = 0.0
    electrons_m2: Each = 0.0  #: free electrons overhead that the steering does not know of
    #: Whether the real air is followed layer by layer rather than by ERFA's two coefficients.
    layered: bool = False
    #: `across`, `up`: offsets [rad] that no part of a telescope is known to make.
    across: Each = 0.0
    up: Each = 0.0

    def with_mount(self, *waves: mounts.Wave, **more: Each) -> World:
        """Return the world with something added to the mount."""
        return replace(self, mount=self.mount.plus(*waves, **more))

    def with_drive(self, **more: Each) -> World:
        """Return the world with something added to the drive."""
        return replace(
            self,
            drive=replace(self.drive, **{k: getattr(self.drive, k) + v for k, v in more.items()}),
        )

    def with_steering(self, **beliefs: object) -> World:
        """Return the world with other beliefs."""
        return replace(self, steering=replace(self.steering, **beliefs))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Observation:
    """What a world's recordings would say without noise, shape (n,) each.

    `az` (in [0, 2 pi)), `el`, `hour_angle` are the position that the steering
    believes in, `first` and `second` its angles about the mount's axes; `x` (times
    the cosine of the second) and `y` the encoders minus these [rad].
    """

    az: Array
    el: Array
    hour_angle: Array
    x: Array
    y: Array
    first: Array
    second: Array


def believed(world: World, later_s: float = 0.0) -> sky.Place:
    """Return where the steering program computes the sources to be."""
    plan, steering = world.plan, world.steering
    site = plan.reference.moved(steering.north, steering.east)
    air = replace(plan.air(), bent=steering.bent, curved=steering.curved, wet=steering.wet)
    ra = plan.ra + steering.ra
    dec = plan.dec + steering.dec
    time_s = plan.time_s + steering.clock_s + later_s
    return sky.observed(ra, dec, time_s, site, air, steering.steps)


def arriving(world: World) -> tuple[Array, Array]:
    """Return azimuth and elevation [rad] from which the sources' waves really come."""
    plan = world.plan
    steps = sky.STEPS - {"refraction"} if world.layered else sky.STEPS
    place = sky.observed(plan.ra, plan.dec, plan.time_s, plan.site, plan.air(), steps)
    lifted = place.el + bending(place.el, plan.air()) if world.layered else place.el
    cos_el, sin_el = np.cos(lifted), np.sin(lifted)
    # From the surface a near target stands lower: its height shrinks by one radius of the Earth.
    el = np.arctan2(sin_el - world.near, cos_el)
    return place.az, el + _ionosphere(world, el)


def _ionosphere(world: World, el: Array) -> Array:
    """Return how far a shell of electrons lifts a source [rad].

    A phase front is tilted by the slope, over the ground, of the extra path
    L / cos z' through the shell, z' being the zenith distance up there.
    """
    frequency_hz = world.plan.weather["frequency_mhz"] * 1e6
    path_m = _IONOSPHERE_M3_S2 * np.asarray(world.electrons_m2) / frequency_hz**2
    ratio = (EARTH_RADIUS_M / (EARTH_RADIUS_M + _IONOSPHERE_HEIGHT_M)) ** 2
    slant = 1 / np.sqrt(1 - ratio * np.cos(el) ** 2)
    return path_m * ratio * slant**3 * np.cos(el) / EARTH_RADIUS_M


def observe(world: World) -> Observation:
    """Carry out a plan and return what is measured, noise apart."""
    thought = believed(world)
    real_az, real_el = arriving(world)
    real = (unwrapped(world.plan, real_az), real_el)
    x, y = world.stand.shown(world.mount, thought.az, thought.el, real)
    first, second = world.stand.angles(thought.az, thought.el)
    moved_first, moved_second = _moved(world)
    x = x + moved_first * np.cos(second) + world.across
    y = y + moved_second + world.up
    return Observation(thought.az, thought.el, thought.hour_angle, x, y, first, second)


def _moved(world: World) -> tuple[Array, Array]:
    """Return what moving adds to the readings of both axes [rad]."""
    if not any(np.any(part) for part in astuple(world.drive)):
        return np.zeros(len(world.plan)), np.zeros(len(world.plan))
    before, after = (
        world.stand.angles(place.az, place.el)
        for place in (believed(world, -_BESIDE_S), believed(world, _BESIDE_S))
    )
    rate_az = wrap(after[0] - before[0]) / (2 * _BESIDE_S)
    rate_el = (after[1] - before[1]) / (2 * _BESIDE_S)
    plan, drive = world.plan, world.drive
    scanned = plan.scan_direction
    play = scanned * plan.scan_rate * drive.tag_s
    az = drive.lag_az_s * rate_az + drive.slack_az * np.sign(rate_az)
    el = drive.lag_el_s * rate_el + drive.slack_el * np.sign(rate_el)
    az = az + plan.measures("az") * (play + scanned * drive.hysteresis_az)
    el = el + plan.measures("el") * (play + scanned * drive.hysteresis_el)
    return az, el


def unwrapped(plan: Plan, az: Array) -> Array:
    """Return azimuths [rad] as the cable is wrapped, within 270 deg of its middle either way.

    Each antenna takes the turn that is nearest to where it was.
    """
    turns = np.empty(len(az))
    for antenna in np.unique(plan.labels["antenna"]):
        here = plan.cable_middle
        for row in np.flatnonzero(plan.labels["antenna"] == antenna):
            turn = here + float(wrap(az[row] - here))
            beyond = turn - plan.cable_middle
            if abs(beyond) > 1.5 * np.pi:
                turn -= np.copysign(2 * np.pi, beyond)
            here = turns[row] = turn
    return turns


def assumed_site(world: World) -> Site:
    """Return the place that the steering believes the telescope to be at."""
    return world.plan.reference.moved(world.steering.north, world.steering.east)
