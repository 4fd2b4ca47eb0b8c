"""`pyport study gmrt`: the analysis of the GMRT paper, done again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import in_json, say

if TYPE_CHECKING:
    from pyport.studies.gmrt.tracks import Track


@click.command("gmrt", epilog="Example: pyport study gmrt --out gmrt")
@click.option(
    "--garble",
    "seeds",
    type=click.IntRange(min=0),
    default=0,
    help="How often to garble good rows on purpose, to measure the realignment.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for figures 1 to 4.")
@in_json
def command(seeds: int, out: Path | None, *, as_json: bool) -> None:
    """Repeat the GMRT paper's analysis on its own tables, shipped with pyport.

    How much of them was recovered, both functional forms for each antenna and
    day, what they say of the antennas' places, which antennas repeat from day to
    day, whether the arms are mirror images, and whether offsets jump at transit.
    """
    from pyport.progress import working
    from pyport.recordings import read
    from pyport.studies.gmrt.figures import write_figures

    with working("repeating the paper's analysis"):
        june, sections = _analysis(seeds)
    drawn = []
    if out is not None:
        from pyport.studies.gmrt.tracks import tracks

        drawn = write_figures([*tracks(read("gmrt-2003-05-31")), *june], out)
    if as_json:
        say("", {"sections": sections, "figures": drawn}, as_json=True)
        return
    for title, text in sections.items():
        click.echo(f"{title}\n{'-' * len(title)}\n{text}\n")
    for path in drawn:
        click.echo(str(path))


def _analysis(seeds: int) -> tuple[list[Track], dict[str, str]]:
    """Return the tracks of June, and what each part of the analysis says of them."""
    from pyport.angles import DEG
    from pyport.recordings import read
    from pyport.studies.gmrt import summary
    from pyport.studies.gmrt.curves import curves
    from pyport.studies.gmrt.recovery import recovery
    from pyport.studies.gmrt.repetition import jumps_at_transit, mirrors, repeatability
    from pyport.studies.gmrt.sessions import LATITUDE_DEG, SESSIONS, apparent_place
    from pyport.studies.gmrt.tracks import tracks

    june = tracks(read("gmrt-cyg-a"))
    plain, times_cos_el = curves(june), curves(june, times_cos_el=True)
    _, dec = apparent_place(SESSIONS[2])
    return june, {
        "Recovery": recovery.text(seeds),
        "Curves, forward and reverse apart": summary.forms(plain, times_cos_el),
        "Doubts about these curves": summary.warnings([*plain, *times_cos_el]),
        "Places": summary.site(times_cos_el, dec, LATITUDE_DEG * DEG),
        "Repeatability": summary.repeatability(repeatability(june)),
        "Mirror images": summary.mirrors(mirrors(times_cos_el)),
        "Transit": summary.jumps(jumps_at_transit(june)),
    }
