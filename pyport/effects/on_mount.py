"""Effects in the words of a mount: what turns about azimuth there may turn about the hour angle.

What an effect does is not changed by this: `Effect.columns` asks the circumstances for the mount.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from dataclasses import replace

from pyport.effects.base import SKY, Effect
from pyport.mounts import ALTAZ, Mount

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
