"""`pyport trials`: recordings with hidden causes, sealed, solved, opened and scored."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from pyport.trials.examine import Score

LEDGER = Path("docs/proof/ledger.md")
PAGE = Path("docs/proof.md")

_A_PATH = click.Path(path_type=Path)
_jobs = click.option("--jobs", default=1, show_default=True, help="Cases at the same time.")
_ledger = click.option(
    "--ledger",
    type=_A_PATH,
    default=LEDGER,
    show_default=True,
    help="Where every set is written down.",
)
_which = click.option(
    "--set",
    "which",
    type=click.Choice(["small", "full"]),
    default="small",
    show_default=True,
    help="About a hundred cases, or near a thousand.",
)


@click.group()
def command() -> None:
    """Hide causes in simulated recordings, and find out whether they are found.

    A sealed set is a new folder SET; its truths lie in SET.vault until they are opened.
    """


@command.command()
@click.option("--kind", required=True, help="null, one, two, held, unknown, degenerate, ...")
@click.option("--effect", help="Which cause, by its name; drawn when not given.")
@click.option("--rho", default=0.5, show_default=True, help="Rms over the noise, base apart.")
@click.option("--rows", type=int, help="Recordings of each case.")
@click.option("--noise", help="white, drift, heavy, outliers or gappy.")
@click.option("--site", help="rt32, gmrt or south.")
@click.option("--weeks", type=float, help="Length of an ablation's campaign.")
@click.option(
    "--seed", default=0, show_default=True, help="The first case's; the next has one more."
)
@click.option("--count", default=1, show_default=True, help="How many cases.")
@click.option("-o", "--out", type=_A_PATH, required=True, help="Folder to write to.")
def make(
    *,
    kind: str,
    effect: str | None,
    rho: float,
    rows: int | None,
    noise: str | None,
    site: str | None,
    weeks: float | None,
    seed: int,
    count: int,
    out: Path,
) -> None:
    """Write recordings to OUT/recordings and the truth about them to OUT/truth."""
    from pyport.progress import track
    from pyport.trials.files import write_recordings, write_truth
    from pyport.trials.kinds import make_case

    for each in track(range(seed, seed + count), "making cases", total=count):
        case = make_case(
            kind, each, effect=effect, rho=rho, rows=rows, noise=noise, site=site, weeks=weeks
        )
        stem = "-".join(filter(None, [kind, effect, f"{each:05d}"]))
        write_recordings(case, out / "recordings" / f"{stem}.csv")
        write_truth(case, out / "truth" / f"{stem}.json")
    click.echo(f"{count} cases in {out}")


@command.command()
@click.argument("folder", metavar="SET", type=_A_PATH)
@_which
@_ledger
def seal(folder: Path, which: str, ledger: Path) -> None:
    """Draw truths, hide them, and publish the hashes that fix them."""
    from pyport.trials import ledger as book
    from pyport.trials.protocol import SETS
    from pyport.trials.seal import seal as seal_set

    sealed = seal_set(folder, folder.resolve().name, SETS[which]())
    book.enter_seal(ledger, folder, sealed)
    click.echo(f"{len(sealed['cases'])} cases sealed: publish {folder / 'sealed.json'}")


@command.command()
@click.argument("folder", metavar="SET", type=_A_PATH)
@_jobs
def run(folder: Path, jobs: int) -> None:
    """Solve what is not solved yet, each case in a process that cannot see the truth."""
    from pyport.trials.solve import run as solve

    click.echo(f"{solve(folder, jobs)} cases solved")


@command.command()
@click.argument("folder", metavar="SET", type=_A_PATH)
def reveal(folder: Path) -> None:
    """Fix the answers and open the truths."""
    from pyport.trials.seal import reveal as open_set

    click.echo(f"{open_set(folder)} truths opened in {folder / 'opened'}")


@command.command()
@click.argument("folder", metavar="SET", type=_A_PATH)
@_jobs
@_ledger
def score(folder: Path, jobs: int, ledger: Path) -> None:
    """Check every seal, print the score and write it down, good or bad."""
    from pyport.trials import ledger as book
    from pyport.trials.examine import examine

    whole = examine(folder, jobs)
    book.enter_score(ledger, folder, whole)
    show(whole)


@command.command()
@click.argument("folder", metavar="SET", type=_A_PATH)
@_which
@_jobs
@_ledger
@click.pass_context
def prove(context: click.Context, folder: Path, which: str, jobs: int, ledger: Path) -> None:
    """Seal, run, reveal and score, from wherever that was interrupted."""
    if not (folder / "sealed.json").exists():
        context.invoke(seal, folder=folder, which=which, ledger=ledger)
    if not (folder / "answers.json").exists():
        context.invoke(run, folder=folder, jobs=jobs)
    context.invoke(reveal, folder=folder)
    context.invoke(score, folder=folder, jobs=jobs, ledger=ledger)


@command.command()
@click.argument("folders", metavar="SET...", type=_A_PATH, nargs=-1, required=True)
@click.option("-o", "--out", type=_A_PATH, default=PAGE, show_default=True, help="The page.")
def page(folders: tuple[Path, ...], out: Path) -> None:
    """Write the public record of sets that were scored: numbers, pictures, one case by hand."""
    from pyport.trials.page import write

    write(folders, out)
    click.echo(f"{out}")


def show(whole: Score) -> None:
    """Print a score as a table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{whole.name}: {'passed' if whole.passed else 'not passed'}")
    for heading in ("what", "result", "needed", "passed"):
        table.add_column(heading, overflow="fold")
    marks = {True: "yes", False: "NO", None: ""}
    for row in whole.rows:
        table.add_row(row.what, row.result, row.needed, marks[row.passed])
    Console(width=118).print(table)
