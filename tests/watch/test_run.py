"""The watch as a process: killed at any moment and started again, it tells everything once."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from drawn_nights import text, world, write

from pyport.cli import pyport as program
from pyport.errors import BadInput
from pyport.watch.run import Options, Process
from pyport.watch.state import EVENTS

#: Kills of the test; `make watch-kills` makes 200.
KILLS = int(os.environ.get("PYPORT_WATCH_KILLS", "3"))


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return a past, a night with a tilt, and what an undisturbed watch tells of it."""
    folder = tmp_path_factory.mktemp("night")
    drawn = world()
    write(folder / "past.csv", drawn.past, drawn.header)
    write(folder / "night.csv", drawn.watched, drawn.header)
    done = CliRunner().invoke(program, arguments(folder, folder / "undisturbed"))
    assert done.exit_code == 0, done.output
    return folder, drawn, done


def arguments(folder, out, *more):
    """Return the words of a watch over the night."""
    past = str(folder / "past.csv")
    return [
        "watch",
        str(folder / "night.csv"),
        "--history",
        past,
        "--out",
        str(out),
        "--once",
        *more,
    ]


def state(out):
    """Return everything that a watch keeps, as it can be compared."""
    with np.load(out / "state.npz") as kept:
        told = json.loads(str(kept["told"]))
        told["beside"].pop("inode")
        return told, {name: kept[name].tobytes() for name in kept.files if name != "told"}


@pytest.mark.parametrize("at_once", [True, False], ids=["at once", "row by row"])
def test_what_past_and_log_say_against_themselves(tmp_path, at_once):
    """Shown once, however many rows say it."""
    drawn = world()
    header = drawn.header | {"azimut_zero": "south"}
    past = write(tmp_path / "past.csv", drawn.past, header)
    above, rows = text(drawn.watched, header)
    log, said = tmp_path / "night.csv", []
    log.write_text("".join(above + rows[: 12 if at_once else 0]))
    options = Options(log, "altaz", tmp_path / "out", history=str(past))
    process = Process(options, lambda _: None, said.append)
    list(process.step())
    for row in () if at_once else rows[:12]:
        with log.open("a") as file:
            file.write(row)
        list(process.step())

    wrong = "header key 'azimut_zero' in line {} is not known and not used"
    line = 1 + list(header).index("azimut_zero")
    told = [one for one in said if one.startswith("warning: ")]
    assert [one.rpartition(":")[0] for one in told] == [
        f"warning: {file}: {wrong.format(line)}" for file in (past, log)
    ]


def test_times_that_cannot_be_are_said(tmp_path):
    """A row of the future, and the first one of a night before what was read; both are counted."""
    drawn = world()
    past = write(tmp_path / "past.csv", drawn.past, drawn.header)
    above, rows = text(drawn.watched, drawn.header)
    night = str(drawn.watched["time_utc"][2])[:10]
    rows = rows[:6]
    rows[1] = re.sub(r"\b20\d\d-", "2099-", rows[1])
    log, said = tmp_path / "night.csv", []
    log.write_text("".join(above + rows))
    process = Process(
        Options(log, "altaz", tmp_path / "out", history=str(past)), lambda _: None, said.append
    )
    seen = list(process.step())

    line = len(above) + 2
    times = [one for one in said if "taken as it stands" in one]
    assert len(seen) == 6
    assert len(times) == 2
    assert times[0].startswith(f"{log}:{line}: 2099-")
    assert "is in the future" in times[0]
    assert times[1].startswith(f"{log}:{line + 1}: {night}")


@pytest.mark.slow
def test_it_prints_what_happened_and_leaves_its_files(night):
    """An observer reads a sentence; programs read events, status and metrics."""
    folder, _, done = night
    out = folder / "undisturbed"
    status = json.loads((out / "status.json").read_text())

    assert "alarm 1 raised, since 2024-" in done.output
    assert "the azimuth axis leans" in done.output
    assert [one["effect"] for one in status["standing"]] == ["tilt"]
    assert (out / "metrics.prom").read_text().endswith("# EOF\n")
    assert "pyport_watch_standing 1\n" in (out / "metrics.prom").read_text()


def test_once_more_tells_nothing_new(night):
    """A log that has not grown has nothing to tell; that is said to people, not to programs."""
    folder, _, _ = night
    before = (folder / "undisturbed" / EVENTS).read_text()
    done = CliRunner().invoke(program, arguments(folder, folder / "undisturbed"))

    rows = json.loads((folder / "undisturbed" / "status.json").read_text())["rows"]
    said = f"{folder / 'night.csv'}: {rows} pointings read, 1 alarm stands\n"
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", said)
    assert (folder / "undisturbed" / EVENTS).read_text() == before


