"""Members of families as files hold them: from an effect's id and a few numbers, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.columns import LABELS
from pyport.effects import Circumstances, Effect, MissingColumn, Site, catalogue, known
from pyport.effects.base import Basis, stack
from pyport.effects.empirical.fields import UNKNOWN, field
from pyport.errors import BadInput

#: Columns that differ by no more than this share are the same ones.
SAME = 1e-12

#: Members that are terms of another program or parameters of the RT32.
_NUMBERED = frozenset({"word", "rt32"})

#: Azimuths and elevations [rad] at which effects that a file tells of are tried.
_TRIED = ((0.1, 0.2), (2.0, 0.8), (4.0, 1.4))


def effect_of(identity: str, member: Mapping[str, Any]) -> Effect:
    """Return the effect that an id and what distinguishes its member stand for.

    Raises `BadInput`: there is no such effect, or the member is none of it.
    """
    given = dict(member)
    column = given.pop("coefficient", None)
    try:
        effect = _whole(identity, given)
        if given and not _NUMBERED & set(given):
            _try(effect)
        if column is not None:
            effect = apart(effect)[column]
    except BadInput:
        raise
    except (TypeError, ArithmeticError, ValueError, LookupError, AttributeError) as error:
        wrong = f"{identity}: {given!r:.80} tells no member of it ({error})"
        raise BadInput(wrong) from None
    return effect


def _whole(identity: str, given: Mapping[str, Any]) -> Effect:
    if "word" in given:
        from pyport.models.terms.words import Word

        return Word.of_member(given).effect()
    if "rt32" in given:
        from pyport.models.model import rt32_parameter

        return rt32_parameter(int(given["rt32"]))
    if identity == UNKNOWN:
        return field(**given)
    effect = known(identity)
    if effect is None:
        raise BadInput(f"no effect is called {identity!r}")
    if not given:
        return effect
    if effect.make is None:
        raise BadInput(f"{identity} is no family, expected no member")
    return effect.make(**given)


class _Everything(dict[str, NDArray[Any]]):
    """A column for whatever name: what an effect may ask for, to try it."""

    def __missing__(self, name: str) -> NDArray[Any]:
        """Return numbers, or labels where the contract has labels."""
        return np.full(len(_TRIED), "") if name in LABELS else np.ones(len(_TRIED))


def _try(effect: Effect) -> None:
    """Raise ValueError where an effect that a file tells of has no columns, or no numbers in them.

    Its basis is not looked at before it is used, which may be long after the file was read.
    """
    az, el = np.array(_TRIED).T
    at = Circumstances(az, el, Site(0.9, 0.3), _Everything())
    try:
        found = np.concatenate(effect.columns(at))
    except MissingColumn:  # which of several it takes is seen when it is used
        return
    if found.shape != (2 * len(_TRIED), len(effect.coefficients)) or not np.isfinite(found).all():
        raise ValueError("expected a number for each coefficient, wherever one looks")
    if not all(isinstance(one, str) for one in effect.needs):
        raise ValueError("expected names of columns")


def apart(effect: Effect) -> list[Effect]:
    """Return an effect for each coefficient of one."""
    if len(effect.coefficients) <= 1:
        return [effect]
    return [
        replace(
            effect,
            coefficients=(coefficient,),
            basis=_column(effect, n),
            profile=None,
            acts_in="",
            member={**effect.member, "coefficient": n},
        )
        for n, coefficient in enumerate(effect.coefficients)
    ]


def _column(effect: Effect, n: int) -> Basis:

    def basis(at: Circumstances) -> tuple[Array, Array]:
        x, y = effect.columns(at)
        return stack(at, (x[:, n], y[:, n]))

    return basis


def frozen(effect: Effect, at: Circumstances) -> Effect:
    """Return an effect as it acts in some recordings, so that it acts so in any others.

    A mean temperature, a span of time, the names of sessions are those of these recordings.

    Raises `BadInput`: a file could not hold it: what it gives back differs.
    """
    given = dict(effect.member)
    column = given.pop("coefficient", None)
    if column is not None:
        whole = frozen(_whole(effect.id, given), at)
        return apart(whole)[column]
    family = catalogue(at.mount).get(effect.id) or known(effect.id)
    if family is not None and family.profile is not None and not _NUMBERED & set(given):
        for one in _members(family, at):
            if one.member and _same(one, effect, at):
                return one
    if not _same(effect_of(effect.id, effect.member), effect, at):
        raise BadInput(f"{effect.id} ({effect.variant}) cannot be kept in a file")
    return effect


def _members(effect: Effect, at: Circumstances) -> Sequence[Effect]:
    try:
        return effect.variants(at)
    except MissingColumn:
        return ()


def _same(one: Effect, other: Effect, at: Circumstances) -> bool:
    if one is other:
        return True
    if len(one.coefficients) != len(other.coefficients):
        return False
    mine, others = (np.concatenate(each.columns(at)) for each in (one, other))
    if mine.shape != others.shape:
        return False
    return bool(np.abs(mine - others).max(initial=0.0) <= SAME * np.abs(others).max(initial=0.0))
