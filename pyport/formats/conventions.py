"""The table of signs: what every program's terms are in pyport's coefficients."""

from __future__ import annotations

from collections.abc import Iterator

from pyport.effects import CATALOGUE
from pyport.formats.model_file import NAMES, WORDS
from pyport.models.terms import field_system, tpoint
from pyport.models.terms.shapes import PRODUCT, Shape

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
