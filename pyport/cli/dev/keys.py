"""`pyport dev keys`: every key of report.json, with its type and meaning."""

from __future__ import annotations

from pathlib import Path

import click

from pyport.cli.manners import in_json, say


@click.command("keys", epilog="Example: pyport dev keys -o docs/report.md")
@click.option("-o", "--out", type=click.Path(path_type=Path, dir_okay=False), help="File to write.")
@in_json
def command(out: Path | None, *, as_json: bool) -> None:
    """List the keys of report.json, as the page of the manual has them."""
    from pyport.files import write_whole
    from pyport.report.keys import keys, markdown

    if out is not None:
        with write_whole(out) as file:
            file.write(markdown())
        return
    told = [dict(zip(("key", "type", "meaning"), one, strict=True)) for one in keys()]
    say(markdown().rstrip("\n"), told, as_json=as_json)
