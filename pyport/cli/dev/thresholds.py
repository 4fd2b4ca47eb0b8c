"""`pyport dev thresholds`: the numbers that decide what a diagnosis says, and why each is so."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import click

from pyport.cli.manners import in_json, say
from pyport.errors import BadInput

_COMMENT = re.compile(
    r"\[(?P<unit>[^]]+)\] (?P<decides>.+?)\. (?P<reason>.+?)\. "
    r"Smaller: (?P<smaller>.+?)\. Larger: (?P<larger>.+)\."
)


@dataclass(frozen=True)
class Threshold:
    """A number that decides: its name, value as written, and what its comment says of it."""

    name: str
    value: str
    unit: str
    decides: str
    reason: str
    smaller: str
    larger: str


def read(text: str) -> Iterator[Threshold]:
    """Yield the thresholds of a module's text.

    Raises
    ------
    ValueError
        A comment has another form than `pyport.thresholds` says.
    """
    lines = text.splitlines()
    for node in ast.parse(text).body:
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
            continue
        name, first = node.targets[0].id, node.lineno - 1
        while lines[first - 1].startswith("#: "):
            first -= 1
        comment = " ".join(line[3:] for line in lines[first : node.lineno - 1])
        said = _COMMENT.fullmatch(comment)
        if said is None:
            raise ValueError(f"{name}: {comment!r} lacks a unit, a reason or one of both sides")
        yield Threshold(name, ast.unparse(node.value), **said.groupdict())


def shipped() -> list[Threshold]:
    """Return the thresholds of this program."""
    from pyport import thresholds

    return list(read(Path(thresholds.__file__).read_text(encoding="utf-8")))


def markdown(some: list[Threshold]) -> str:
    """Return a table of thresholds, one a row."""
    head = ("constant", "value", "unit", "what it decides", "why", "were it smaller", "larger")
    rows = [head, ("---",) * len(head)]
    rows += [(f"`{one.name}`", f"`{one.value}`", *list(asdict(one).values())[2:]) for one in some]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def listing(some: list[Threshold]) -> str:
    """Return thresholds as text."""
    return "\n".join(f"{one.name} = {one.value} {one.unit}: {one.decides}" for one in some)


def put_between(text: str, mark: str, table: str) -> str:
    """Return a page with a table in the place of what stands between two marks.

    Raises
    ------
    BadInput
        The page has no such marks.
    """
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    if begin not in text or end not in text:
        raise BadInput(f"the page has no {begin.strip()} and {end}, expected both")
    head, rest = text.split(begin, 1)
    return f"{head}{begin}{table}{end}{rest.split(end, 1)[1]}"


@click.command("thresholds", epilog="Example: pyport dev thresholds")
@click.option("--into", type=click.Path(exists=True, dir_okay=False), help="The page to rewrite.")
@in_json
def command(into: str | None, *, as_json: bool) -> None:
    """List the numbers that decide what a diagnosis says: unit, reason, both wrong sides.

    With --into the table of that page is written anew.
    """
    from pyport.files import write_whole

    found = shipped()
    if into is None:
        say(lambda: listing(found), {"thresholds": [asdict(one) for one in found]}, as_json=as_json)
        return
    text = put_between(Path(into).read_text(encoding="utf-8"), "thresholds", markdown(found))
    with write_whole(into) as file:
        file.write(text)
