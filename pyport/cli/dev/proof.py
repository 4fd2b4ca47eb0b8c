"""`pyport dev prove`: a proof in three commits."""

from __future__ import annotations

from pathlib import Path

import click

from pyport.cli.manners import PATH, in_json, option, say
from pyport.errors import BadInput

_NEXT = (
    "no answer was given yet; commit the seal alone",
    "no truth is open yet; commit the answers alone",
    "everything is open; commit it",
)


@click.command("prove", epilog="Example: pyport dev prove --set small --name spring --jobs 2")
@option("--set which", "About 150 cases, or about 1,600.", "small", of="small full")
@option("--name", "What the set is called.")
@option("--jobs", "Cases at the same time.", 1)
@option("--sets", "Folder of published sets, in a repository.", Path("docs/proof/sets"), type=PATH)
@option("--out", "Folder of recordings, reports and sealed truths.", Path("out/sets"), type=PATH)
@option("--verify", "Check the set of this name from the history.", metavar="NAME")
@option("--again", "How many cases --verify makes and judges again, or all.", "20")
@in_json
def prove(
    which: str,
    name: str | None,
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
    from pyport.examiner.sealed.protocol import SETS
    from pyport.examiner.sealed.prove import STAGES, Plan, advance

    step = advance(Plan(name, sets / name, out / name, SETS[which], jobs))
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
