"""`pyport fit`: the coefficients of a model, and what they leave."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pyport.cli.manners import PATH, about_file, beside_model, flag, option, say
from pyport.cli.manners import recordings as named

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from pyport.fitting.fit import Fit
    from pyport.page.picture import Picture
    from pyport.page.story import Story
    from pyport.recordings.raw import FileOptions

    Drawn: TypeAlias = Callable[[], tuple[Picture, Story]]


@click.command("fit", epilog="Example: pyport fit offsets.csv --out fit")
@click.argument("recordings", shell_complete=named)
@beside_model
@option("--method", "For rt32-exact and rt32-approximate: document, soft-l1, huber or student-t.")
@option(
    "--box-step",
    "With --method: the box offset before 2004 less that after; known, fit or degrees.",
    "known",
)
@option(
    "--level level_deg",
    "With --method document: exclude residuals beyond this many degrees.",
    0.007,
    type=click.FloatRange(min=0, min_open=True),
)
@flag("--in-use", "The offsets are what the model left while it was in use: it is added back.")
@option("--fix", "Hold a term: IE=0, P7=0.06deg.", multiple=True, metavar="NAME=VALUE")
@option("--add", "Fit a further term: TF, P11, sag_sine.", multiple=True, metavar="NAME")
@option("--drop", "Leave a term of the model out.", multiple=True, metavar="NAME")
@option(
    "--weights",
    "Weight by the noise estimated with the fit, or all readings equally, as TPOINT does.",
    "robust",
    of="robust equal",
)
@option(
    "--per",
    "Fit separate coefficients for each value of these labels.  [default: antenna]",
    metavar="LABEL,LABEL",
)
@about_file
@option("--save", "Write the model: .mod, .ctl, ...", type=PATH)
@option("--out", "Folder: fit.json, report.html, residuals.csv.", type=PATH)
@flag("--json as_json", "Print JSON.")
def command(
    recordings: str,
    model: str,
    method: str | None,
    box_step: str,
    level_deg: float,
    fix: tuple[str, ...],
    add: tuple[str, ...],
    drop: tuple[str, ...],
    weights: str,
    per: str | None,
    given: FileOptions,
    save: Path | None,
    out: Path | None,
    *,
    in_use: bool,
    as_json: bool,
) -> None:
    """Fit a pointing model to RECORDINGS and print its coefficients with their sigmas.

    Terms go by TPOINT's names, the Field System's, or the ids of `pyport dev effects`.
    """
    if method is not None:
        if fix or add or drop or save or per or in_use or weights != "robust":
            raise click.UsageError(
                "--method fits all twelve from nothing: leave --fix, --add, --drop, --per, "
                "--weights, --in-use, --save out"
            )
        if model not in {"rt32-exact", "rt32-approximate"}:
            raise click.UsageError(
                f"--method fits rt32-exact or rt32-approximate, not {model}: leave it out"
            )
        exact = model == "rt32-exact"
        report, text, drawn = _fit_rt32(recordings, given, method, box_step, level_deg, exact=exact)
        _show(report, text, out, as_json=as_json)
        _write_page(drawn, out)
        return
    from pyport.files import write_whole
    from pyport.fitting import table
    from pyport.fitting.fit import completed, fit, write_rows
    from pyport.formats.completed import write_model
    from pyport.formats.models import load
    from pyport.models.terms.editing import edited
    from pyport.page.of_fit import of_fit
    from pyport.recordings import read
    from pyport.recordings.stream import pass_files
    from pyport.runs.stages import working

    labels = None if per is None else tuple(one.strip() for one in per.split(",") if one.strip())
    unfitted = load(model)
    with working("fitting"):
        measured = read(recordings, given, beside=out)
        if in_use:
            measured = unfitted.added_to(measured)
        chosen = edited(unfitted.on(measured.at.mount), fix=fix, add=add, drop=drop, per=labels)
        done = fit(measured, chosen, weights=weights)
    if save is not None:
        saved = write_model(completed(done), save)[2].words
        click.echo(f"{save}: {saved}\n" * bool(saved), err=True, nl=False)
    if out is not None:
        with write_whole(out / "residuals.csv") as file:
            write_rows(done, file)
    _show(table.as_json(done), table.text(done), out, as_json=as_json)
    _write_page(lambda: of_fit(done), out)
    if out is not None:
        for kept in pass_files(out):
            kept.unlink(missing_ok=True)
    if not as_json and model == "gmrt-paper":
        _say_beside_paper(done)


def _say_beside_paper(done: Fit) -> None:
    """Print what the report gives of the same days, where they are its days."""
    from pyport.studies.gmrt import comparison
    from pyport.studies.gmrt.refits import beside_table_18

    if days := beside_table_18(done):
        click.echo("\n" + comparison.text(days))


def _write_page(drawn: Drawn, out: Path | None) -> None:
    """Leave the page in a folder where one is asked for."""
    if out is not None:
        from pyport.page import write

        write(*drawn(), out / "report.html")


def _fit_rt32(
    recordings: str, given: FileOptions, method: str, choice: str, level_deg: float, *, exact: bool
) -> tuple[dict[str, object], str, Drawn]:
    """Fit p1..p12 from nothing; return it for programs, as the RT32's table, and for the page."""
    from pyport.angles import DEG
    from pyport.recordings import read
    from pyport.runs.stages import working
    from pyport.studies.rt32 import box_step, document, fit_rt32
    from pyport.studies.rt32.fit import honest_sigmas
    from pyport.studies.rt32.sky import of_rt32

    measured = read(recordings, given)
    box = box_step(measured, choice)
    with working("fitting"):
        done = fit_rt32(measured, exact=exact, method=method, level=level_deg * DEG, box=box)
        honest = honest_sigmas(done)
    text = f"{document.text(done, honest)}\n\ncorrelations\n{document.correlations(done)}"
    return document.as_json(done, honest), text, lambda: of_rt32(done, honest)


def _show(report: dict[str, object], text: str, out: Path | None, *, as_json: bool) -> None:
    """Print a fit as text or JSON, and leave the JSON in a folder where one is asked for."""
    from pyport.pointing import kernel

    whole = report | {"computed_with": kernel.path()}
    say(text, whole, as_json=as_json, file=out and out / "fit.json")
