"""Commands that draw cases and count what comes out; an interrupted run goes on where it was."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from pyport.cli.manners import as_promised, counted, in_json, many_jobs, option, resumable, say
from pyport.errors import BadInput

Outcomes = list[dict[str, Any]]


def _drawn(folder: str, cases: int, each: str, seed: int) -> Callable[[Callable[..., Any]], Any]:
    """Return what adds the options of commands that draw cases: how many, from where, into what."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for one in (
            in_json,
            resumable(folder),
            many_jobs,
            option("--seed", "Seed of everything random.", seed),
            option("--cases", f"Cases of {each}.", cases),
        ):
            command = one(command)
        return command

    return add


def _among(given: str | None, known: Iterable[str], what: str) -> tuple[str, ...]:
    """Return the names given, separated by commas, all of them for none."""
    names = tuple(given.split(",")) if given else tuple(known)
    for name in names:
        if name not in known:
            raise BadInput(f"no {what} is called {name!r}; there are {', '.join(known)}")
    return names


def _run(
    wanted: Sequence[Any],
    examine: Callable[[Any], dict[str, Any]],
    kept: Path,
    jobs: int,
    *,
    as_json: bool = False,
) -> Outcomes:
    """Return the outcomes of all cases, each printed as a JSON line when it is there."""
    from pyport.examiner import scores

    found = []
    for one in counted(scores.run(wanted, examine, kept, jobs), len(wanted)):
        found.append(one)
        if as_json:
            click.echo(json.dumps(one))
    return found


@click.command("calibrate", epilog="Example: pyport dev calibrate FAMILY_ERROR --cases 10")
@click.argument(
    "names",
    nargs=-1,
    type=click.Choice(["FAMILY_ERROR", "CONVINCING", "coverage"]),
    metavar="[NAME]...",
)
@option("--into", "The page to rewrite.", type=click.Path(exists=True, dir_okay=False))
@_drawn("out/calibrate", 200, "each kind of noise", 7)
def calibrate(
    names: tuple[str, ...],
    into: str | None,
    cases: int,
    seed: int,
    jobs: int,
    out: Path,
    *,
    as_json: bool,
) -> None:
    """Draw noise with nothing in it; count false alarms against each threshold, and coverage.

    NAME is FAMILY_ERROR, CONVINCING or coverage, all three by default; one run of cases serves
    them all. With --into the tables of that page are written anew.
    """
    from pyport.cli.dev.listed import rewrite
    from pyport.examiner.acceptance import calibrate as calibration
    from pyport.examiner.nulls import noises, nulls

    wanted = nulls.cases(noises.KINDS, cases, seed, (nulls.NULL,))
    found = _run(wanted, calibration.examine, out / "calibrate.jsonl", jobs)
    order = {kind: n for n, kind in enumerate(noises.KINDS)}
    found.sort(key=lambda one: (order[one["kind"]], one["number"]))
    tables = [calibration.text(name, found) for name in names or calibration.LEVELS]
    if into is None:
        say("\n\n".join(tables), found, as_json=as_json)
    else:
        text = "".join(f"```text\n{one}\n```\n\n" for one in tables)
        rewrite(Path(into), "calibration", text)


@click.command("efficiency", epilog="Example: pyport dev efficiency --rows 100,300 --rho 0.5")
@option("--effects", "Causes, separated by commas; all by default.")
@option("--rows", "Numbers of recordings, separated by commas; 60 to 2400 by default.")
@option("--rho", "Visible rms over the noise, separated by commas; 0.25, 0.5 and 1.")
@_drawn("out/efficiency", 1, "each cause in each cell", 4000)
def efficiency(
    effects: str | None,
    rows: str | None,
    rho: str | None,
    cases: int,
    seed: int,
    jobs: int,
    out: Path,
    *,
    as_json: bool,
) -> None:
    """Hide one cause in simulated recordings; hold what is found against the ideal observer.

    The observer knows the form of the cause and the noise, pays for every effect that could be
    tested, and makes false alarms as often. Efficiency is detections, or right names, over the
    detections that it would make.
    """
    from pyport.examiner.ideal import efficiency as ideal
    from pyport.examiner.worlds.kinds import HIDEABLE

    names = _among(effects, HIDEABLE, "cause")
    try:
        sizes = [int(one) for one in rows.split(",")] if rows else list(ideal.ROWS)
        loud = [float(one) for one in rho.split(",")] if rho else list(ideal.RHOS)
    except ValueError as error:
        raise BadInput(f"{error}, expected numbers separated by commas") from None
    wanted = ideal.cases(names, loud, sizes, cases, seed)
    found = _run(wanted, ideal.examine, out / "efficiency.jsonl", jobs, as_json=as_json)
    if not as_json:
        click.echo(ideal.text(found))


@click.command("cosines", epilog="Example: pyport dev cosines --cases 2")
@_drawn("out/cosines", 3, "each form", 500)
def cosines(cases: int, seed: int, jobs: int, out: Path, *, as_json: bool) -> None:
    """Measure the largest cosine of each unknown form with what the program has a name for.

    Beside the model, in noiseless recordings. A form is fair where no name takes nearly all of it.
    """
    from pyport.examiner.acceptance import cosines as measured

    found = _run(
        measured.cases(cases, seed), measured.examine, out / "cosines.jsonl", jobs, as_json=as_json
    )
    if not as_json:
        click.echo(measured.text(found))


