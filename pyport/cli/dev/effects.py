"""`pyport dev effects`: every physical cause that a diagnosis may name, and what each one needs."""

from __future__ import annotations

import json

import click

from pyport.cli.manners import effects, in_json, plain


@click.command("effects", epilog="Example: pyport dev effects refraction")
@click.argument("names", nargs=-1, metavar="[EFFECT]...", shell_complete=effects)
@click.option("--mount", "kind", default="altaz", show_default=True, help="Whose words are said.")
@click.option("--markdown", is_flag=True, help="The document on the physics instead of a list.")
@click.option("-o", "--output", type=click.Path(dir_okay=False), help="The file to write.")
@in_json
def command(
    names: tuple[str, ...], kind: str, output: str | None, *, markdown: bool, as_json: bool
) -> None:
    """List the catalogue of effects: what each is, needs, and is degenerate with.

    With the name of one or more effects, those alone.
    """
    from pyport.effects import describe
    from pyport.files import write_whole
    from pyport.mounts import ALTAZ, KINDS

    if kind not in KINDS:
        raise click.UsageError(f"no mount is called {kind!r}; there are {', '.join(KINDS)}")
    mount = KINDS[kind]
    if markdown and (names or mount is not ALTAZ):
        raise click.UsageError("the document is of the whole catalogue: give --markdown alone")
    if as_json:
        text = json.dumps(plain(describe.entries(names, mount)), indent=1) + "\n"
    else:
        text = describe.markdown() if markdown else describe.listing(names, mount)
    if output:
        with write_whole(output) as file:
            file.write(text)
    else:
        click.echo(text, nl=False)
