"""`pyport study rt32`: the analysis of the RT32 Pointing Model, done again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import in_json, say

if TYPE_CHECKING:
    from pyport.angles import Array
    from pyport.recordings import Recordings


@click.command("rt32", epilog="Example: pyport study rt32 --out rt32")
@click.argument("recordings", required=False)
@click.option("--seed", default=0, show_default=True, help="Seed of the simulated campaign.")
@click.option(
    "--campaigns",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="Number of simulated campaigns, from --seed on, to see how well Model3 is recovered.",
)
@click.option(
    "--box-step",
    default="known",
    show_default=True,
    help="The box offset before 2004 less that after; known (0.017 deg), fit or degrees.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for figures 3 to 5.")
@in_json
def command(
    recordings: str | None,
    seed: int,
    campaigns: int,
    box_step: str,
    out: Path | None,
    *,
    as_json: bool,
) -> None:
    """Repeat the fit of the RT32 Pointing Model, with robust ones beside it.

    The offsets that the document fitted were never published. Without RECORDINGS
    a simulated campaign takes their place: as many rows, the same two seasons,
    Model3, bad measurements.
    """
    from pyport.progress import track, working
    from pyport.recordings import read, resolve
    from pyport.studies.rt32 import METHODS, document, fit_rt32, table
    from pyport.studies.rt32 import box_step as chosen_step
    from pyport.studies.rt32.bootstrap import honest_sigmas

    if recordings is None:
        measured, error = _simulated(seed, out)
    else:
        measured, error = read(resolve(recordings)), None
    box = chosen_step(measured, box_step)
    with working("fitting") as tell:
        fits, honest = [], []
        for method in METHODS:
            tell(method)
            fits.append(fit_rt32(measured, method=method, box=box))
            honest.append(honest_sigmas(fits[-1]))
    parts = [
        ("Parameters", table.text(fits[0], honest[0])),
        ("Correlations", table.correlations(fits[0])),
        ("Beside the document", document.beside(fits[0])),
    ]
    if error is not None:
        made = [(fits[0], honest[0], error)]
        for other in track(range(seed + 1, seed + campaigns), "campaigns", campaigns - 1):
            measured, error = _simulated(other, None)
            fit = fit_rt32(measured, box=chosen_step(measured, box_step))
            made.append((fit, honest_sigmas(fit), error))
        parts.append(("What was put in, and found", document.recovered(made)))
    parts.append(("Other methods, sigmas by sessions [arcsec]", table.compared(fits, honest)))
    drawn = []
    if out is not None:
        from pyport.studies.rt32.sky import write_figures

        drawn = write_figures(fits[0], out)
    if as_json:
        told = [table.as_json(one, own) for one, own in zip(fits, honest, strict=True)]
        say("", {"fits": told, "sections": dict(parts), "figures": drawn}, as_json=True)
        return
    for title, text in parts:
        click.echo(f"{title}\n{'-' * len(title)}\n{text}\n")
    for path in drawn:
        click.echo(str(path))


def _simulated(seed: int, out: Path | None) -> tuple[Recordings, Array]:
    """Make a campaign and read it as anyone's file would be; with it what rows are off by [rad]."""
    from tempfile import TemporaryDirectory

    import numpy as np

    from pyport.angles import ARCSEC
    from pyport.examiner.sealed.files import write_recordings
    from pyport.examiner.worlds.rt32_campaign import rt32_campaign
    from pyport.recordings import read

    case = rt32_campaign(seed)
    with TemporaryDirectory() as scratch:
        path = (Path(scratch) if out is None else out) / "rt32-simulated.csv"
        write_recordings(case, path)
        return read(path), np.array(case.truth["error_arcsec"]) * ARCSEC
