"""`pyport trials`: recordings with hidden causes, sealed, solved, opened and scored."""

from __future__ import annotations

from pathlib import Path

import click


@click.group()
def command() -> None:
    """Hide causes in simulated recordings, and find out whether they are found."""


@command.command()
@click.option("--kind", required=True, help="What to hide: " + "null, one, two, held, unknown, ...")
@click.option("--effect", help="Which cause, by its name; drawn when not given.")
@click.option("--rho", default=0.5, show_default=True, help="Rms over the noise, base apart.")
@click.option("--rows", type=int, help="Recordings of each case.")
@click.option("--noise", help="white, drift, heavy, outliers or gappy.")
@click.option("--site", help="rt32, gmrt or south.")
@click.option(
    "--seed", default=0, show_default=True, help="The first case's; the next has one more."
)
@click.option("--count", default=1, show_default=True, help="How many cases.")
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="Folder.")
def make(
    kind: str,
    effect: str | None,
    rho: float,
    rows: int | None,
    noise: str | None,
    site: str | None,
    seed: int,
    count: int,
    out: Path,
) -> None:
    """Write recordings to OUT/recordings and the truth about them to OUT/truth."""
    from pyport.progress import track
    from pyport.trials.files import write_recordings, write_truth
    from pyport.trials.kinds import make_case

    for each in track(range(seed, seed + count), "making cases", total=count):
        case = make_case(kind, each, effect=effect, rho=rho, rows=rows, noise=noise, site=site)
        stem = "-".join(filter(None, [kind, effect, f"{each:05d}"]))
        write_recordings(case, out / "recordings" / f"{stem}.csv")
        write_truth(case, out / "truth" / f"{stem}.json")
    click.echo(f"{count} cases in {out}")
