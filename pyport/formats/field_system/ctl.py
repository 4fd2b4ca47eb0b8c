"""The Field System's pointing models: mdlpo.ctl, and the same lines inside an err file.

A number and a date (model, year, day of year, hour, minute, second), then phi
and a flag for each parameter, then the parameters, five a line, in degrees.
`*` begins a comment. Flags: 0 off, 1 fitted, 2 held, 3 fitted while all lower
ones are held, 4 taken off the data and forgotten.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.model_file import Entry, ModelFile
from pyport.models.terms.field_system import NUMBER
from pyport.recordings.formats.text import Line, lines_of, padded
from pyport.recordings.formats.xtr import section, sections

OFF, FITTED, HELD, ALONE, FORGOTTEN = range(5)
_A_LINE = 5


def read(path: Path) -> ModelFile:
    """Read a mdlpo.ctl.

    Raises `BadInput`: a line is missing, or holds something else than numbers.
    """
    body = lines_of(path)
    comments = [line.text.rstrip() for line in body if line.text.startswith("*")]
    kept = [line for line in body if line.text.strip() and not line.text.startswith("*")]
    return from_lines(kept, path, "\n".join(comments))


def read_new_model(path: Path) -> ModelFile:
    """Read the model that a fit gave, out of an err file.

    Raises `BadInput`: the file has no `$new_model`.
    """
    return from_lines(section(sections(path), "new_model", path), path)


def from_lines(lines: Sequence[Line], path: Path, comments: str = "") -> ModelFile:
    """Return the model that these lines, comments left out, hold."""
    if len(lines) < 3:
        wanted = "a number and date, phi and flags, and parameters"
        last = lines[-1].number if lines else 1
        raise BadInput(f"{len(lines)} lines of a model, expected {wanted}", path, last)
    date, control, *rest = lines
    phi, *flags = control.words
    if not 1 <= len(flags) <= NUMBER or any(flag not in "01234" for flag in flags):
        raise control.error(f"{len(flags)} flags, expected 1 to {NUMBER} of 0, 1, 2, 3 or 4")
    values = [line.decimal(word, "a parameter") for line in rest for word in line.words]
    if len(values) != len(flags):
        raise rest[-1].error(f"{len(values)} parameters, expected {len(flags)} as there are flags")
    marks = [int(flag) for flag in flags]
    return ModelFile(
        "field-system",
        entries(values, marks),
        phi_deg=control.decimal(phi, "phi"),
        details={"number_and_date": _date(date), "flags": marks, "comments": comments},
    )


def entries(values: Sequence[Decimal], marks: Sequence[int]) -> tuple[Entry, ...]:
    """Return P1, P2, ... with these values and flags."""
    return tuple(
        Entry(f"P{n}", value, "deg", fixed=is_held(mark, marks), used=mark != OFF)
        for n, (value, mark) in enumerate(zip(values, marks, strict=True), 1)
    )


def _date(line: Line) -> list[int]:
    words = line.words
    if not 6 <= len(words) <= 7 or any(not word.isdigit() for word in words):
        wanted = "expected a number, year, day of year, hour, minute and second"
        raise line.error(f"this is {line.text.strip()[:60]!r}, {wanted}")
    return [int(word) for word in words]


def is_held(mark: int, marks: Sequence[int]) -> bool:
    """Tell whether a parameter in use is not fitted."""
    return mark in {HELD, FORGOTTEN} or (ALONE in marks and mark == FITTED)


def write(file: ModelFile, path: Path) -> None:
    """Write a model in the Field System's vocabulary as a mdlpo.ctl."""
    comments = file.details.get("comments") or ""
    with write_whole(path) as out:
        first, _, more = str(comments or "* pyport").partition("\n")
        if first.strip("* "):
            out.write(first + "\n")
        out.writelines(line + "\n" for line in to_lines(file))
        out.writelines(line + "\n" for line in more.split("\n") if line.strip("* "))


def to_lines(file: ModelFile) -> Iterator[str]:
    """Yield the lines of a model as the Field System writes them."""
    values, marks = numbered(file)
    number, year, day, hour, minute, second, *rest = file.details.get("number_and_date", [0] * 6)
    yield "* "
    yield f"  {number:05d}  {year:04d}  {day:03d}  {hour:02d}  {minute:02d}  {second:02d}" + (
        "".join(f" {one}" for one in rest)
    )
    yield "* "
    groups = [marks[n : n + _A_LINE] for n in range(0, len(marks), _A_LINE)]
    flags = "  ".join(" ".join(map(str, group)) for group in groups)
    yield f"  {padded(file.phi_deg, 8, 4)}  {flags}"
    yield "* "
    for n in range(0, len(values), _A_LINE):
        yield "".join(f"  {padded(value, 13, 10)}" for value in values[n : n + _A_LINE]) + " "
        yield "* "


def numbered(file: ModelFile) -> tuple[list[Decimal], list[int]]:
    """Return the values and flags of P1, P2, ..."""
    flags = file.details.get("flags")
    size = len(flags) if flags else NUMBER
    values, marks = [Decimal(0)] * size, [OFF] * size
    for entry in file.entries:
        place = int(entry.name[1:]) - 1
        values[place] = entry.value
        marks[place] = (HELD if entry.fixed else FITTED) if entry.used else OFF
    return values, list(flags) if flags else marks