@click.command("mounts", epilog="Example: pyport dev mounts --cases 60 --jobs 2")
@option("--mounts named", "Mounts, separated by commas; all by default.")
@option("--parts", "empty, one, two, unknown, separated by commas; all by default.")
@_drawn("out/mounts", 60, "each mount and part", 1)
def mounts(
    named: str | None,
    parts: str | None,
    cases: int,
    seed: int,
    jobs: int,
    out: Path,
    *,
    as_json: bool,
) -> None:
    """Hide causes in drawn sessions of German, fork and X-Y mounts, and count what is found.

    The classical terms are fitted; one cause, or two, or one without a name, shows half of the
    noise beside them, or nothing is hidden. 98 % of the empty sessions are to stay silent, 95 % of
    the single causes to be named.
    """
    from pyport.examiner.mounts import examine

    chosen = _among(named, examine.MOUNTS, "mount"), _among(parts, examine.PARTS, "part")
    wanted = examine.cases(*chosen, cases, seed)
    found = _run(wanted, examine.examine, out / "mounts.jsonl", jobs, as_json=as_json)
    if not as_json:
        click.echo(examine.text(found))


@click.command("nights", epilog="Example: pyport dev nights --nulls 1000 --steps 1000")
@option("--nulls", "Nights without any change.", 1000)
@option("--steps", "Steps of one to five sigmas.", 1000)
@option("--wilder", "Nights that drift twice and four times as far.", 200)
@option("--seed", "Seed of everything random.", 1)
@as_promised
@resumable("out/nights")
@in_json
def nights(
    nulls: int, steps: int, wilder: int, seed: int, rarity: float, out: Path, *, as_json: bool
) -> None:
    """Count false alarms in twenty kinds of noise, and measure delays beside the best possible.

    Five nights of each case are the past, five are watched. The best possible delay is that of
    a CUSUM that knows the step's shape and size, the noise and the model, with as few false alarms.
    """
    from pyport.examiner.nights import nights as drawn
    from pyport.examiner.nights import replays

    cases = [*drawn.null_cases(nulls, seed), *drawn.step_cases(steps, seed)]
    cases += drawn.wilder_cases(wilder, seed)
    found = list(counted(replays.outcomes(cases, out / "nights.jsonl", rarity), len(cases)))
    if as_json:
        click.echo(json.dumps(found))
        return
    still = [one for one in found if not one["step"]]
    if nulls:
        click.echo(replays.of_nulls((one for one in still if one["wilder"] == 1), rarity))
    if steps:
        click.echo("\n" + replays.of_steps(one for one in found if one["step"]))
    if wilder:
        click.echo("\n" + replays.of_nulls((one for one in still if one["wilder"] > 1), rarity))


@click.command("nulls", epilog="Example: pyport dev nulls --cases 100 --jobs 2")
@option("--kinds", "Kinds of noise, separated by commas; all by default.")
@option("--part", "Nothing hidden, one cause, or both.", "all", of="all null cause")
@option(
    "--by",
    "Another table: one line for each of these, over all kinds.",
    of="rows sessions sky cause",
)
@_drawn("out/nulls", 100, "each kind and part", 1)
def nulls(
    kinds: str | None,
    part: str,
    by: str | None,
    cases: int,
    seed: int,
    jobs: int,
    out: Path,
    *,
    as_json: bool,
) -> None:
    """Count claims where nothing is hidden, and how often sigmas hold, in twenty kinds of noise.

    At most 3 % of the cases with nothing hidden may claim something; 64 to 72 % of the
    coefficients lie within one sigma of the truth, 93 to 97 % within two. Outcomes are kept in
    OUT/nulls.jsonl, and count for the program that they came from alone.
    """
    from pyport.examiner.nulls import noises, nulls_table
    from pyport.examiner.nulls import nulls as drawn

    chosen = _among(kinds, noises.KINDS, "kind of noise")
    wanted = drawn.cases(
        chosen, cases, seed, (drawn.NULL, drawn.CAUSE) if part == "all" else (part,)
    )
    found = _run(wanted, drawn.examine, out / "nulls.jsonl", jobs, as_json=as_json)
    if as_json:
        return
    of_kinds = _grouped(found, "kind")
    click.echo(nulls_table.text([nulls_table.line(kind, of_kinds[kind]) for kind in chosen]))
    if by is not None:
        lines = sorted(
            _grouped(found, by).items(), key=lambda one: (str(type(one[0])), one[0] or 0)
        )
        table = nulls_table.text([nulls_table.line(f"{by} {n}", all_) for n, all_ in lines])
        click.echo(f"\n{table}")


def _grouped(found: Outcomes, by: str) -> defaultdict[Any, Outcomes]:
    groups = defaultdict(list)
    for one in found:
        groups[one[by]].append(one)
    return groups
