"""A fitted model into another program's file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC
from pyport.effects import Effect
from pyport.errors import BadInput
from pyport.fitting.fit import Fit
from pyport.formats import models
from pyport.formats.model_file import NAMES, WORDS, Entry, ModelFile, rounded, translated
from pyport.formats.terms.alike import shape_of
from pyport.formats.terms.words import SCALES

#: Decimals that a fitted number is told with, by its unit.
_DECIMALS = {"arcsec": 4, "deg": 10, "": 9}
_SIGMA_DECIMALS = {"arcsec": 5, "deg": 10, "": 9}


def save_fit(fit: Fit, path: Path) -> None:
    """Write a fitted model by suffix: in the vocabulary of its names, or of the format's.

    Raises
    ------
    BadInput
        The suffix is none of a model, coefficients differ between antennas or
        are not determined, or a term has no name in that format.
    """
    chosen = models.BY_SUFFIX.get(path.suffix.lower())
    if chosen is None or chosen.write is None:
        raise BadInput(f"suffix is none of a model, expected {', '.join(models.BY_SUFFIX)}", path)
    told = _told(fit, path)
    if len({one.name for one in told}) < len(told):
        raise BadInput("each antenna has coefficients of its own: a model file holds one", path)
    vocabulary = chosen.vocabulary or _vocabulary([one.name for one in told])
    found = [entry for one in told for entry in _in_vocabulary(one, vocabulary, path)]
    for n, entry in enumerate(found):
        if entry.name in {one.name for one in found[:n]}:
            raise BadInput(f"two terms of this model are {entry.name} there: drop one", path)
    file = ModelFile(vocabulary, tuple(found), fit.recordings.meta.get("telescope", "pyport"))
    if vocabulary == "tpoint":
        file = replace(file, details={"statistics": _statistics(fit)})
    chosen.write(file, path)


@dataclass(frozen=True)
class _Told:
    """A coefficient of a fit, in its own unit: sigma None where it was fixed."""

    name: str
    effect: Effect
    column: int
    value: float
    sigma: float | None

    def entry(self, name: str, unit: str, times: float = 1.0) -> Entry:
        """Return it under a name that stands for `times` of it."""
        scale = SCALES[unit] * times
        value = rounded(Decimal(repr(self.value / scale)), _DECIMALS[unit])
        sigma = None
        if self.sigma is not None:
            sigma = rounded(Decimal(repr(self.sigma / abs(scale))), _SIGMA_DECIMALS[unit])
        return Entry(name, value, unit, sigma, fixed=self.sigma is None)


def _vocabulary(names: list[str]) -> str:
    """Return the vocabulary that knows most of some names."""
    return max(WORDS, key=lambda one: sum(WORDS[one](name) is not None for name in names))


def _told(fit: Fit, path: Path) -> list[_Told]:
    """Return every coefficient of a fit, those that were fixed last."""
    found = []
    for one in fit.coefficients:
        effect = one.term.effect
        for n, coefficient in enumerate(effect.coefficients):
            value, sigma = float(one.value[n]), float(one.sigma[n])
            if not np.isfinite(value):
                raise BadInput(f"{coefficient.name} is not determined: drop or fix it", path)
            found.append(_Told(coefficient.name, effect, n, value, sigma))
    for term in fit.model.terms:
        if term.fixed:
            values = term.values or (0.0,) * len(term.effect.coefficients)
            names = [coefficient.name for coefficient in term.effect.coefficients]
            found += [
                _Told(name, term.effect, n, value, None)
                for n, (name, value) in enumerate(zip(names, values, strict=True))
            ]
    return found


def _in_vocabulary(told: _Told, vocabulary: str, path: Path) -> list[Entry]:
    """Return a coefficient under the name, or names, that a vocabulary has for it."""
    for own, words in WORDS.items():
        word = words(told.name)
        same_unit = told.effect.coefficients[told.column].unit == (word.unit if word else None)
        if word is not None and word.parts and same_unit:
            file = ModelFile(own, (told.entry(told.name, word.unit),))
            try:
                return list(translated(file, vocabulary).entries)
            except BadInput as error:
                raise BadInput(error.message, path) from None
    found = shape_of(told.effect, told.column)
    name = None if found is None else NAMES[vocabulary](found[0])
    word = None if name is None else WORDS[vocabulary](name[0])
    if found is None or name is None or word is None:
        raise BadInput(f"{vocabulary} has no name for {told.name}: drop it", path)
    return [told.entry(name[0], word.unit, name[1] / found[1])]


def _statistics(fit: Fit) -> dict[str, Decimal]:
    """Return TPOINT's line: stars, and the rms on the sky."""
    counted = fit.noise.used
    stars = len(np.unique(fit.stack.row[counted]))
    rms = np.sqrt((fit.residual[counted] ** 2).sum() / max(stars, 1)) / ARCSEC
    return {"stars": Decimal(stars), "sky_rms_arcsec": rounded(Decimal(repr(float(rms))), 4)}
