"""`pyport dev prove`, `challenge`: sealed cases for the program, and for any other."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.dev.trials import DATA
from pyport.cli.manners import PATH, flag, in_json, many_jobs, option, say
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.examiner.sealed.scoring.overall import Row

_NEXT = (
    "no answer was given yet; commit the seal alone",
    "no truth is open yet; commit the answers alone",
    "everything is open; commit it",
)


@click.command("prove", epilog="Example: pyport dev prove --set small --name spring --jobs 2")
@option("--set which", "About 150 cases, or about 1,600.", "small", of="small full")
@option("--name", "What the set is called.")
@option("--data", "Folder of public recordings, for their noise.", DATA, type=PATH)
@many_jobs
@option("--sets", "Folder of published sets, in a repository.", Path("docs/proof/sets"), type=PATH)
@option("--out", "Folder of recordings, reports and sealed truths.", Path("out/sets"), type=PATH)
@option("--verify", "Check the set of this name from the history.", metavar="NAME")
@option("--again", "How many cases --verify makes and judges again, or all.", "20")
@in_json
def prove(
    which: str,
    name: str | None,
    data: Path,
    jobs: int,
    sets: Path,
    out: Path,
    verify: str | None,
    again: str,
    *,
    as_json: bool,
) -> None:
    """Seal, answer, open: go on with a proof as far as the next commit.

    Each call leaves files in SETS/NAME and says what to commit; the next one goes on when that is
    in the history. A call that was interrupted goes on where it was. The baselines answer the
    same cases.
    """
    if verify is not None:
        _verify(sets / verify, again, jobs, as_json=as_json)
        return
    if not name:
        raise BadInput("which set? expected --name NAME or --verify NAME")
    from pyport.examiner.sealed.protocol import SETS, there
    from pyport.examiner.sealed.prove import STAGES, Plan, advance

    step = advance(Plan(name, sets / name, out / name, partial(SETS[which], there(data)), jobs))
    files = " ".join(map(str, step.commit))
    if step.commit:
        text = (
            f"{step.stage} of {len(STAGES)}: {_NEXT[step.stage - 1]}:\n  git add {files}\n"
            f'  git commit -m "{step.what} {name}" -- {files}'
        )
    else:
        text = f"{name} is proved: pyport dev prove --verify {name} --again all"
    say(text, {"stage": step.stage, "commit": [*map(str, step.commit)]}, as_json=as_json)


def _verify(place: Path, again: str, jobs: int, *, as_json: bool) -> None:
    """Print every check; exit status 1 where one fails."""
    from pyport.examiner.sealed.verify import verify

    if again != "all" and not again.isdecimal():
        raise BadInput(f"--again is {again!r}, expected a number or all")
    checks = []
    for one in verify(place, None if again == "all" else int(again), jobs):
        checks.append(one)
        if not as_json:
            click.echo(f"{'yes' if one.passed else 'NO':3}  {one.what}: {one.said}")
    if as_json:
        say("", checks, as_json=True)
    if not all(one.passed for one in checks):
        raise SystemExit(1)


@click.command(
    "challenge", epilog="Example: pyport dev challenge --seed 7 --cases 40 out/challenge"
)
@click.argument("folder", metavar="OUT", type=PATH)
@click.argument("answers", metavar="[ANSWERS]...", nargs=-1)
@option("--seed", "What everything is drawn from; who is to answer does not know it.")
@option("--cases", "How many.", 40)
@flag("--score", "Score ANSWERS: files, and bic, lasso, pyport, who answer now.")
@many_jobs
@in_json
def challenge(
    folder: Path,
    answers: tuple[str, ...],
    seed: int | None,
    cases: int,
    jobs: int,
    *,
    score: bool,
    as_json: bool,
) -> None:
    """Write recordings of hidden causes to OUT, for any program to solve, and score answers.

    OUT/README.md says what is asked and how it is answered. The key lies in OUT.vault: it is kept
    back, and --score needs it.
    """
    from pyport.examiner.sealed import challenge as challenges

    if not score:
        if seed is None or answers:
            raise BadInput("expected --seed N, or --score and ANSWERS")
        sealed = challenges.challenge(folder, seed, cases)
        count = len(sealed["cases"])
        text = f"{count} cases in {folder}; the key is in {folder}.vault: keep it back"
        say(text, {"cases": count, "folder": folder}, as_json=as_json)
        return
    if not answers:
        raise BadInput("whose answers? expected files, or bic, lasso, pyport")
    scored = challenges.scores(folder, answers, jobs)
    say(lambda: _table(scored), scored, as_json=as_json)


def _table(scored: dict[str, list[Row]]) -> str:
    """Return the rows of several, side by side, as Markdown."""
    from pyport.examiner.sealed.challenge import beside

    lines = [f"| what | needed | {' | '.join(scored)} |", "|---|---|" + "---|" * len(scored)]
    for what, needed, rows in beside(scored):
        cells = [rows[by].result if by in rows else "-" for by in scored]
        lines.append(f"| {what} | {needed} | {' | '.join(cells)} |")
    return "\n".join(lines)
