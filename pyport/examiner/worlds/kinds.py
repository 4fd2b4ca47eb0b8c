"""Every kind of case by its name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass, fields, replace
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.errors import BadInput
from pyport.examiner.real.injected import CAUSES, injected
from pyport.examiner.worlds import observatories
from pyport.examiner.worlds.campaign import (
    NOISES,
    SKIES,
    campaign,
    gappy_campaign,
    usual_mount,
    usual_noise,
)
from pyport.examiner.worlds.case import LITTLE, Case, Streams, finish, hide
from pyport.examiner.worlds.earth import SITES, Site
from pyport.examiner.worlds.faults import ALL, CATALOGUED, SWALLOWED, TOO_SMALL, UNKNOWN
from pyport.examiner.worlds.mount import BASE, CLASSICAL, Each, Mount, Stand, Wave
from pyport.examiner.worlds.rt32_campaign import rt32_campaign
from pyport.examiner.worlds.schedule import Plan, for_antennas, take
from pyport.examiner.worlds.sky import STEPS
from pyport.examiner.worlds.twins import TWINS, twins
from pyport.examiner.worlds.world import World, believed

#: Causes that can be hidden behind the altaz base, each by its own name.
HIDEABLE = tuple(name for name in CATALOGUED if name not in SWALLOWED + TOO_SMALL)

#: Kinds of cases and what each hides.
KINDS = {
    "null": "nothing",
    "one": "one cause behind the base",
    "two": "two catalogued causes at once",
    "three": "three of them",
    "array": "a cause in some antennas of an array",
    "held": "one catalogued cause, the model held rather than refitted",
    "unknown": "a cause that no catalogue names",
    "degenerate": "a cause that the plan makes the twin of another",
    "ablation": "steps of the reduction that the RT32's steering left out",
    "rt32": "p8 to p12 of the RT32's published model, the jump among them",
    "rt32-campaign": "nothing: all of the RT32's published model, its bad rows, its moved beam",
    "real": "nothing, or one cause, in the noise of real recordings",
    "gmrt": "site, scan timing and play of an array whose steering knows one place",
}


#: Models beside `altaz`: the terms that they have besides, what is asked of the program, and files.
_WAVES = tuple(
    Mount(waves=(Wave("el", "az", 2, *part),)) for part in ((ARCSEC, 0.0), (0.0, ARCSEC))
)
_CENTRE = (Mount(centre_right=ARCSEC), Mount(centre_ahead=ARCSEC))
_TERMS = ("IA", "IE", "CA", "NPAE", "AN", "AW", "TF", "ECES", "ACES", "ACEC")
MODELS: dict[str, tuple[tuple[Mount, ...], str]] = {
    "tpoint.mod": (
        (Mount(sag_sine=ARCSEC), *_CENTRE),
        "a telescope\nT 100 10.0 0.0 0.0\n"
        + "".join(f"  {name} +0.0 1.0\n" for name in _TERMS)
        + "END\n",
    ),
    "mdlpo.ctl": (
        (Mount(sag_sine=ARCSEC), *_WAVES),
        "  1 2004 100 00 00 00\n 90.0 1 0 1 1 1 1 1 1 0 0 1 0 0 0 1 1 0 0 0 0\n"
        + 4 * " 0.0 0.0 0.0 0.0 0.0\n",
    ),
    "rt32-3model": ((), ""),
}


def files_of(arguments: Sequence[str]) -> dict[str, str]:
    """Return the files that a solver's arguments name: the texts of models, by name."""
    return {one: MODELS[one][1] for one in arguments if one in MODELS and MODELS[one][1]}


#: Kinds of mounts besides alt-azimuth, and what may be wrong with each that shows on it.
_ANY = ("sag_sine", "refraction", "epoch_offset", "elevation_encoder_harmonics")
_EQUATORIAL = (*_ANY, "azimuth_harmonics", "elevation_harmonics", "declination_axis_flexure")
STANDS: dict[str, tuple[str, ...]] = {
    "german": (*_EQUATORIAL, "pier_flip"),
    "fork": (*_EQUATORIAL, "fork_flexure"),
    "xy-ns": (*_ANY, "temperature", "source_position"),
    "xy-ew": (*_ANY, "temperature", "source_position"),
}
#: A German mount is used on both of its sides so far from the meridian [rad].
OVERLAP = 20 * DEG
#: No source is observed so near to the first axis [rad].
KEYHOLE = 12 * DEG
#: Antennas of an array of which some have what the others have not.
ANTENNAS = 6


