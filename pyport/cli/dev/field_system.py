"""`pyport dev field-system`: agreement with the VLBI Field System's own outputs."""

from __future__ import annotations

from pathlib import Path

import click

from pyport.cli.manners import in_json, say


@click.command("field-system", epilog="Example: pyport dev field-system field_system")
@click.argument("folder", type=click.Path(path_type=Path, exists=True, file_okay=False))
@in_json
def command(folder: Path, *, as_json: bool) -> None:
    """Compare pyport with what the Field System computed, as kept in FOLDER.

    Unit responses of P1..P30 (fs_fln_flt_grid.csv) and fits: each NAME.xtr
    fitted by mdlpo.ctl beside NAME.err.
    """
    from pyport.formats.field_system import agreement
    from pyport.progress import working

    with working("comparing"):
        told = agreement.as_json(folder) if as_json else {}
        lines = [] if as_json else list(agreement.text(folder))
    say("\n".join(lines), told, as_json=as_json)
