"""Equatorial mounts: forks, declination axes and piers; effects in the words of any mount.

Words change nothing of what an effect does: `Effect.columns` asks the circumstances for the mount.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.effects.base import (
    AXES,
    OVER,
    PIER_SIDE,
    SKY,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.mounts import ALTAZ, Mount

#: The header key, and the words that may stand there, several with commas between.
MOUNT = "mount"
MOUNTS = {
    "wheel-and-track": "a wheel-and-track mount",
    "bearing": "a mount on an azimuth bearing",
    "nasmyth": "a telescope with Nasmyth platforms",
    "secondary": "a telescope with a moving secondary mirror",
    "receiver-boxes": "a telescope with receiver boxes",
    "cable-wrap": "a mount with a cable wrap",
}


def declared(meta: Mapping[str, str]) -> tuple[str, ...]:
    """Return what a header declares of the mount, in its order; nothing where it is silent."""
    words = meta.get(MOUNT, "").lower().replace(",", " ").split()
    return tuple(dict.fromkeys(words))


def meaning(effect: Effect, mounts: tuple[str, ...]) -> str:
    """Return what an effect means: in general, and on the mount that was declared.

    Where nothing was declared, what it would mean on each kind of mount that it concerns.
    """
    on = [(MOUNTS[one], effect.means[one]) for one in mounts if one in effect.means]
    if on:
        more = [f"on {mount}: {cause}" for mount, cause in on]
    elif mounts:
        more = []
    else:
        more = [f"on {MOUNTS[one]} it may be {cause}" for one, cause in effect.means.items()]
    return "; ".join([effect.sentence, *more])


def times(k: float) -> str:
    """Return how often in words: once, twice, three times, ..."""
    words: dict[float, str] = {
        1: "once",
        2: "twice",
        3: "three times",
        4: "four times",
        5: "five times",
    }
    return words.get(k, f"{k:.5g} times")


#: Letters of the axes in a formula, also behind a multiple and in a rate.
_LETTER = re.compile(r"(?<![A-Za-z])([kd]?)([AE])(?![A-Za-z0-9'_])")


def on(effect: Effect, mount: Mount) -> Effect:
    """Return an effect in the words of a mount; the sky's has one for all."""
    if mount is ALTAZ or effect.of or effect.mounts == (mount.model,) or effect.acts_in == SKY:
        return effect
    say = functools.partial(said, words=mount.words)
    return replace(
        effect,
        id=_named(effect.id, mount),
        of=effect.id,
        sentence=say(effect.sentence),
        variant=say(effect.variant),
        pattern=say(effect.pattern),
        formula=(_lettered(effect.formula[0], mount), _lettered(effect.formula[1], mount)),
        coefficients=tuple(
            replace(one, name=_coefficient(one.name, mount)) for one in effect.coefficients
        ),
        means={},
        mounts=(mount.model,),
        profile=effect.profile
        and (lambda at: tuple(on(one, mount) for one in effect.variants(at))),
        make=effect.make and _made(effect.make, mount),
    )


def _made(make: Callable[..., Effect], mount: Mount) -> Callable[..., Effect]:
    return lambda **member: on(make(**member), mount)


def said(text: str, words: Mapping[str, str]) -> str:
    """Return a text with the words of another mount, the longest that fits at each place."""
    longest = sorted(words, key=len, reverse=True)
    if not longest:
        return text
    return re.sub(rf"\b({'|'.join(longest)})\b", lambda found: words[found[1]], text)


def _named(name: str, mount: Mount) -> str:
    return said(name.replace("_", " "), mount.words).replace(" ", "_").lower()


def _coefficient(name: str, mount: Mount) -> str:
    """Return the name of a coefficient, unless it is another program's (`IH`, `P1`).

    What stands in brackets is a label of the recordings.
    """
    bare, bracket, label = name.partition("[")
    if not bare.islower():
        return name
    axes = {"xel": mount.across_column, "az": mount.first.offset, "el": mount.second.offset}
    short = {word: column.removeprefix("d_") for word, column in axes.items()}
    words = {**mount.words, **short}
    return said(bare.replace("_", " "), words).replace(" ", "_").lower() + bracket + label


def _lettered(formula: str, mount: Mount) -> str:
    letters = {"A": mount.first.symbol, "E": mount.second.symbol}
    text = _LETTER.sub(lambda found: found[1] + letters[found[2]], formula)
    return said(text, mount.words)


def concerns(effect: Effect, mount: Mount) -> bool:
    """Tell whether an effect can act on a mount."""
    return not effect.mounts or mount.model in effect.mounts


_TPOINT = "Wallace, TPOINT Telescope Pointing Analysis System, standard equatorial terms"
_MOUNTS = ("equatorial",)


def fork_flexure(at: Circumstances) -> tuple[Array, Array]:
    """Return -f cos H along declination: a fork hangs down, and its tube looks up at the pole."""
    return stack(at, (0, -np.cos(at.az)))


def declination_axis_flexure(at: Circumstances) -> tuple[Array, Array]:
    """Return d sin E across: the end of the declination axis that carries the tube hangs down."""
    where = at if at.sky is None else at.sky
    return stack(at, (np.sin(where.el), 0))


def pier_flip(at: Circumstances) -> tuple[Array, Array]:
    """Return zeros of both encoders that differ by twice this between the sides of the pier.

    One that changes sign with the side in the angles of the axes does not so on the sky: the
    declination axis then counts in the opposite sense.
    """
    side = np.where(at.column(PIER_SIDE) == OVER, -1.0, 1.0)
    return stack(at, (side * np.cos(at.el), 0), (0, side))


def _flips(at: Circumstances) -> tuple[Effect, ...]:
    """Return the flip where it may be looked for: on one side it is the zeros."""
    if len(np.unique(at.column(PIER_SIDE) == OVER)) < 2:
        raise MissingColumn("both sides of the pier")
    return (EFFECTS[-1],)


EFFECTS = (
    Effect(
        "fork_flexure",
        "the fork, or what else carries the declination axis, bends under the weight of the tube",
        _TPOINT,
        (Coefficient("fork_flexure"),),
        fork_flexure,
        formula=("", "-f cos H"),
        acts_in=AXES,
        mounts=_MOUNTS,
        pattern="in declination, with the cosine of hour angle",
    ),
    Effect(
        "declination_axis_flexure",
        "the declination axis bends under the weight of the tube",
        _TPOINT,
        (Coefficient("declination_axis_flexure"),),
        declination_axis_flexure,
        needs=("latitude_deg",),
        formula=("d sin E = d (sin phi sin D + cos phi cos D cos H)", ""),
        acts_in=AXES,
        mounts=_MOUNTS,
        pattern="in cross-declination, with the sine of elevation",
    ),
    Effect(
        "pier_flip",
        "the zeros of the encoders change when the mount turns over its pier",
        _TPOINT,
        (Coefficient("pier_flip_hour_angle"), Coefficient("pier_flip_declination")),
        pier_flip,
        profile=_flips,
        needs=("pier_side",),
        formula=("+-a cos D", "b, the sign by the side of the pier"),
        acts_in=AXES,
        mounts=_MOUNTS,
        pattern="opposite in hour angle on the two sides of the pier, and a constant in "
        "declination that is the same on both",
    ),
)
