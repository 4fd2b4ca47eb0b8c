"""`pyport rt32`: the analysis of the RT32 Pointing Model, done again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from pyport.recordings import Recordings


@click.command("rt32", epilog="Example: pyport rt32 --out rt32")
@click.argument("recordings", required=False)
@click.option("--seed", default=0, show_default=True, help="Of the simulated campaign.")
@click.option(
    "--box-step",
    default="known",
    show_default=True,
    help="The box offset before 2004 less that after; known (0.017 deg), fit or degrees.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for figures 3 to 5.")
def command(recordings: str | None, seed: int, box_step: str, out: Path | None) -> None:
    """Repeat the fit of the RT32 Pointing Model, with robust ones beside it.

    The offsets that the document fitted were never published. Without RECORDINGS
    a simulated campaign takes their place: as many rows, the same two seasons,
    Model3, bad measurements.
    """
    from pyport.fitting.rt32 import METHODS, fit_rt32, table
    from pyport.fitting.rt32 import box_step as chosen_step
    from pyport.fitting.rt32.bootstrap import honest_sigmas
    from pyport.recordings import read, resolve

    measured = _simulated(seed, out) if recordings is None else read(resolve(recordings))
    box = chosen_step(measured, box_step)
    fits = [fit_rt32(measured, method=method, box=box) for method in METHODS]
    honest = [honest_sigmas(fit) for fit in fits]
    for title, text in (
        ("Parameters", table.text(fits[0], honest[0])),
        ("Correlations", table.correlations(fits[0])),
        ("Other methods, sigmas by sessions [arcsec]", table.compared(fits, honest)),
    ):
        click.echo(f"{title}\n{'-' * len(title)}\n{text}\n")
    if out is not None:
        from pyport.report.rt32_sky import write_figures

        for path in write_figures(fits[0], out):
            click.echo(str(path))


def _simulated(seed: int, out: Path | None) -> Recordings:
    """Make the campaign and read it as anyone's file would be."""
    from tempfile import TemporaryDirectory

    from pyport.recordings import read
    from pyport.trials.files import write_recordings
    from pyport.trials.rt32_campaign import rt32_campaign

    with TemporaryDirectory() as scratch:
        path = (Path(scratch) if out is None else out) / "rt32-simulated.csv"
        write_recordings(rt32_campaign(seed), path)
        return read(path)