#: Observatories of which nothing is drawn but the noise.
_WHOLE: dict[str, Callable[..., Case]] = {
    "rt32": observatories.rt32,
    "rt32-campaign": rt32_campaign,
    "gmrt": observatories.gmrt,
}


@dataclass(frozen=True)
class Spec:
    """One case before its seed is drawn: which row of the table it is for, and what to make.

    `group`: which rows of the score it is for.
    `kind`: one of `KINDS`.
    `effect`: what is hidden, drawn when not given: a cause by its name, several of them or the
      steps left out of an ablation with plus signs between, a twin for "degenerate".
    `rho`: rms of what the base leaves of the cause over the noise, on the axis where it is greater.
      Where nature gives the size of the cause the noise is scaled to it.
    `rows`: number of recordings, 1200 (the RT32's: 5615) when not given.
    `noise`: one of `NOISES`; drawn for "null", "white" or "drift" for others when not given.
    `weeks`: length of an ablation's campaign; the RT32's own two when not given.
    `site`, `sky`, `mount`, `model`, `little`: of `earth.SITES`, `SKIES`, `STANDS`, `MODELS` and
      `LITTLE` (what the file has); drawn, radio sources, alt-azimuth, the classical terms and
      everything when not given.
    `real`, `data`: the set of recordings whose noise it is, and the folder of those that are not
      shipped.
    """

    group: str
    kind: str
    effect: str | None = None
    rho: float = 0.5
    rows: int | None = None
    noise: str | None = None
    weeks: float | None = None
    site: str | None = None
    sky: str | None = None
    mount: str | None = None
    model: str | None = None
    little: str | None = None
    real: str | None = None
    data: str | None = None

    def make(self, seed: int) -> Case:
        """Make the case; the same seed gives the same case.

        Plan, mount, cause and noise are drawn each from a stream of its own, so that cases of one
        seed differ in what they hide alone.
        """
        _check(self)
        some = {} if self.rows is None else {"rows": self.rows}
        if self.kind == "real":
            return injected(seed, str(self.real), self.effect, self.rho, self.data)
        if self.kind in _WHOLE:
            return _WHOLE[self.kind](seed, **some)
        if self.kind == "ablation":
            steps = tuple(self.effect.split("+")) if self.effect else observatories.RT32_LEFT_OUT
            return observatories.ablation(seed, steps, self.weeks, **some)
        if self.kind == "degenerate":
            return twins(seed, self.effect, self.rho, **some)
        return _hidden(seed, self)

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self)


def make_case(kind: str, seed: int, **asked: Any) -> Case:  # noqa: ANN401 - fields of `Spec`
    """Make a case of a kind."""
    return Spec(kind, kind, **asked).make(seed)


def _check(ask: Spec) -> None:
    """Raise `BadInput` for a name that is not known."""
    effects = {
        "degenerate": tuple(TWINS),
        "ablation": tuple(sorted(STEPS)),
        "real": tuple(CAUSES),
    }.get(ask.kind, tuple(ALL))
    asked = [
        ("kind", ask.kind, tuple(KINDS)),
        *(("effect", one, effects) for one in (ask.effect.split("+") if ask.effect else ())),
        ("noise", ask.noise, NOISES),
        ("site", ask.site, tuple(SITES)),
        ("sky", ask.sky, SKIES),
        ("mount", ask.mount, tuple(STANDS)),
        ("model", ask.model, tuple(MODELS)),
        ("little", ask.little, tuple(LITTLE)),
    ]
    for what, name, known in asked:
        if name is not None and name not in known:
            raise BadInput(f"no {what} is called {name!r}: expected one of {', '.join(known)}")


def _hidden(seed: int, ask: Spec) -> Case:
    streams, kind = Streams.of(seed), ask.kind
    noise_kind = ask.noise or str(streams.noise.choice(NOISES if kind == "null" else NOISES[:2]))
    held = kind == "held"
    world, arguments = _world(ask, streams, noise_kind)
    names = _names(ask, streams.fault)
    faults = [ALL[name](world, streams.fault) for name in names]
    if ask.mount:
        faults = [replace(one, effect=called(one.effect, ask.mount)) for one in faults]
    noise = usual_noise(streams.noise, noise_kind)
    hidden = hide(world, faults, ask.rho, noise, projected=not held)
    about = {
        "kind": kind,
        "seed": seed,
        "asked": "+".join(names),
        "rho": ask.rho,
        "noise_kind": noise_kind,
    }
    return finish(
        hidden,
        streams,
        about,
        azimuth_zero="south" if ask.model == "rt32-3model" else "north",
        arguments=arguments,
        little=ask.little,
    )


