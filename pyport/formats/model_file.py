"""A pointing model as a file has it: names, digits, and what is fixed; and as pyport has it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import partial
from typing import Any

from pyport.errors import BadInput
from pyport.models.complete import KEPT
from pyport.models.model import Model, Term
from pyport.models.terms import editing, field_system, tpoint
from pyport.models.terms.shapes import Shape
from pyport.models.terms.words import SCALES, Word
from pyport.mounts import BY_MODEL

#: How many decimals a number gets in another unit. Degrees with ten are given exactly by
#: arcseconds with eight, and arcseconds with eight come back from degrees with twelve.
DECIMALS = {"deg": 12, "arcsec": 8, "": 14}
_RADIAN_DEG = Decimal("57.295779513082320876798")
#: The elevation of the first axis of an alt-azimuth mount.
UPRIGHT_DEG = Decimal(90)

#: Vocabularies: name -> word, and shape -> name and sign.
WORDS: dict[str, Callable[[str], Word | None]] = {
    "tpoint": tpoint.word,
    "tpoint-equatorial": tpoint.polar_word,
    "field-system": field_system.word,
    "field-system-hadc": field_system.word_on_leaning,
    "field-system-xy": field_system.word_on_leaning,
    "katpoint": field_system.katpoint_word,
    "ska-mid": field_system.ska_mid_word,
}
NAMES: dict[str, Callable[[Shape], tuple[str, int] | None]] = {
    "tpoint": tpoint.name_of,
    "tpoint-equatorial": tpoint.polar_name_of,
    "field-system": field_system.name_of,
    "field-system-hadc": field_system.name_on_leaning,
    "field-system-xy": field_system.name_on_leaning,
    "katpoint": partial(field_system.name_of, last=field_system.KATPOINT_NUMBER),
    "ska-mid": field_system.ska_mid_name_of,
}

#: The vocabularies of mounts other than alt-azimuth ones, and the model of those.
MOUNT_OF = {
    "tpoint-equatorial": "equatorial",
    "field-system-hadc": "equatorial",
    "field-system-xy": "xy",
}


@dataclass(frozen=True)
class Entry:
    """A term of a model file."""

    name: str  #: in the file's vocabulary
    value: Decimal  #: digit for digit as the file has it, in `unit`
    unit: str  #: "arcsec", "deg", or "" for a ratio
    sigma: Decimal | None = None  #: one sigma, None where the file tells none
    fixed: bool = False  #: not to be fitted
    used: bool = True  #: false for a term that the model has switched off
    parallel: bool = False  #: TPOINT's `&`: applied beside the term before it, not after it
    formula: str = ""  #: of a user's term, as `formula.word` takes it


@dataclass(frozen=True)
class ModelFile:
    """A pointing model in a program's own vocabulary."""

    vocabulary: str  #: one of `WORDS`
    entries: tuple[Entry, ...]  #: its terms, in the file's order
    title: str = ""  #: the caption, "" without one
    phi_deg: Decimal = UPRIGHT_DEG  #: the Field System's: the elevation of the first axis
    #: What else the file holds, for writing it again.
    details: Mapping[str, Any] = field(default_factory=dict)

    def word(self, entry: Entry) -> Word:
        """Return what a term means.

        Raises `BadInput`: the vocabulary has no such term.
        """
        if entry.formula:
            return editing.formula_word(entry.name, entry.formula)
        if self.vocabulary.startswith("field-system") and self.phi_deg != UPRIGHT_DEG:
            word = field_system.word(entry.name, float(self.phi_deg))
        else:
            word = WORDS[self.vocabulary](entry.name)
        if word is None:
            raise BadInput(f"{entry.name!r} is no term that pyport knows of {self.vocabulary}")
        return word

    def model(self, name: str) -> Model:
        """Return the model with these values, each term fitted unless it is fixed.

        Raises `BadInput`: a term is used whose formula is not known.
        """
        details: dict[str, Any] = {
            key: float(one) for key, one in self.details.get("statistics", {}).items()
        }
        kept = {"title": self.title, **{key: self.details.get(key) for key in KEPT}}
        details |= {key: one for key, one in kept.items() if one}
        if self.phi_deg != UPRIGHT_DEG:
            details["phi_deg"] = float(self.phi_deg)
        model = Model(name, tuple(filter(None, map(self._term, self.entries))), details=details)
        of = MOUNT_OF.get(self.vocabulary)
        return model if of is None else model.on(BY_MODEL[of])

    def _term(self, entry: Entry) -> Term | None:
        word = self.word(entry)
        if not entry.used or word.silent or (not word.parts and entry.value == 0):
            return None
        if not word.parts:
            raise BadInput(f"{entry.name} has no published formula: its value must be 0")
        value = float(entry.value) * SCALES[entry.unit]
        return Term(word.effect(), values=(value,), fixed=entry.fixed)


