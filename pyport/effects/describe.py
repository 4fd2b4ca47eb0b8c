"""The catalogue in words: for the terminal, and as the document on its physics."""

from __future__ import annotations

import difflib
import textwrap
from collections.abc import Sequence
from types import ModuleType

from pyport.effects import CATALOGUE, FAMILIES, Effect, catalogue
from pyport.effects.base import Coefficient
from pyport.effects.degeneracies import USUAL, WHERE, Alike, alike
from pyport.effects.mounts import MOUNTS, on, said
from pyport.errors import BadInput
from pyport.mounts import ALTAZ, Mount

_SHARED = {
    "array": "the same for all antennas",
    "session": "the same for all antennas within a session",
    "antenna": "each antenna has its own",
}

_PREFACE = """\
# Physics: the catalogue of effects

An effect is one physical cause of a pointing offset. It adds an offset to every recorded position
that is linear in a few coefficients. Models are lists of effects, and a diagnosis searches them.

A is the azimuth from north through east, E the elevation, phi the latitude, q the parallactic
angle, H the hour angle, positive west. x is the offset across, dA cos E, and y the offset along
elevation; both are encoder minus true: what must be added to the true position to get where the
telescope must be driven. Coefficients are in arcseconds unless another unit is given.

What looks like an effect is listed with the circumstances under which it does; the usual terms are
those of the model `altaz`. Both are held to the curves themselves by tests.
"""


def listing(names: Sequence[str] = (), mount: Mount = ALTAZ) -> str:
    """Return some effects, by default all, as text for a terminal, in the words of a mount.

    Raises `BadInput`: there is no effect of such a name.
    """
    return "\n".join(_paragraph(effect, mount) for effect in _called(names, mount))


def entries(names: Sequence[str] = (), mount: Mount = ALTAZ) -> list[dict[str, object]]:
    """Return some effects, by default all, for other programs, in the words of a mount.

    Raises `BadInput`: there is no effect of such a name.
    """
    return [
        {
            "id": effect.id,
            "sentence": effect.sentence,
            "pattern": effect.pattern,
            "means": dict(effect.means),
            "x": effect.formula[0],
            "y": effect.formula[1],
            "needs": list(effect.needs),
            "coefficients": [
                {"name": one.name, "unit": one.unit, "expected": one.expected}
                for one in effect.coefficients
            ],
            "shared": effect.common,
            "physical": effect.physical,
            "looks_like": [
                {"effect": other, "where": WHERE[how.where], "decide_by": decide}
                for other, how, decide in _alike(effect, mount)
            ],
            "source": effect.citation,
        }
        for effect in _called(names, mount)
    ]


def _called(names: Sequence[str], mount: Mount) -> list[Effect]:
    """Return the effects of some names on a mount, all of them for none."""
    there = catalogue(mount)
    for name in names:
        if name not in there:
            near = difflib.get_close_matches(name, there)
            meant = f"; did you mean {' or '.join(near)}?" if near else ""
            raise BadInput(f"no effect is called {name!r}{meant}")
    return [there[name] for name in names or there]


def _alike(effect: Effect, mount: Mount) -> list[tuple[str, Alike, str]]:
    """Return what an effect looks like on a mount, how, and what decides, in its words."""
    return [
        (
            on(CATALOGUE[other], mount).id if other in CATALOGUE else other,
            how,
            said(how.decide, mount.words),
        )
        for other, how in alike(effect.on_altaz, mount)
    ]


def _paragraph(effect: Effect, mount: Mount) -> str:
    lines = [
        f"{effect.id}: {effect.sentence}",
        *(f"{name}: {text}" for name, text in _facts(effect, mount)),
    ]
    wrapped = [textwrap.fill(line, 92, subsequent_indent="    ") for line in lines]
    return wrapped[0] + "\n" + textwrap.indent("\n".join(wrapped[1:]), "  ") + "\n"


def _facts(effect: Effect, mount: Mount = ALTAZ) -> list[tuple[str, str]]:
    """Return what there is to say of an effect, with a word for each."""
    facts = [(axis, formula) for axis, formula in zip("xy", effect.formula, strict=True) if formula]
    if effect.pattern:
        facts.insert(0, ("shows", effect.pattern))
    facts += [("on", f"{MOUNTS[kind]}: {cause}") for kind, cause in effect.means.items()]
    facts.append(("needs", ", ".join(effect.needs) or "nothing but the position"))
    coefficients = ", ".join(map(_coefficient, effect.coefficients))
    facts.append(("coefficients", coefficients or "as many as the recordings call for"))
    facts.append(("shared", _SHARED[effect.common]))
    if effect.profile is not None:
        example = f", such as {effect.variant}" if effect.variant else ""
        facts.append(("family", f"several members are tried{example}"))
    if not effect.physical:
        facts.append(("use", "a term of models; never named by a diagnosis"))
    facts += [
        (
            "looks exactly like" if how.exact else "looks nearly like",
            _likeness(other, how, decide, mount),
        )
        for other, how, decide in _alike(effect, mount)
    ]
    facts.append(("source", effect.citation))
    return facts


def _coefficient(one: Coefficient) -> str:
    name = one.name if one.unit == "arcsec" else f"{one.name} [{one.unit or 'share'}]"
    return name if one.expected is None else f"{name}, expected {one.expected:g}"


def _likeness(other: str, how: Alike, decide: str, mount: Mount) -> str:
    names = " and ".join(on(CATALOGUE[one], mount).id for one in how.beside)
    terms = "the usual terms" if how.beside == USUAL else names
    beside = f", with {terms} fitted too" if how.beside else ""
    return f"{other}, {WHERE[how.where]}{beside}; to decide, {decide}"


def markdown() -> str:
    """Return the document on the physics: the catalogue family by family."""
    families = [(_title(family), family.EFFECTS) for family in FAMILIES]
    shipped = {effect.id for _, effects in families for effect in effects}
    added = [effect for name, effect in CATALOGUE.items() if name not in shipped]
    if added:
        families.append(("Registered while the program ran", added))
    return "\n".join([_PREFACE, *(_section(*family) for family in families)])


def _title(family: ModuleType) -> str:
    return (family.__doc__ or "").strip().splitlines()[0].rstrip(".")


def _section(title: str, effects: Sequence[Effect]) -> str:
    return "\n".join([f"## {title}\n", *(_entry(effect) for effect in effects)])


def _entry(effect: Effect) -> str:
    sentence = effect.sentence[0].upper() + effect.sentence[1:]
    lines = [f"### `{effect.id}`\n", f"{sentence}.\n"]
    for name, text in _facts(effect):
        shown = f"`{text}`" if name in ("x", "y") else text
        lines.append(textwrap.fill(f"- {name}: {shown}", 100, subsequent_indent="  "))
    return "\n".join(lines) + "\n"