def test_a_header_that_the_log_lacks_is_said(night, tmp_path):
    """A past that counts azimuth from south made an alarm of a log that did not say so."""
    folder, drawn, _ = night
    past = (folder / "past.csv").read_text()
    (tmp_path / "past.csv").write_text("# azimuth_zero: south\n" + past)
    above, rows = text(drawn.watched, drawn.header)
    above = [one for one in above if "latitude" not in one]
    (tmp_path / "night.csv").write_text("".join([*above, *rows[:3]]))
    done = CliRunner().invoke(program, arguments(tmp_path, tmp_path / "out"))

    latitude = drawn.header["latitude_deg"]
    assert done.stderr.count("'# azimuth_zero: south' in the past, 'north' in the log") == 1
    assert f"'# latitude_deg: {latitude}' in the past, nothing in the log" in done.stderr
    assert "longitude" not in done.stderr


def test_a_quiet_night_is_said_to_be_quiet(night, tmp_path):
    """How many pointings were read, and that there is no alarm."""
    folder, drawn, _ = night
    above, rows = text(drawn.watched, drawn.header)
    (tmp_path / "past.csv").write_bytes((folder / "past.csv").read_bytes())
    (tmp_path / "night.csv").write_text("".join([*above, *rows[:5]]))

    done = CliRunner().invoke(program, arguments(tmp_path, tmp_path / "out"))

    assert done.stdout == ""
    assert done.stderr.endswith("night.csv: 5 pointings read, no alarm\n")


@pytest.mark.parametrize("words", ["no-such-mailer -s alarm", "true"])
def test_a_command_that_is_not_there_is_said_before_the_night(night, tmp_path, words):
    """Not at the first alarm, when nobody is told of it."""
    folder, drawn, _ = night
    above, rows = text(drawn.watched, drawn.header)
    (tmp_path / "past.csv").write_bytes((folder / "past.csv").read_bytes())
    (tmp_path / "night.csv").write_text("".join([*above, *rows[:2]]))
    called = arguments(tmp_path, tmp_path / "out", "--on-alarm")
    done = CliRunner().invoke(program, [*called, words])
    unended = CliRunner().invoke(program, [*called, "mail 'us"])

    assert done.exit_code == 0
    assert ("warning: --on-alarm: no command 'no-such-mailer'" in done.stderr) == (words != "true")
    assert isinstance(unended.exception, BadInput)
    assert "No closing quotation, expected a command" in str(unended.exception)


@pytest.mark.slow
def test_taken_up_again_it_is_as_if_it_had_not_stopped(night, tmp_path):
    """Before the alarm, while it is named, and after: the same state to the last bit."""
    folder, drawn, _ = night
    above, rows = text(drawn.watched, drawn.header)
    (tmp_path / "past.csv").write_bytes((folder / "past.csv").read_bytes())
    log, out = tmp_path / "night.csv", tmp_path / "out"
    log.write_text("".join(above))
    for begin, end in pairwise([0, 13, 24, 77, len(rows)]):
        with log.open("a") as file:
            file.writelines(rows[begin:end])
        done = CliRunner().invoke(program, arguments(tmp_path, out))
        assert done.exit_code == 0, done.output

    assert state(out) == state(folder / "undisturbed")


@pytest.mark.slow
def test_killed_at_any_moment_it_goes_on_as_if_it_had_not_been(night, tmp_path):
    """The same state to the last bit, the same events, none lost, none twice."""
    folder, drawn, _ = night
    above, rows = text(drawn.watched, drawn.header)
    (tmp_path / "past.csv").write_bytes((folder / "past.csv").read_bytes())
    log, out = tmp_path / "night.csv", tmp_path / "out"
    log.write_text("".join(above))
    words = [sys.executable, "-m", "pyport", *arguments(tmp_path, out), "--every", "0.05"]
    words.remove("--once")
    rng = np.random.default_rng(5)
    kills, written = 0, 0
    process = None
    while kills < KILLS:
        process = process or subprocess.Popen(words, stdout=subprocess.DEVNULL)
        begun = (out / "state.npz").exists()
        # while it writes most of the time, now and then while it starts
        time.sleep(float(rng.uniform(0, 0.4) if begun else rng.uniform(0.5, 2.5)))
        count = min(len(rows) - written, int(rng.poisson(len(rows) / (2.5 * KILLS))))
        with log.open("a") as file:
            for row in rows[written : written + count]:
                half = int(rng.integers(len(row)))
                file.write(row[:half])
                file.flush()
                file.write(row[half:])
        written += count
        if rng.uniform() < 0.5:
            process.send_signal(signal.SIGKILL)
            process.wait()
            process, kills = None, kills + 1
    if process is not None:
        process.kill()
        process.wait()
    with log.open("a") as file:
        file.writelines(rows[written:])
    done = CliRunner().invoke(program, arguments(tmp_path, out))
    assert done.exit_code == 0, done.output

    undisturbed = folder / "undisturbed"
    assert (out / EVENTS).read_text() == (undisturbed / EVENTS).read_text()
    assert state(out) == state(undisturbed)


