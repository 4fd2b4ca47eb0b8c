"""A model of pyport into another program's file, and what that cannot hold beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.effects import Circumstances, Effect
from pyport.effects.fields import UNKNOWN
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats import models
from pyport.formats.model_file import KEPT, NAMES, WORDS, Entry, ModelFile, rounded, translated
from pyport.formats.terms.alike import shape_of
from pyport.formats.terms.words import SCALES
from pyport.models import toml
from pyport.models.model import Model

#: Decimals that a value is written with, by its unit: 0.4 microarcsec in degrees.
_DECIMALS = {"arcsec": 4, "deg": 10, "": 9}
_SIGMA_DECIMALS = {"arcsec": 5, "deg": 10, "": 9}
#: Steps of a correction grid, and the sky that it covers [deg].
GRID_STEP_DEG, LOWEST_DEG = 2.0, 2.0


@dataclass(frozen=True)
class Rest:
    """What a format cannot hold of a model.

    Attributes
    ----------
    names
        The terms, and the RT32's exact form where the model has it.
    rms_arcsec
        Their rms on the sky, both axes together, None where it depends on more than directions.
    grid
        Where they were written to, None where they were left out.
    """

    names: tuple[str, ...] = ()
    rms_arcsec: float | None = 0.0
    grid: Path | None = None

    @property
    def words(self) -> str:
        """Return it as a sentence, "" for nothing."""
        if not self.names:
            return ""
        size = ""
        if self.rms_arcsec is not None:
            size = f", {self.rms_arcsec:.3g} arcsec rms over the sky"
        where = "left out" if self.grid is None else f"in {self.grid}"
        return f"{where}: {', '.join(self.names)}{size}"


def write_model(
    model: Model,
    path: Path,
    *,
    to: str = "",
    rest_as: Path | None = None,
    leave_out: bool = False,
    conditions: Mapping[str, float] | None = None,
) -> tuple[str, int, Rest]:
    """Write a model by suffix: as pyport has it, or in the vocabulary of another program.

    Parameters
    ----------
    model
        With values in its terms.
    path
        The file.
    to
        The format, where the suffix does not tell.
    rest_as
        A CSV file for the corrections by terms that the format has no name for.
    leave_out
        Leave those terms out.
    conditions
        What holds for `rest_as` beside directions: `temperature_c`, ...

    Returns
    -------
    format, number, rest
        What was written, how many terms, and what was not.

    Raises
    ------
    BadInput
        The suffix is none of a model, coefficients differ between antennas or are not
        determined, or a term has no name in that format.
    """
    chosen = models.FORMATS.get(to) if to else models.BY_SUFFIX.get(path.suffix.lower())
    if chosen is None or chosen.write is None:
        raise BadInput(f"suffix is none of a model, expected {', '.join(models.BY_SUFFIX)}", path)
    if chosen.name == "toml":
        if model.completed is None:
            raise BadInput("a model that nothing was fitted to is a file already", path)
        toml.write(model, path)
        return chosen.name, len(model.completed.values), Rest()
    told = _told(model, path)
    if not told and model.given is None:
        raise BadInput(f"the model {model.name} has no values to write: fit it first", path)
    vocabulary = chosen.vocabulary
    found: list[Entry] = []
    lost: list[str] = [f"the RT32's exact form ({model.base})"] if model.given is not None else []
    for one in told:
        entries = _in_vocabulary(one, vocabulary)
        found += entries
        if not entries:
            lost.append(one.called)
    lost = list(dict.fromkeys(lost))
    if lost and rest_as is None and not leave_out:
        ways = "keep a .toml and convert it with --rest-as grid.csv (their corrections on a grid)"
        wrong = f"{vocabulary} has no name for {', '.join(lost)}"
        raise BadInput(f"{wrong}: {ways} or --leave-out", path)
    made = dict(model.completed.made) if model.completed else dict(model.told)
    title = str(made.get("title") or made.get("telescope") or model.name)
    details = {key: made[key] for key in KEPT if key in made and vocabulary == "field-system"}
    file = ModelFile(vocabulary, tuple(_summed(found)), title, details=details)
    if vocabulary == "tpoint":
        file = replace(file, details={"statistics": _statistics(model)})
    rest = _rest(model, file, lost, rest_as, conditions or {})
    chosen.write(file, path)
    return chosen.name, len(file.entries), rest


@dataclass(frozen=True)
class _Told:
    """A coefficient of a model in internal units: sigma None where it was fixed or is not told."""

    name: str
    effect: Effect
    column: int
    value: float
    sigma: float | None
    fixed: bool

    @property
    def called(self) -> str:
        """Return the name for a reader: a field without a name has one for all its numbers."""
        return f"the field {self.effect.variant}" if self.effect.id == UNKNOWN else self.name

    def entry(self, name: str, unit: str, times: float = 1.0) -> Entry:
        """Return it under a name that stands for `times` of it."""
        scale = SCALES[unit] * times
        value = rounded(Decimal(repr(self.value / scale)), _DECIMALS[unit])
        sigma = None
        if self.sigma is not None:
            sigma = rounded(Decimal(repr(self.sigma / abs(scale))), _SIGMA_DECIMALS[unit])
        return Entry(name, value, unit, sigma, fixed=self.fixed)


def _told(model: Model, path: Path) -> list[_Told]:
    """Return every coefficient of a model that has a value."""
    known = iter(() if model.completed is None else model.completed.values)
    found = []
    for term in model.terms:
        if len(term.by) > 1:
            each = " and ".join(term.per) or "label"
            wrong = f"{term.effect.id} has coefficients for each {each}: a model file holds one set"
            raise BadInput(wrong, path)
        values = term.given(next(iter(term.by), ()))
        for n, (coefficient, value) in enumerate(
            zip(term.effect.coefficients, values, strict=True)
        ):
            row = next(known, None)
            if row is not None and not row.determined:
                raise BadInput(f"{coefficient.name} is not determined: drop or fix it", path)
            sigma = None if row is None or row.sigma is None else row.sigma * abs(coefficient.scale)
            if term.has_values or term.fixed:
                held = term.fixed or (row is not None and row.sigma is None)
                found.append(_Told(coefficient.name, term.effect, n, value, sigma, held))
    return found


def _in_vocabulary(told: _Told, vocabulary: str) -> list[Entry]:
    """Return a coefficient under the name, or names, that a vocabulary has for it, if any."""
    for own, words in WORDS.items():
        word = words(told.name)
        same_unit = told.effect.coefficients[told.column].unit == (word.unit if word else None)
        if word is not None and word.parts and same_unit:
            file = ModelFile(own, (told.entry(told.name, word.unit),))
            try:
                return list(translated(file, vocabulary).entries)
            except BadInput:
                return []
    found = shape_of(told.effect, told.column)
    name = None if found is None else NAMES[vocabulary](found[0])
    word = None if name is None else WORDS[vocabulary](name[0])
    if found is None or name is None or word is None:
        return []
    return [told.entry(name[0], word.unit, name[1] / found[1])]


def _summed(entries: Sequence[Entry]) -> list[Entry]:
    """Return entries with those of one name as one: their values add up."""
    found: dict[str, Entry] = {}
    for one in entries:
        old = found.get(one.name)
        if old is None:
            found[one.name] = one
        else:
            both = [each.sigma for each in (old, one) if each.sigma is not None]
            sigma = sum((each**2 for each in both), Decimal(0)).sqrt() if both else None
            fixed = old.fixed and one.fixed
            found[one.name] = replace(old, value=old.value + one.value, sigma=sigma, fixed=fixed)
    return list(found.values())


def _statistics(model: Model) -> dict[str, Decimal]:
    """Return TPOINT's line: stars, and the rms on the sky."""
    made = {} if model.completed is None else model.completed.made
    return {
        "stars": Decimal(int(made.get("stars", 0))),
        "sky_rms_arcsec": rounded(Decimal(repr(float(made.get("sky_rms_arcsec", 0.0)))), 4),
    }


