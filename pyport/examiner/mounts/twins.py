"""Twins: names whose traces recordings cannot distinguish, drawn by rotations.

An observer who knows the noise and every trace distinguishes two of them by what one leaves
of the other once the model took its share. Below a tenth of the variance, a cosine above 0.95,
both names are right. A name that is not drawn here is no twin of anything.

In the frame of its first axis every mount is the chain of `worlds.mount`: what is there called
east, north and up are the direction of a quarter turn, that of zero, and the axis itself. Gravity
alone knows where up is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from pyport.angles import ARCSEC, Array, wrap
from pyport.examiner.nulls import schedule
from pyport.examiner.worlds.mount import Each, Mount, Wave, az_el, beam, direction, readings

#: Latitude -> where a quarter turn, zero and the first axis point, rows east-north-up.
FRAMES: dict[str, Callable[[float], Array]] = {
    "equatorial": lambda phi: np.array(
        [[-1, 0, 0], [0, -np.sin(phi), np.cos(phi)], [0, np.cos(phi), np.sin(phi)]]
    ),
    "xy-ns": lambda _: np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]),
    "xy-ew": lambda _: np.array([[0, 1.0, 0], [0, 0, 1], [1, 0, 0]]),
}
#: The frame of each mount that is drawn.
FRAME = {"german": "equatorial", "fork": "equatorial", "xy-ns": "xy-ns", "xy-ew": "xy-ew"}


@dataclass(frozen=True)
class Flaws:
    """What is wrong; radians."""

    mount: Mount = field(default_factory=Mount)  #: in the frame of the first axis
    droop: float = 0.0  #: how far gravity pulls the tube down at the horizon
    fork: float = 0.0  #: how far a fork hangs down, in which the tube looks up
    tube_end: float = 0.0  #: how far the end of the second axis that carries the tube hangs down
    #: Zeros of both encoders, plus on one side of the pier and minus on the other.
    pier: tuple[Each, Each] = (0.0, 0.0)


def axes_of(kind: str, latitude: float, az: Array, el: Array) -> tuple[Array, Array]:
    """Return the two angles [rad] at which a faultless mount looks at directions, shape (n,)."""
    return az_el(direction(az, el) @ FRAMES[FRAME[kind]](latitude).T)


def offsets(
    kind: str, latitude: float, at: tuple[Array, Array], side: Array, flaws: Flaws
) -> Array:
    """Return readings less true angles on the sky (across, along) [rad], shape (n, 2).

    `kind`, `latitude`: which mount, and where it stands.
    `at`: azimuths and elevations that the beam is on, shape (n,) each.
    `side`: -1 where the mount has turned over, shape (n,). Its readings are turned back before they
      are compared.
    `flaws`: what is wrong.
    """
    az, el = at
    true_first, true_second = axes_of(kind, latitude, az, el)
    # a tube that hangs down looks at a place when it is aimed above it
    first, second = axes_of(kind, latitude, az, el + flaws.droop * np.cos(el))
    sent_first = np.where(side < 0, first + np.pi, first)
    sent_second = np.where(side < 0, np.pi - second, second)
    target = direction(first, second)
    bent = flaws.mount.plus(
        beam_down=-flaws.fork * np.cos(sent_first), beam_left=flaws.tube_end * np.sin(el)
    )
    axis_first, axis_second = sent_first.copy(), sent_second.copy()
    for _ in range(8):
        missed = target - beam(bent, axis_first, axis_second)
        ahead = missed[:, 0] * np.cos(axis_first) - missed[:, 1] * np.sin(axis_first)
        level = missed[:, 0] * np.sin(axis_first) + missed[:, 1] * np.cos(axis_first)
        rising = missed[:, 2] * np.cos(axis_second) - level * np.sin(axis_second)
        axis_first = axis_first + ahead / np.cos(axis_second)
        axis_second = axis_second + rising
    read_first, read_second = readings(bent, axis_first, axis_second)
    across = read_first + side * flaws.pier[0] - np.where(side < 0, true_first + np.pi, true_first)
    along = read_second + side * flaws.pier[1]
    along = along - np.where(side < 0, np.pi - true_second, true_second)
    return np.stack([across * np.cos(true_second), side * along], axis=1)


#: Cosine from which two traces beside the model are one.
ALIKE = 0.95
#: Harmonics of an encoder, or of an axis that nods.
HARMONICS = range(2, 9)
#: Steps of a place [rad] and of time [s] that slopes are taken from.
STEP_RAD, STEP_S = 1e-6, 10.0


@dataclass(frozen=True)
class Session:
    """Where a mount was pointed: its kind, the pointings, and -1 where it had turned over."""

    kind: str
    at: schedule.Pointings
    side: Array

    def shown(self, flaws: Flaws) -> Array:
        """Return what flaws do, flat (2 n,) [arcsec for flaws in arcsec]."""
        places = self.at.az, self.at.el
        return offsets(self.kind, self.at.latitude, places, self.side, flaws).ravel() / ARCSEC

    def axes(self, az: Array, el: Array) -> tuple[Array, Array]:
        """Return the angles of the axes for directions."""
        return axes_of(self.kind, self.at.latitude, az, el)

    def moved(self, az: Array, el: Array, step: float) -> Array:
        """Return by how much the axes move from the pointings to other places, per step, (2 n,)."""
        here, there = self.axes(self.at.az, self.at.el), self.axes(az, el)
        across = wrap(there[0] - here[0]) * np.cos(here[1])
        return (np.stack([across, there[1] - here[1]], axis=1) / step).ravel()

    @property
    def rates(self) -> Array:
        """Return how fast both axes follow a star, across and along, (n, 2)."""
        at = self.at
        later = schedule.horizontal(at.ra, at.dec, at.time_s + STEP_S, at.latitude, at.longitude)
        now = schedule.horizontal(at.ra, at.dec, at.time_s, at.latitude, at.longitude)
        return (self.moved(*later, STEP_S) - self.moved(*now, STEP_S)).reshape(-1, 2)


def alike(hidden: Array, base: Array, session: Session) -> tuple[str, ...]:
    """Return the names that some recordings cannot tell from a hidden trace.

    `hidden`: the trace, flat (2 n,).
    `base`: what is fitted beside it, (2 n, p).
    `session`: where it was recorded.
    """
    basis = np.linalg.qr(base)[0]

    def left(columns: Array) -> Array:
        return np.asarray(columns - basis @ (basis.T @ columns))

    seen = left(hidden)
    found = []
    for name, members in _names(session).items():
        shares = [_share(seen, left(np.stack(one, axis=1))) for one in members]
        if max(shares) > ALIKE:
            found.append(name)
    return tuple(found)


def _share(seen: Array, columns: Array) -> float:
    """Return the cosine between a trace and the nearest one of some columns."""
    length = np.linalg.norm(columns, axis=0)
    kept = length > STEP_RAD * length.max(initial=0.0)
    if not kept.any():
        return 0.0
    basis = np.linalg.qr(columns[:, kept] / length[kept])[0]
    return float(np.linalg.norm(basis.T @ seen) / np.linalg.norm(seen))


def _names(session: Session) -> dict[str, list[list[Array]]]:
    """Return the columns of every member of every name that is drawn, by what it is called."""
    first, second = ("x", "y") if session.kind.startswith("xy") else ("hour_angle", "declination")

    def mount(**parts: float) -> Array:
        return session.shown(Flaws(Mount(**{k: ARCSEC * v for k, v in parts.items()})))  # type: ignore[arg-type]

    def wave(on: str, of: str, k: int) -> list[Array]:
        both = ((ARCSEC, 0.0), (0.0, ARCSEC))
        return [
            session.shown(Flaws(Mount(waves=(Wave(on, of, k, *one),))))  # type: ignore[arg-type]
            for one in both
        ]

    lean = "x_axis_tilt" if first == "x" else "polar_axis"
    found = {
        lean: [[mount(tilt_north=1.0), mount(tilt_east=1.0)]],
        "sag_cosine": [[session.shown(Flaws(droop=ARCSEC))]],
        f"{first}_scale": [[mount(azimuth_scale=1.0)]],
        f"{second}_scale": [[mount(elevation_scale=1.0)]],
        f"{first}_eccentricity": [wave("az", "az", 1)],
        f"{first}_harmonics": [wave("az", "az", k) for k in HARMONICS],
        f"{second}_harmonics": [wave("el", "az", k) for k in HARMONICS],
        f"{second}_encoder_harmonics": [wave("el", "el", k) for k in HARMONICS],
        **_of_the_sky(session, first, second),
    }
    if first == "hour_angle":
        found["fork_flexure"] = [[session.shown(Flaws(fork=ARCSEC))]]
        found["declination_axis_flexure"] = [[session.shown(Flaws(tube_end=ARCSEC))]]
    if np.ptp(session.side):
        zeros = ((ARCSEC, 0.0), (0.0, ARCSEC))
        found["pier_flip"] = [[session.shown(Flaws(pier=one)) for one in zeros]]
    return found


def _of_the_sky(session: Session, first: str, second: str) -> dict[str, list[list[Array]]]:
    """Return what the sky, the site and the clock do, and axes that follow too late."""
    at, rates = session.at, session.rates
    around = np.sign(rates)

    def one_axis(values: Array, axis: int) -> list[list[Array]]:
        return [[(values * np.eye(2)[axis]).ravel()]]

    def of_site(latitude: float, longitude: float) -> list[list[Array]]:
        places = [
            schedule.horizontal(at.ra, at.dec, at.time_s, at.latitude + a, at.longitude + b)
            for a, b in ((latitude, longitude), (0.0, 0.0))
        ]
        return [[session.moved(*places[0], STEP_RAD) - session.moved(*places[1], STEP_RAD)]]

    risen = at.el + STEP_RAD / np.tan(at.el)
    return {
        "clock": of_site(0.0, STEP_RAD),
        "site_longitude": of_site(0.0, STEP_RAD),
        "site_latitude": of_site(STEP_RAD, 0.0),
        "refraction": [[session.moved(at.az, risen, STEP_RAD)]],
        f"servo_lag_{first}": one_axis(rates, 0),
        f"servo_lag_{second}": one_axis(rates, 1),
        f"backlash_{first}": one_axis(around, 0),
        f"backlash_{second}": one_axis(around, 1),
    }
