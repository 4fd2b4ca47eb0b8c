"""Commands that hold the program against recordings, and files against what they were made of."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import PATH, as_promised, in_json, many_jobs, option, plain, resumable, say
from pyport.errors import BadInput

if TYPE_CHECKING:
    from pyport.examiner.acceptance.drawn import Line

_public = option(
    "--data",
    "Folder of public recordings; missing sets are listed.",
    Path("../shared/data"),
    type=PATH,
)


@click.command("acceptance", epilog="Example: pyport dev acceptance --jobs 2 --data ../shared/data")
@option("--data", "Folder of others' recordings.", type=PATH)
@many_jobs
@option("--seed", "Where the cases' seeds begin.", 10_000)
@in_json
def acceptance(data: Path | None, jobs: int, seed: int, *, as_json: bool) -> None:
    """Measure what is promised of a diagnosis, on real and simulated recordings.

    Each line says what came out, what was asked for, and whether it did.
    Recordings and surveys of others are looked for in DATA; what is not there is
    said to be left out.
    """
    for line in _lines(data if data is not None and data.is_dir() else None, data, jobs, seed):
        if as_json:
            click.echo(json.dumps(vars(line)))
        else:
            mark = {True: "yes", False: "NO", None: ""}[line.passed]
            click.echo(f"{mark:3}  {line.what}: {line.value} ({line.wanted})")


def _lines(there: Path | None, data: Path | None, jobs: int, seed: int) -> Iterator[Line]:
    from pyport.examiner.acceptance import drawn, gains, real
    from pyport.recordings.files import read_survey

    survey = None if there is None else read_survey(there / "gmrt" / "antennas_enu.csv")
    yield from drawn.array_lines(survey)
    if there is not None:
        yield from real.lines(there)
    else:
        yield drawn.Line("others' recordings", "left out", f"no folder {data}", None)
    yield from drawn.jump_lines(seed)
    yield from gains.lines(jobs, seed)
    yield from drawn.lines(jobs, seed)


@click.command("real", epilog="Example: pyport dev real --data ../shared/data --jobs 2")
@_public
@option("--sets", "Sets whose names begin so, separated by commas; all by default.")
@option("--subsets", "Subsets of few rows of each set.", 200)
@many_jobs
@resumable("out/real")
@option("--markdown", "Write the table as a page.", type=PATH)
@in_json
def real(
    data: Path,
    sets: str | None,
    subsets: int,
    jobs: int,
    out: Path,
    markdown: Path | None,
    *,
    as_json: bool,
) -> None:
    """Run fit and diagnose on public recordings, beside what was published of them.

    A row a set: scatter of the fit over Huber least squares of the same terms, sigmas and
    findings against halves of the nights, what predicts worse, and in how many of SUBSETS
    random subsets of 15 to 40 rows.
    """
    from pyport.examiner.real import table
    from pyport.files import write_file

    try:
        entries = table.chosen([one.strip() for one in (sets or "").split(",") if one.strip()])
    except KeyError as error:
        raise BadInput(f"no set of recordings is called {error.args[0]!r}") from None
    rows, absent = [], []
    for one in table.rows(entries, data, subsets, out / "real.jsonl", jobs):
        if isinstance(one, str):
            absent.append(one)
            continue
        rows.append(one)
        click.echo(json.dumps(dataclasses.asdict(one)) if as_json else table.of_set(one) + "\n")
    order = [one["name"] for one in entries]
    rows.sort(key=lambda row: order.index(row.name))
    if markdown is not None:
        write_file(markdown, table.markdown(rows, absent))
    if not as_json:
        click.echo(table.text(rows, absent))


@click.command("replays", epilog="Example: pyport dev replays --data ../shared/data")
@_public
@as_promised
@in_json
def replays(data: Path, rarity: float, *, as_json: bool) -> None:
    """Replay public recordings in the order of time; say what is raised, and what is known.

    The first ten pointings for each coefficient stand for the past, and three nights where that
    leaves half; of an array its first day.
    """
    from pyport.examiner.nights import replays as replayed

    found = []
    for one in replayed.replays(data, rarity):
        found.append(one)
        as_line = json.dumps(plain(dataclasses.asdict(one))) if as_json else None
        click.echo(as_line or replayed.text(one) + "\n")
    if not as_json:
        click.echo(replayed.total(found, rarity))


@click.command("field-system", epilog="Example: pyport dev field-system field_system")
@click.argument("folder", type=click.Path(path_type=Path, exists=True, file_okay=False))
@in_json
def field_system(folder: Path, *, as_json: bool) -> None:
    """Compare pyport with what the Field System computed, as kept in FOLDER.

    Unit responses of P1..P30 (fs_fln_flt_grid.csv) and fits: each NAME.xtr
    fitted by mdlpo.ctl beside NAME.err.
    """
    from pyport.formats.field_system import agreement
    from pyport.runs.stages import working

    with working("comparing"):
        say(
            lambda: "\n".join(agreement.text(folder)),
            lambda: agreement.as_json(folder),
            as_json=as_json,
        )


@click.command("verify", epilog="Example: pyport dev verify diagnosis/offsets")
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True)
@in_json
def verify(folders: tuple[str, ...], *, as_json: bool) -> None:
    """Check that the files in a diagnosis's FOLDER are those that its report was written with.

    They are not where a run was stopped while it wrote, or where somebody changed one since.
    """
    from pyport.report.folder import check

    found = {folder: check(Path(folder)) for folder in folders}
    lines = [f"{folder}: report.json and {n} files of one run" for folder, n in found.items()]
    say("\n".join(lines), found, as_json=as_json)


@click.group("reduction")
def reduction() -> None:
    """Take nutation, aberration, UT1, polar motion, refraction out of offsets, each by its name."""


@reduction.command(epilog="Example: pyport dev reduction sizes")
@in_json
def sizes(*, as_json: bool) -> None:
    """Print how large each step was in the RT32's campaigns, beside the document's figures."""
    from pyport.runs.stages import working
    from pyport.studies.rt32 import reduction_sizes as all_of_them

    with working("sizing each step"):
        say(all_of_them.text, all_of_them.as_json, as_json=as_json)


@reduction.command(
    epilog="Example: pyport dev reduction apply raw.csv out.csv --steps nutation,ut1"
)
@click.argument("recordings")
@click.argument("out", type=click.Path(path_type=Path))
@option("--steps", "Names with commas between; the document's six when not given.")
@in_json
def apply(recordings: str, out: Path, steps: str | None, *, as_json: bool) -> None:
    """Write RECORDINGS to OUT with offsets free of what the steering program left out."""
    from pyport.recordings import read, resolve, write
    from pyport.studies.rt32.reduction import DOCUMENT, reduced

    taken = DOCUMENT if steps is None else tuple(filter(None, steps.split(",")))
    done = reduced(read(resolve(recordings)), taken)
    write(done, out)
    answer = {"file": out, "recordings": len(done), "taken_out": taken}
    say(f"{len(done)} recordings in {out}, free of {', '.join(taken)}", answer, as_json=as_json)