def _rest(
    model: Model,
    file: ModelFile,
    lost: Sequence[str],
    path: Path | None,
    conditions: Mapping[str, float],
) -> Rest:
    """Return what a file lacks of a model, and write it where a path is given.

    Raises
    ------
    BadInput
        It has to be written and depends on more than directions.
    """
    if not lost:
        return Rest()
    az_deg, el_deg = (
        one.ravel()
        for one in np.meshgrid(
            np.arange(0.0, 360.0, GRID_STEP_DEG),
            np.arange(LOWEST_DEG, 90.0, GRID_STEP_DEG),
            indexing="ij",
        )
    )
    columns = {name: np.full(len(az_deg), value) for name, value in conditions.items()}
    at = Circumstances(az_deg * DEG, el_deg * DEG, model.site, columns)
    try:
        x, y = (
            one - other
            for one, other in zip(model.offsets(at), _held(file).offsets(at), strict=True)
        )
    except BadInput as error:
        if path is None:
            return Rest(tuple(lost), None)
        wanted = "a grid of directions tells none: --set COLUMN=VALUE gives one value for all"
        raise BadInput(f"{error.message}; {wanted}", path) from None
    weight = np.cos(at.el)
    rms = float(np.sqrt(((x**2 + y**2) * weight).sum() / weight.sum())) / ARCSEC
    if path is not None:
        _write_grid(path, az_deg, el_deg, (x / ARCSEC, y / ARCSEC), lost, conditions)
    return Rest(tuple(lost), rms, path)


def _held(file: ModelFile) -> Model:
    """Return what a file holds as a model."""
    return file.model("held")


def _write_grid(
    path: Path,
    az_deg: Array,
    el_deg: Array,
    offsets_arcsec: tuple[Array, Array],
    names: Sequence[str],
    conditions: Mapping[str, float],
) -> None:
    """Write corrections on a grid, as recordings are written."""
    with write_whole(path) as out:
        out.write(f"# corrections: {', '.join(names)}\n# azimuth_zero: north\n")
        out.writelines(f"# {name}: {value!r}\n" for name, value in conditions.items())
        out.write("az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n")
        for row in zip(az_deg, el_deg, *offsets_arcsec, strict=True):
            out.write(f"{row[0]:g},{row[1]:g},{row[2]:.6f},{row[3]:.6f}\n")
