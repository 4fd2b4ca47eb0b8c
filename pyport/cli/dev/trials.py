"""`pyport dev trials`: recordings with hidden causes, sealed, solved, opened and scored."""

from __future__ import annotations

import contextlib
import io
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pyport.cli.manners import PATH, in_json, many_jobs, option, say

if TYPE_CHECKING:
    from pyport.examiner.sealed.examine import Score

DATA = Path("../shared/data")

_data = option(
    "--data",
    "Folder of public recordings, for their noise; those shipped where it is not there.",
    DATA,
    type=PATH,
)
_which = option(
    "--set which",
    "About a hundred and fifty cases, or seventeen hundred.",
    "small",
    of="small full",
)


@click.group()
def command() -> None:
    """Put causes into simulated recordings, and check whether a diagnosis finds them.

    A sealed set is a new folder SET; its truths lie in SET.vault until they are opened.
    """


@command.command(epilog="Example: pyport dev trials make --kind one --effect refraction -o cases")
@option("--kind", "null, one, two, held, unknown, degenerate, ...", required=True)
@option("--effect", "Which cause, by its name; drawn when not given.")
@option("--rho", "Rms of the cause over that of the noise.", 0.5)
@option("--rows", "Recordings of each case.", type=int)
@option("--noise", "white, drift, gappy, or another of `pyport dev nulls`.")
@option("--site", "rt32, gmrt or south.")
@option("--weeks", "Length of an ablation's campaign.", type=float)
@option("--sky", "radio, grid, one or clustered.")
@option("--mount", "german, fork, xy-ns or xy-ew.")
@option("--model", "tpoint.mod, mdlpo.ctl or rt32-3model; written to OUT where it is a file.")
@option("--little", "place or time: what the file has.")
@option("--real", "The set of real recordings whose noise it is.")
@option("--data", "Folder of those that are not shipped.")
@option("--seed", "Seed of the first case; each next one has one more.", 0)
@option("--count", "How many cases.", 1)
@option("-o --out", "Folder to write to.", type=PATH, required=True)
@in_json
def make(
    *,
    kind: str,
    effect: str | None,
    seed: int,
    count: int,
    out: Path,
    as_json: bool,
    **asked: Any,  # noqa: ANN401 - fields of `Spec`
) -> None:
    """Write recordings to OUT/recordings and the truth about them to OUT/truth."""
    from pyport.examiner.sealed.record.files import write_recordings, write_truth
    from pyport.examiner.worlds.kinds import files_of, make_case
    from pyport.files import write_file
    from pyport.runs.stages import track

    for each in track(range(seed, seed + count), "making cases", total=count):
        case = make_case(kind, each, effect=effect, **asked)
        stem = "-".join(filter(None, [kind, effect, f"{each:05d}"]))
        write_recordings(case, out / "recordings" / f"{stem}.csv")
        write_truth(case, out / "truth" / f"{stem}.json")
        for name, text in files_of(case.arguments).items():
            write_file(out / name, text)
    say(f"{count} cases in {out}", {"cases": count, "folder": out}, as_json=as_json)


@command.command(epilog="Example: pyport dev trials seal out/set")
@click.argument("folder", metavar="SET", type=PATH)
@_which
@_data
@in_json
def seal(folder: Path, which: str, data: Path, *, as_json: bool = False) -> None:
    """Draw truths, hide them, and publish the hashes that fix them."""
    from pyport.examiner.sealed.protocol import SETS, there
    from pyport.examiner.sealed.seal import seal as seal_set

    sealed = seal_set(folder, folder.resolve().name, SETS[which](there(data)))
    text = f"{len(sealed['cases'])} cases sealed: {folder / 'sealed.json'}"
    answer = {"cases": len(sealed["cases"]), "publish": folder / "sealed.json"}
    say(text, answer, as_json=as_json)


