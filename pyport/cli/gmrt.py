"""`pyport gmrt`: the analysis of the GMRT paper, done again."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("gmrt", epilog="Example: pyport gmrt --out gmrt")
@click.option(
    "--garble",
    "seeds",
    type=click.IntRange(min=0),
    default=0,
    help="So often garble good rows on purpose, to see how right the realignment is.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for figures 1 to 4.")
def command(seeds: int, out: Path | None) -> None:
    """Repeat the GMRT paper's analysis on its own tables, shipped with pyport.

    How much of them was recovered, both functional forms for each antenna and
    day, what they say of the antennas' places, which antennas repeat from day to
    day, whether the arms are mirror images, and whether offsets jump at transit.
    """
    from pyport.angles import DEG
    from pyport.fitting.gmrt import summary
    from pyport.fitting.gmrt.arms import mirrors
    from pyport.fitting.gmrt.curves import curves
    from pyport.fitting.gmrt.repeats import repeatability
    from pyport.fitting.gmrt.tracks import tracks
    from pyport.fitting.gmrt.transit import jumps_at_transit
    from pyport.recordings import read
    from pyport.recordings.gmrt import recovery
    from pyport.recordings.gmrt.sessions import LATITUDE_DEG, SESSIONS, apparent_place
    from pyport.report.hour_angle import write_figures

    june = tracks(read("gmrt-cyg-a"))
    times_cos_el = curves(june, times_cos_el=True)
    _, dec = apparent_place(SESSIONS[2])
    for title, text in (
        ("Recovery", recovery.text(seeds)),
        ("Curves, forward and reverse apart", summary.forms(curves(june), times_cos_el)),
        ("Places", summary.site(times_cos_el, dec, LATITUDE_DEG * DEG)),
        ("Repeatability", summary.repeatability(repeatability(june))),
        ("Mirror images", summary.mirrors(mirrors(times_cos_el))),
        ("Transit", summary.jumps(jumps_at_transit(june))),
    ):
        click.echo(f"{title}\n{'-' * len(title)}\n{text}\n")
    if out is not None:
        for path in write_figures([*tracks(read("gmrt-2003-05-31")), *june], out):
            click.echo(str(path))
