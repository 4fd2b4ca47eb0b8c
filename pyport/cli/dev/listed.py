"""Commands that list what the program knows: effects, keys of a report, numbers that decide."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import click

from pyport.cli.manners import effects as completed
from pyport.cli.manners import flag, in_json, option, plain, say
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

    Raises `ValueError`: a comment has another form than `pyport.thresholds` says.
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

    Raises `BadInput`: the page has no such marks.
    """
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    if begin not in text or end not in text:
        raise BadInput(f"the page has no {begin.strip()} and {end}, expected both")
    head, rest = text.split(begin, 1)
    return f"{head}{begin}{table}{end}{rest.split(end, 1)[1]}"


def rewrite(page: Path, mark: str, table: str) -> None:
    """Write a page anew with a table between two marks."""
    from pyport.files import write_file

    write_file(page, put_between(page.read_text(encoding="utf-8"), mark, table))


@click.command("thresholds", epilog="Example: pyport dev thresholds")
@option("--into", "The page to rewrite.", type=click.Path(exists=True, dir_okay=False))
@in_json
def thresholds(into: str | None, *, as_json: bool) -> None:
    """List the numbers that decide what a diagnosis says: unit, reason, both wrong sides.

    With --into the table of that page is written anew.
    """
    found = shipped()
    if into is None:
        say(lambda: listing(found), {"thresholds": [asdict(one) for one in found]}, as_json=as_json)
    else:
        rewrite(Path(into), "thresholds", markdown(found))


@click.command("effects", epilog="Example: pyport dev effects refraction")
@click.argument("names", nargs=-1, metavar="[EFFECT]...", shell_complete=completed)
@option("--mount kind", "Whose words are said.", "altaz")
@flag("--markdown page", "The document on the physics, not a list.")
@option("-o --output", "The file to write.", type=click.Path(dir_okay=False))
@in_json
def effects(
    names: tuple[str, ...], kind: str, output: str | None, *, page: bool, as_json: bool
) -> None:
    """List the catalogue of effects: what each is, needs, and is degenerate with.

    With the name of one or more effects, those alone.
    """
    from pyport.effects import describe
    from pyport.mounts import ALTAZ, KINDS

    if kind not in KINDS:
        raise click.UsageError(f"no mount is called {kind!r}; there are {', '.join(KINDS)}")
    mount = KINDS[kind]
    if page and (names or mount is not ALTAZ):
        raise click.UsageError("the document is of the whole catalogue: give --markdown alone")
    if as_json:
        text = json.dumps(plain(describe.entries(names, mount)), indent=1) + "\n"
    else:
        text = describe.markdown() if page else describe.listing(names, mount)
    _put(text, output)


@click.command("keys", epilog="Example: pyport dev keys -o docs/report.md")
@option("-o --out", "File to write.", type=click.Path(dir_okay=False))
@in_json
def keys(out: str | None, *, as_json: bool) -> None:
    """List the keys of report.json, as the page of the manual has them."""
    from pyport.report.keys import keys as listed
    from pyport.report.keys import markdown as document

    if out is None and as_json:
        head = ("key", "type", "meaning")
        say("", [dict(zip(head, one, strict=True)) for one in listed()], as_json=True)
    else:
        _put(document(), out)


def _put(text: str, path: str | None) -> None:
    from pyport.files import write_file

    if path is None:
        click.echo(text, nl=False)
        return
    write_file(path, text)
