"""`pyport demo`: parity, the steering table, real recordings and an equatorial session, once."""

from __future__ import annotations

import json
from pathlib import Path

import click

from pyport.cli.manners import PATH, in_json, option, say

#: The paper left physics out of these; each is diagnosed against the paper's own model.
RECORDINGS = (
    "gmrt-2003-05-31",
    "gmrt-2003-06-01",
    "gmrt-2003-06-02",
    "gmrt-2003-06-05",
    "gmrt-cyg-a",
)


#: The equatorial session: the cause, the mount, the rows and the seed.
EQUATORIAL = ("declination_axis_flexure", "german", 400, 1)


@click.command("demo", epilog="Example: pyport demo --out out")
@option("--out", "Folder for the table, the reports and the pictures.", "out", type=PATH)
@in_json
def command(out: Path, *, as_json: bool) -> None:
    """Show everything once: parity, table, recordings, an equatorial session, a night watched."""
    from pyport import legacy, pipeline, steering
    from pyport.parity.report import summary
    from pyport.runs.stages import working

    tell = click.echo if not as_json else (lambda *_, **__: None)
    tell(click.style("1. Is the port the published program?\n", bold=True))
    with working("asking both ports"):
        agreement = summary(legacy.PARITY)
    tell(agreement)

    tell(click.style("\n2. The steering table, made anew\n", bold=True))
    table = out / "3model.txt"
    with working("tabulating"):
        made = steering.tabulate("rt32-3model", steering.DEFAULT_REFRACTION)
        steering.write_ascii(made, table)
        checked = steering.check()
    tell(f"{table}: {len(steering.RT32_GRID)} rows")
    for result in checked:
        tell(f"  {result.block.name:<38}{result.agree:4d} of {result.total} printed cells")

    tell(
        click.style(
            "\n3. What did the paper's model leave out of the GMRT's recordings?", bold=True
        )
    )
    wanted = pipeline.requests(RECORDINGS, model="gmrt-paper", refit="all", seed=0, out=out)
    reports = []
    for done in pipeline.run_all(wanted):
        reports.append(json.loads(done.report))
        tell("\n" + done.summary)
    tell(f"\nReports, rows and pictures: {out}/gmrt-*/ (open report.html in a browser)")

    tell(click.style("\n4. What does the classical model leave out on a German mount?", bold=True))
    night, hidden = _equatorial(out)
    wanted = pipeline.requests([str(night)], model="altaz", refit="all", seed=0, out=out)
    for done in pipeline.run_all(wanted):
        reports.append(json.loads(done.report))
        tell("\n" + done.summary)
    tell(f"\nHidden was: {hidden}. The session was drawn: {night}")

    tell(
        click.style("\n5. A simulated night whose azimuth axis begins to lean, watched", bold=True)
    )
    with working("watching"):
        watched = _night(out / "night.png")
    tell("\n" + "\n".join(watched))
    if as_json:
        blocks = [
            {"name": one.block.name, "agree": one.agree, "total": one.total} for one in checked
        ]
        answer = {
            "parity": agreement,
            "table": table,
            "check": blocks,
            "diagnoses": reports,
            "watch": watched,
        }
        say("", answer, as_json=True)


def _equatorial(out: Path) -> tuple[Path, str]:
    """Draw a session of a German mount, half of whose noise is what its model leaves out."""
    from pyport.examiner.sealed.record.files import write_recordings
    from pyport.examiner.worlds.kinds import make_case

    cause, mount, rows, seed = EQUATORIAL
    made = make_case("one", seed, effect=cause, mount=mount, rows=rows, noise="white")
    write_recordings(made, out / "german.csv")
    return out / "german.csv", made.truth["effects"][0]["effect"]


#: The night: five nights of white noise before it, a tilt of two sigmas in its course.
NIGHT = ("white", 11, 1)


def _night(picture: Path) -> list[str]:
    """Replay a simulated night to a watch, draw its page, and return what an observer reads."""
    from pyport import Watch
    from pyport.examiner.nights.nights import Case, draw
    from pyport.files import write_whole
    from pyport.plots.night import night
    from pyport.watch.live import live
    from pyport.watch.state import words

    kind, number, seed = NIGHT
    drawn = draw(Case(kind, number, seed, step=True))
    watch = Watch(drawn.past, header=drawn.header)
    tonight = drawn.watched["session"] == drawn.watched["session"][0]
    rows = watch.replay({name: cells[tonight] for name, cells in drawn.watched.items()})
    found = [f"pointing {one.row}: {words(event)}" for one in rows for event in one.events]
    with write_whole(picture, "wb") as file:
        night(live(watch)).savefig(file, format="png", dpi=130)
    return [*found, f"{picture}: the page of `pyport watch --serve` as it then is"]
