"""Files of one format into another, digit for digit and term for term; the table of signs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pyport.effects import CATALOGUE
from pyport.errors import BadInput
from pyport.files import is_file
from pyport.formats import models
from pyport.formats.completed import write_model
from pyport.formats.field_system import err
from pyport.formats.model_file import (
    MOUNT_OF,
    NAMES,
    UPRIGHT_DEG,
    WORDS,
    ModelFile,
    translated,
    without_counterpart,
)
from pyport.formats.models import load as load_model
from pyport.models.model import Model
from pyport.models.terms import field_system, tpoint
from pyport.models.terms.shapes import PRODUCT, Shape
from pyport.mounts import ALTAZ
from pyport.recordings.files import read_raw
from pyport.recordings.formats import registry as tables
from pyport.recordings.interpret import interpret
from pyport.recordings.masks import set_aside
from pyport.recordings.mounted import stated
from pyport.recordings.naming import site_of
from pyport.recordings.raw import NOTHING, FileOptions, Raw
from pyport.recordings.schema import Table
from pyport.recordings.where import where

#: Vocabularies in the order of the columns, and what heads them.
COLUMNS = {
    "tpoint": "TPOINT",
    "field-system": "Field System, DISCOS",
    "katpoint": "katpoint",
    "ska-mid": "SKA-Mid",
}
#: Harmonics that stand for all of their kind.
EXAMPLES = ("HASA3", "HACA3", "HESA2", "HECA2", "HESA3", "HESE2", "HSCA5CE8")


def shapes() -> list[Shape]:
    """Return every shape that has a name of its own in some vocabulary, then the examples."""
    found: dict[Shape, None] = {}
    for name in (*tpoint.NAMED, *(f"P{n}" for n in range(1, field_system.NUMBER + 1))):
        for vocabulary in ("tpoint", "field-system"):
            word = WORDS[vocabulary](name)
            if word is not None and word.parts:
                found[word.parts[0][0]] = None
    for name in (*field_system.UNITS, *EXAMPLES):
        word = tpoint.word(name)
        if word is not None:
            found[word.parts[0][0]] = None
    order = [*CATALOGUE, PRODUCT]
    return sorted(found, key=lambda one: (order.index(one.effect), one.k, one.column))


def table() -> Iterator[str]:
    """Yield the lines of the table, in Markdown."""
    yield f"| coefficient | one of it adds | {' | '.join(COLUMNS.values())} |"
    yield "|---" * (2 + len(COLUMNS)) + "|"
    for shape in shapes():
        coefficient = shape.parent().coefficients[shape.column].name
        family = f" k = {shape.k}" if shape.k else ""
        cells = [_cell(shape, vocabulary) for vocabulary in COLUMNS]
        yield f"| `{coefficient}`{family} | {shape.formula} | {' | '.join(cells)} |"


def _cell(shape: Shape, vocabulary: str) -> str:
    """Return the names that mean a shape, each with its sign."""
    first = NAMES[vocabulary](shape)
    if first is None:
        return ""
    names = [first, *_others(shape, vocabulary, first[0])]
    return ", ".join(f"{'-' if sign < 0 else '+'}{name}" for name, sign in names)


def _others(shape: Shape, vocabulary: str, first: str) -> Iterator[tuple[str, float]]:
    """Yield further names that a vocabulary has for a shape."""
    numbered = [f"P{n}" for n in range(1, field_system.NUMBER + 1)]
    for name in (*tpoint.NAMED, *numbered):
        word = WORDS[vocabulary](name)
        if name != first and word is not None and word.parts and word.parts[0][0] == shape:
            yield name, word.parts[0][1]


FORMATS = (*tables.FORMATS, *models.FORMATS)


@dataclass(frozen=True)
class Done:
    """What was converted: rows or terms, the format written, and what it has no place for.

    `lost_arcsec` is the rms on the sky of the terms that it has no place for, None where that
    is not known, and `lost_size` says either in words; `waves` says which terms stand for what has
    no name; `masked` is how many rows are masked in the target alone, for they lack a number.
    """

    kind: str
    number: int
    format: str
    left_out: tuple[str, ...]
    lost_arcsec: float | None = None
    waves: str = ""
    lost_size: str = ""
    masked: int = 0


def convert(
    source: str,
    target: Path,
    *,
    to: str = "",
    given: FileOptions = NOTHING,
    model: str = "",
    leave_out: bool = False,
    rest_as: Path | None = None,
) -> Done:
    """Convert a file of recordings or of a model; the suffixes tell which, or the names given.

    `source`, `target`: the files; `FILE.xml#RECEIVER` picks one of several models.
    `to`: the format to write, where the suffix does not tell.
    `given`: what the source does not say itself, its format included.
    `model`: for the Field System's err: the mdlpo.ctl that says what to fit.
    `leave_out`: leave out a model's terms that the target has no counterpart of.
    `rest_as`: a CSV file for the corrections, on a grid, by those terms.
    Raises `BadInput`: a file is not of its format, or the target cannot hold what the source has.
    """
    if Path(source).suffix.lower() == ".toml" and not given.format and _lists_effects(source):
        model_of = load_model(source)
        name, number, rest = write_model(
            model_of, target, to=to, rest_as=rest_as, leave_out=leave_out, conditions=given.keys
        )
        size = rest.size if rest.names else ""
        return Done("model", number, name, rest.names, rest.rms_arcsec, rest.waves.words, size)
    if rest_as is not None:
        raise BadInput("--rest-as is for a model of pyport's: fit or diagnose --save one", source)
    if _is_model(source, target, given.format, to):
        return _model(source, target, given, to, leave_out=leave_out)
    path = Path(source)
    if not is_file(path):
        raise BadInput("no such file, expected recordings or a pointing model", path)
    raw = read_raw(path, given)
    recordings = interpret(raw)  # what no reading could use is refused before it is spread
    if given.where:
        kept = where(recordings, given.where)
        if not len(kept):
            said = f"holds for none of the {len(recordings)} recordings"
            raise BadInput(f"--where {given.where!r} {said}", path)
        raw = set_aside(raw, {one.line: one.reason for one in kept.set_aside})
    if model:
        err.write(err.fitted(raw, models.read(model)), target)
        return Done("recordings", len(raw.line), "fs-err", ())
    written = tables.write(table_of(raw), target, to)
    name = tables.format_of(target, to).name
    return Done("recordings", len(raw.line), name, written.left_out, masked=written.masked)


def _lists_effects(source: str) -> bool:
    """Tell whether a TOML file holds a model of pyport's, not one in another's vocabulary."""
    return is_file(source) and not models.names_terms(Path(source))


def table_of(raw: Raw) -> Table:
    """Return the cells of a file as the writers take them."""
    return Table(
        raw.meta,
        {
            name: cells.astype(np.str_) if cells.dtype.kind == "O" else cells
            for name, cells in ((name, np.asarray(one)) for name, one in raw.columns.items())
        },
    )


def _is_model(source: str, target: Path, read_as: str, write_as: str) -> bool:
    """Tell whether models are meant: the source decides, the target where it could be either."""
    if read_as:
        return read_as in models.FORMATS
    suffix = models.split(source)[0].suffix.lower()
    if suffix in {".err", ".csv"} or suffix not in tables.BY_SUFFIX:
        is_model = suffix in models.BY_SUFFIX
        to_model = write_as in models.FORMATS or (
            not write_as and target.suffix.lower() in models.BY_SUFFIX
        )
        return is_model or to_model
    return False


def _model(
    source: str, target: Path, given: FileOptions, write_as: str, *, leave_out: bool
) -> Done:
    file = _read_model(source, given.format)
    chosen = models.FORMATS.get(write_as) if write_as else models.BY_SUFFIX.get(target.suffix)
    if chosen is None or chosen.write is None:
        known = ", ".join(models.BY_SUFFIX)
        raise BadInput(f"this is no format of models, expected {known}, or --to", target)
    vocabulary = chosen.vocabulary or file.vocabulary
    if file.vocabulary.startswith(vocabulary):
        vocabulary = file.vocabulary  # of another mount, too
    elif file.vocabulary in MOUNT_OF or file.phi_deg != UPRIGHT_DEG:
        mounted = replace(_mounted(file, source, given), site=site_of(given.keys))
        name, number, rest = write_model(mounted, target, to=write_as, leave_out=leave_out)
        return Done("model", number, name, rest.names, rest.rms_arcsec)
    try:
        done = translated(file, vocabulary, leave_out=leave_out)
    except BadInput as error:
        raise BadInput(error.message, models.split(source)[0]) from None
    chosen.write(done, target)
    lost = tuple(without_counterpart(file, vocabulary))
    return Done("model", sum(one.used for one in done.entries), chosen.name, lost)


def _read_model(source: str, read_as: str) -> ModelFile:
    """Read a model file.

    Raises `BadInput`: it is none; what is a table of recordings is said to be one.
    """
    try:
        return models.read(source, read_as)
    except BadInput as error:
        if read_as or models.split(source)[0].suffix.lower() not in tables.BY_SUFFIX:
            raise
        wanted = "if these are recordings, pyport fit or diagnose --save writes a model of them"
        raise BadInput(f"{error.message}; {wanted}", error.file, error.line) from None


def _mounted(file: ModelFile, source: str, given: FileOptions) -> Model:
    """Return a model on the mount that its file, or what is given beside it, says.

    Raises `BadInput`: neither does.
    """
    mount = stated(given.keys) or ALTAZ
    if mount is ALTAZ and file.vocabulary not in MOUNT_OF:
        wrong = f"phi is {file.phi_deg} deg, and no mount is stated"
        raise BadInput(f"{wrong}: --mount xy-ns, equatorial, ...", models.split(source)[0])
    model = file.model(models.split(source)[0].stem)
    return model if mount is ALTAZ else model.on(mount)