def translated(file: ModelFile, vocabulary: str, *, leave_out: bool = False) -> ModelFile:
    """Return a model in another vocabulary.

    Terms that mean the same there are added up; switched-off ones are left out.

    Raises `BadInput`: terms have no counterpart, unless `leave_out`; the message names them.
    """
    if file.vocabulary == vocabulary:
        return file
    lost = without_counterpart(file, vocabulary)
    if lost and not leave_out:
        raise BadInput(
            f"{vocabulary} has no counterpart of {', '.join(lost)}: leave them out with --leave-out"
        )
    found: dict[str, Entry] = {}
    for entry in _counted(file):
        for name, weight in _counterparts(file, entry, vocabulary):
            one = _renamed(entry, name, weight, vocabulary)
            if (same := found.get(name)) is not None:  # their sum's sigma is not known
                value, fixed = same.value + one.value, same.fixed and one.fixed
                one = replace(same, value=value, sigma=None, fixed=fixed)
            found[name] = one
    return ModelFile(vocabulary, tuple(found.values()), file.title)


def without_counterpart(file: ModelFile, vocabulary: str) -> list[str]:
    """Return the terms that a vocabulary has no name for."""
    if file.vocabulary == vocabulary:
        return []
    return [entry.name for entry in _counted(file) if not _counterparts(file, entry, vocabulary)]


def _counted(file: ModelFile) -> list[Entry]:
    """Return the terms that a model has switched on, and that do something."""
    return [entry for entry in file.entries if entry.used and _acts(file.word(entry), entry)]


def _acts(word: Word, entry: Entry) -> bool:
    return bool(word.parts) or (entry.value != 0 and not word.silent)


def _counterparts(file: ModelFile, entry: Entry, vocabulary: str) -> list[tuple[str, float]]:
    """Return the names that together stand for a term, each with its weight; none without them."""
    found = [(names_of(shape, vocabulary), weight) for shape, weight in file.word(entry).parts]
    if not all(names for names, _ in found):
        return []
    return [(name, sign * weight) for names, weight in found for name, sign in names]


def names_of(shape: Shape, vocabulary: str) -> list[tuple[str, int]]:
    """Return the names that together stand for a shape, each with its sign; none without them."""
    name = NAMES[vocabulary](shape)
    if name is None:
        return []
    both = vocabulary in MOUNT_OF and name[0] in field_system.GRAVITY
    return [(one, name[1]) for one in (field_system.GRAVITY if both else (name[0],))]


def _renamed(entry: Entry, name: str, sign: float, vocabulary: str) -> Entry:
    """Return a term under another name, in the unit that it has there."""
    word = WORDS[vocabulary](name)
    if word is None:
        raise AssertionError(name)
    factor = Decimal(1) if sign == 1 else Decimal(repr(sign))
    sigma = None if entry.sigma is None else abs(in_unit(entry.sigma, entry.unit, word.unit))
    value = in_unit(entry.value, entry.unit, word.unit) * factor
    return replace(entry, name=name, value=value, unit=word.unit, sigma=sigma, formula="")


def in_unit(value: Decimal, unit: str, wanted: str) -> Decimal:
    """Return a number in another unit."""
    if unit == wanted:
        return value
    if not unit:
        value, unit = value * _RADIAN_DEG, "deg"
    degrees = value / 3600 if unit == "arcsec" else value
    found = {"deg": degrees, "arcsec": degrees * 3600, "": degrees / _RADIAN_DEG}[wanted]
    return rounded(found, DECIMALS[wanted])


def rounded(value: Decimal, decimals: int) -> Decimal:
    """Return a number with so many decimals, and without the zeros at its end."""
    short = value.quantize(Decimal(1).scaleb(-decimals)).normalize()
    return short.quantize(Decimal(1)) if short == short.to_integral_value() else short
