"""Kinds of mounts and fittings that a file may declare, and what effects mean on them."""

from __future__ import annotations

from collections.abc import Mapping

from pyport.effects.base import Effect

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


def unknown(meta: Mapping[str, str]) -> tuple[str, ...]:
    """Return the words of a header that are no kind of mount."""
    return tuple(word for word in declared(meta) if word not in MOUNTS)


def meaning(effect: Effect, mounts: tuple[str, ...] = ()) -> str:
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


def times(k: int) -> str:
    """Return how often in words: once, twice, three times, ..."""
    words = {1: "once", 2: "twice", 3: "three times", 4: "four times", 5: "five times"}
    return words.get(k, f"{k} times")
