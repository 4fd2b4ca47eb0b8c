"""`pyport dev verify`: whether the files of a diagnosis are all of one run."""

from __future__ import annotations

from pathlib import Path

import click

from pyport.cli.manners import in_json, say


@click.command("verify", epilog="Example: pyport dev verify diagnosis/offsets")
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True)
@in_json
def command(folders: tuple[str, ...], *, as_json: bool) -> None:
    """Check that the files in a diagnosis's FOLDER are those that its report was written with.

    They are not where a run was stopped while it wrote, or where somebody changed one since.
    """
    from pyport.report.folder import check

    found = {folder: check(Path(folder)) for folder in folders}
    lines = [f"{folder}: report.json and {n} files of one run" for folder, n in found.items()]
    say("\n".join(lines), found, as_json=as_json)