def test_a_line_of_events_that_was_cut_short_is_written_again(night, tmp_path):
    """Killed while it tells, it tells the rest; a command that was not run yet is run."""
    folder, _, _ = night
    for name in (EVENTS, "state.npz"):
        (tmp_path / name).write_bytes((folder / "undisturbed" / name).read_bytes())
    whole = (tmp_path / EVENTS).read_text()
    (tmp_path / EVENTS).write_text(whole[: len(whole) // 2])
    (tmp_path / "acted").write_text("1")
    noted = tmp_path / "noted"
    hook = tmp_path / "hook"
    hook.write_text(f"#!/bin/sh\necho $PYPORT_EVENT $PYPORT_ALARM >> {noted}\ncat > /dev/null\n")
    hook.chmod(0o755)
    done = CliRunner().invoke(program, arguments(folder, tmp_path, "--on-alarm", str(hook)))
    assert done.exit_code == 0, done.output

    assert (tmp_path / EVENTS).read_text() == whole
    events = [json.loads(one)["event"] for one in whole.splitlines()]
    assert noted.read_text().splitlines() == [f"{one} 1" for one in events[1:]]


def test_a_command_that_was_killed_at_the_first_event_is_run_again(night, tmp_path):
    """Up to which event it was run is kept before it is run for the first."""
    folder, _, _ = night
    noted, hook = tmp_path / "noted", tmp_path / "hook"
    hook.write_text(f"#!/bin/sh\ncat > /dev/null\necho $PYPORT_EVENT >> {noted}\n")
    hook.chmod(0o755)
    killing = tmp_path / "killing"
    killing.write_text("#!/bin/sh\nkill -9 $PPID\n")
    killing.chmod(0o755)
    words = [sys.executable, "-m", "pyport", *arguments(folder, tmp_path / "out", "--on-alarm")]
    assert subprocess.run([*words, str(killing)], check=False).returncode == -signal.SIGKILL
    done = CliRunner().invoke(program, arguments(folder, tmp_path / "out", "--on-alarm", str(hook)))

    assert done.exit_code == 0, done.output
    assert noted.read_text().splitlines()[0] == "raised"


@pytest.mark.slow
def test_the_first_pointings_stand_for_the_past(night, tmp_path):
    """Without a past the watch begins when there are enough, and keeps them."""
    folder, _, _ = night
    words = ["watch", str(folder / "past.csv"), "--out", str(tmp_path), "--once"]
    done = CliRunner().invoke(program, [*words, "--burn-in", "70"])
    assert done.exit_code == 0, done.output
    rows = sum(1 for one in (folder / "past.csv").read_text().splitlines() if one[:1].isdigit())

    assert json.loads((tmp_path / "status.json").read_text())["rows"] == rows - 70
    few = CliRunner().invoke(
        program, [*words[:-2], str(tmp_path / "few"), "--once", "--burn-in", "999"]
    )
    assert "fewer than 999 recordings" in few.output


@pytest.mark.slow
def test_it_stops_at_an_alarm_with_a_status_of_its_own(night, tmp_path):
    """For those who start it from a script."""
    folder, _, _ = night
    done = CliRunner().invoke(program, arguments(folder, tmp_path, "--exit-on-alarm", "--json"))

    assert done.exit_code == 3
    assert json.loads(done.output.splitlines()[0])["event"] == "raised"


def test_two_watches_with_one_folder_are_refused(night, tmp_path):
    """The second one would write what the first one reads."""
    from pyport.watch.run import alone

    folder, _, _ = night
    with alone(tmp_path):
        done = CliRunner().invoke(program, arguments(folder, tmp_path))
    assert done.exit_code != 0
    assert "another process watches with this folder" in str(done.exception)


@pytest.mark.slow
def test_a_command_that_fails_is_reported(night, tmp_path):
    """The watch goes on without it."""
    folder, _, _ = night
    done = CliRunner().invoke(program, arguments(folder, tmp_path, "--on-alarm", "false"))
    assert done.exit_code == 0
    assert "false: exit status 1 at event 1" in done.stderr


def test_no_such_log_is_one_line(tmp_path):
    """As with every command."""
    done = CliRunner().invoke(
        program, ["watch", str(tmp_path / "none.csv"), "--out", str(tmp_path)]
    )
    assert "no such log" in str(done.exception)


def test_a_log_of_which_no_row_can_be_read_is_refused(night, tmp_path):
    """It ended with "no alarm" and status 0."""
    folder, _, _ = night
    log = tmp_path / "night.csv"
    log.write_text((folder / "night.csv").read_text().replace("d_xel_arcsec", "dx", 1))
    log.write_text(log.read_text().replace("d_el_arcsec", "dy", 1))
    words = ["watch", str(log), "--history", str(folder / "past.csv"), "--once"]
    done = CliRunner().invoke(program, [*words, "--out", str(tmp_path / "out")])
    rows = sum(not one.startswith("#") for one in log.read_text().splitlines()) - 1
    assert f"none of {rows} rows can be read, most: no offset column" in str(done.exception)
