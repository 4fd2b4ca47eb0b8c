"""`pyport study gmrt-array`: the GMRT's recordings as those of one array."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(
    "gmrt-array", epilog="Example: pyport study gmrt-array --antennas antennas.csv --out array"
)
@click.option(
    "--antennas",
    type=click.Path(path_type=Path),
    help="CSV file of surveyed antenna positions to compare with: name,east_m.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for the picture.")
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON.")
def command(antennas: Path | None, out: Path | None, *, as_json: bool) -> None:
    """Analyse the GMRT's days of 2003 as those of one array.

    What the antennas share from day to day and what each has of its own, and
    whether it repeats; how far each antenna stands from where its offsets were
    computed for, beside a survey if there is one; whole antenna-days predicted
    from all others; the Crab predicted from Cyg A. Your own array: `pyport
    diagnose` says the same of any recordings.
    """
    import json

    from pyport.recordings.antennas import read_survey
    from pyport.report.typed import as_json as finite
    from pyport.studies.gmrt import array as gmrt_array

    survey = None if antennas is None else read_survey(antennas)
    found = gmrt_array.evidence(survey, lambda line: click.echo(line, err=True))
    click.echo(json.dumps(finite(found.as_json())) if as_json else gmrt_array.page(found))
    if out is not None:
        for path in gmrt_array.write(found, out):
            click.echo(str(path), err=as_json)
