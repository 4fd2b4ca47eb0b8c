"""`pyport field-system`: agreement with the VLBI Field System's own outputs."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("field-system", epilog="Example: pyport field-system field_system")
@click.argument("folder", type=click.Path(path_type=Path, exists=True, file_okay=False))
def command(folder: Path) -> None:
    """Compare pyport with what the Field System computed, as kept in FOLDER.

    Unit responses of P1..P30 (fs_fln_flt_grid.csv) and fits: each NAME.xtr
    fitted by mdlpo.ctl beside NAME.err.
    """
    from pyport.formats.field_system import agreement

    for line in agreement.text(folder):
        click.echo(line)