def _world(ask: Spec, streams: Streams, noise_kind: str) -> tuple[World, tuple[str, ...]]:
    """Return a telescope at work with nothing hidden, and what the solver is to be asked."""
    rows = ask.rows or 1200
    if ask.model == "rt32-3model":
        plan = observatories.rt32_plan(streams.plan, rows)
        return observatories.rt32_whole(plan), ("--model", ask.model)
    lay = gappy_campaign if noise_kind == "gappy" else campaign
    sky = ask.sky or "radio"
    if ask.kind == "array":
        names = [f"A{n + 1}" for n in range(ANTENNAS)]
        plan = lay(streams.plan, rows // ANTENNAS, ask.site, sky)
        place = (np.full(ANTENNAS, one) for one in astuple(plan.site))
        plan = for_antennas(plan, names, Site(*place))
        antenna = np.searchsorted(names, plan.labels["antenna"])
        mounts = [usual_mount(streams.mount) for _ in names]
        parts = {
            one: np.array([getattr(each, one) for each in mounts])[antenna] for one in CLASSICAL
        }
        return World(plan, mount=Mount().plus(**parts)), ()
    if ask.kind == "held":
        held = ("--model", "none", "--refit", "none")
        return World(lay(streams.plan, rows, ask.site, sky)), held
    mount = usual_mount(streams.mount)
    if ask.mount:
        plan, stand = _stood(
            streams.plan, lay(streams.plan, 2 * rows, ask.site, sky), ask.mount, rows
        )
        return World(plan, mount=mount, stand=stand), ()
    plan = lay(streams.plan, rows, ask.site, sky)
    if ask.model is None:
        return World(plan, mount=mount), ()
    more, _ = MODELS[ask.model]
    world = World(plan, mount=mount, base=(*BASE, *more))
    for one in more:
        world = replace(world, mount=_added(world.mount, one, float(30 * streams.mount.normal())))
    return world, ("--model", ask.model)


def _added(mount: Mount, term: Mount, size: float) -> Mount:
    """Return a mount with a term of a base in it, so many times as large."""
    parts = {
        one.name: size * getattr(term, one.name) for one in fields(term) if one.name != "waves"
    }
    waves = [replace(one, sine=size * one.sine, cosine=size * one.cosine) for one in term.waves]
    return mount.plus(*waves, **parts)


def _stood(rng: np.random.Generator, plan: Plan, kind: str, rows: int) -> tuple[Plan, Stand]:
    """Return what a mount reaches of a plan, so many rows of it, and how it stands there."""
    place = believed(World(plan))
    first, second = Stand(kind, float(plan.reference.latitude)).angles(place.az, place.el)
    reached = rng.permutation(np.flatnonzero(np.cos(second) > np.sin(KEYHOLE)))[:rows]
    kept = np.sort(reached)
    side: Each = 1.0
    if kind == "german":
        either = (np.abs(first) < OVERLAP) & (rng.random(len(first)) < 0.5)
        side = np.where((first > 0) != either, 1.0, -1.0)[kept]
    return take(plan, kept), Stand(kind, float(plan.reference.latitude), side)


def called(effect: str, mount: str) -> str:
    """Return what an effect of an alt-azimuth mount is called on another one."""
    axes = ("x", "y") if mount.startswith("xy") else ("hour_angle", "declination")
    for own, other in zip(("azimuth", "elevation"), axes, strict=True):
        effect = effect.replace(own, other)
    return effect


def _names(ask: Spec, rng: np.random.Generator) -> list[str]:
    kind = ask.kind
    if kind == "null":
        return []
    if ask.effect is not None:
        return ask.effect.split("+")
    if kind in ("two", "three"):
        return [str(name) for name in rng.choice(HIDEABLE, 2 + (kind == "three"), replace=False)]
    choices = {"held": SWALLOWED, "unknown": UNKNOWN, "array": ("some_antennas",)}.get(
        kind, STANDS.get(ask.mount or "", HIDEABLE)
    )
    return [str(rng.choice(choices))]