@command.command(epilog="Example: pyport dev trials run out/set --jobs 2")
@click.argument("folder", metavar="SET", type=PATH)
@many_jobs
@option("--cluster", "A Dask scheduler whose workers share the work.", metavar="ADDRESS")
@in_json
def run(folder: Path, jobs: int, cluster: str | None, *, as_json: bool = False) -> None:
    """Solve what is not solved yet, each case in a process that cannot see the truth."""
    from pyport.examiner.sealed.solve import run as solve

    solved = solve(folder, jobs, cluster=cluster)
    say(f"{solved} cases solved", {"solved": solved}, as_json=as_json)


@command.command(epilog="Example: pyport dev trials reveal out/set")
@click.argument("folder", metavar="SET", type=PATH)
@in_json
def reveal(folder: Path, *, as_json: bool = False) -> None:
    """Fix the answers and open the truths."""
    from pyport.examiner.sealed.seal import reveal as open_set

    opened = open_set(folder)
    text = f"{opened} truths opened in {folder / 'opened'}"
    say(text, {"opened": opened, "folder": folder / "opened"}, as_json=as_json)


@command.command(epilog="Example: pyport dev trials score out/set")
@click.argument("folder", metavar="SET", type=PATH)
@many_jobs
@in_json
def score(folder: Path, jobs: int, *, as_json: bool = False) -> None:
    """Check every seal, print the score and write it to SET/score.json, good or bad."""
    from pyport.examiner.sealed.examine import examine

    whole = examine(folder, jobs)
    if as_json:
        from pyport.examiner.sealed.examine import as_json as answer_of

        say("", answer_of(whole), as_json=True)
    else:
        show(whole)


@command.command(epilog="Example: pyport dev trials prove out/set --set small --jobs 2")
@click.argument("folder", metavar="SET", type=PATH)
@_which
@_data
@many_jobs
@in_json
@click.pass_context
def prove(
    context: click.Context, folder: Path, which: str, data: Path, jobs: int, *, as_json: bool
) -> None:
    """Seal, run, reveal and score, from wherever that was interrupted: a rehearsal, kept nowhere.

    `pyport dev prove` leaves a proof in the history.
    """
    with contextlib.redirect_stdout(io.StringIO() if as_json else sys.stdout):
        if not (folder / "sealed.json").exists():
            context.invoke(seal, folder=folder, which=which, data=data)
        if not (folder / "answers.json").exists():
            context.invoke(run, folder=folder, jobs=jobs)
        context.invoke(reveal, folder=folder)
    context.invoke(score, folder=folder, jobs=jobs, as_json=as_json)


@command.command(epilog="Example: pyport dev trials page")
@option("--docs", "Folder of the manual.", Path("docs"), type=PATH)
@option("--readme", "The README.", Path("README.md"), type=PATH)
@option("--data", "Folder of public recordings: the case studies' pictures, too.", type=PATH)
@in_json
def page(docs: Path, readme: Path, data: Path | None, *, as_json: bool) -> None:
    """Write the public record: page, ledger and README from all published sets, DOCS/proof/sets.

    What DOCS/real.md has of real recordings is put into the case studies.
    """
    from pyport.cli.dev.listed import rewrite
    from pyport.examiner.real import studies
    from pyport.examiner.sealed.scoring import page as book
    from pyport.files import write_file

    sets = book.published(docs / "proof" / "sets")
    write_file(docs / "proof.md", book.proof(sets, docs))
    rewrite(docs / "proof" / "ledger.md", "sets", book.ledger(sets))
    rewrite(readme, "proof", book.readme(sets))
    real = (docs / "real.md").read_text(encoding="utf-8")
    for path in sorted((docs / "proof").glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if (anew := studies.filled(text, real)) != text:
            write_file(path, anew)
    if data is not None:
        for study in studies.PICTURES:
            click.echo(studies.draw(study, data, docs / "proof" / f"{study}.png"))
    say(f"{docs / 'proof.md'}", {"page": docs / "proof.md"}, as_json=as_json)


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
