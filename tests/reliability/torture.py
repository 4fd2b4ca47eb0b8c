"""Kill commands at random moments and look at their files: python tests/reliability/torture.py.

Every command has an old answer in place and is about to replace it by a new
one. It is killed (SIGKILL) at a random moment of its run, every second time at a
random moment after it has begun to write; runs that were over before do not
count. Each of its files must then be the old one or the new one, byte for byte,
and run once more the command must give the new answer. Trials are killed and
called again until they are done: their answers must be those of a run that
nobody disturbed. Commands are forked from a process that has imported them
already, so that no kill is wasted on imports.

All that is drawn comes from a seed, which is printed. Where something differs
both folders are kept, with what the command said, and what differs is named.
With --load so many other processes compute and write all the while.
"""

from __future__ import annotations

import argparse
import contextlib
import filecmp
import hashlib
import itertools
import json
import multiprocessing
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from victims import Victim, prepare, specs, victims

from pyport import cli
from pyport.examiner.sealed import seal

#: With a fixed date in binary tables, two runs of one command write the same bytes.
ALWAYS = {"SOURCE_DATE_EPOCH": "0", "OPENBLAS_NUM_THREADS": "1"}
#: A moment that comes too late for so many runs in a row is no moment to kill at.
MOST_LATE = 20
TRIALS_SHARE = 0.06


@dataclass
class Count:
    """What came of the kills of one command."""

    name: str
    writing: int = 0
    elsewhere: int = 0
    lost: tuple[str, ...] = ()
    kept: Path | None = None

    @property
    def kills(self) -> int:
        """Return how many runs were killed before their end."""
        return self.writing + self.elsewhere


def start(
    words: tuple[str, ...],
    said: str | Path = os.devnull,
    before: Callable[[], None] = lambda: None,
) -> int:
    """Run pyport in a process forked from this one, its errors in a file; return its number."""
    number = os.fork()
    if number:
        # on either side, so that there is a group whoever comes first
        with contextlib.suppress(OSError):
            os.setpgid(number, number)
        return number
    status = 1
    with contextlib.suppress(BaseException):
        os.setpgid(0, 0)
        nothing = os.open(os.devnull, os.O_RDWR)
        os.dup2(nothing, 0)
        os.dup2(nothing, 1)
        os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        sys.argv = ["pyport", *words]
        try:
            before()
            cli.main()
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 1
        except BaseException:  # noqa: BLE001 - said, and told by the status
            os.write(2, traceback.format_exc().encode())
    os._exit(status)


def finish(words: tuple[str, ...]) -> float:
    """Run pyport to its end and return how long that took [s]."""
    with tempfile.NamedTemporaryFile() as said:
        started = time.monotonic()
        _, status = os.waitpid(start(words, said.name), 0)
        if status:
            last = said.read().decode(errors="replace").strip().splitlines()[-1:]
            raise SystemExit(
                f"torture: `pyport {' '.join(words)}` fails on its own "
                f"({os.waitstatus_to_exitcode(status)}): {''.join(last)}"
            )
    return time.monotonic() - started


def warm(words: tuple[str, ...]) -> None:
    """Run pyport in this process, for what it imports."""
    with open(os.devnull, "w") as nothing, contextlib.redirect_stdout(nothing):  # noqa: PTH123
        cli.pyport.main(list(words), prog_name="pyport", standalone_mode=False)


def is_over(number: int) -> bool:
    """Tell whether a process has ended, without waiting for it."""
    return bool(os.waitid(os.P_PID, number, os.WEXITED | os.WNOHANG | os.WNOWAIT))


def begun(place: Path) -> bool:
    """Tell whether a temporary file stands in a folder or one below it."""
    for _, _, names in os.walk(place):
        if any(name.startswith(".") and Path(name).suffix for name in names):
            return True
    return False


def kill(words: tuple[str, ...], place: Path, took_s: float, *, writing: bool) -> str:
    """Kill a run, and all that it started, at a random moment; return when that was."""
    number = start(words)
    if writing:
        while not is_over(number) and not begun(place):
            time.sleep(0.001)
        time.sleep(random.uniform(0, 0.02))  # noqa: S311 - no secret
    else:
        time.sleep(random.uniform(0, took_s))  # noqa: S311
    over = is_over(number)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(number, signal.SIGKILL)
    _, status = os.waitpid(number, 0)
    if over and status:
        raise SystemExit(f"torture: `pyport {' '.join(words)}` fails on its own")
    return "late" if over else "writing" if begun(place) else "elsewhere"


def files(place: Path) -> dict[str, Path]:
    """Return the files in a folder by their names in it, those of a run on its way apart."""
    return {
        str(path.relative_to(place)): path
        for path in sorted(place.rglob("*"))
        if path.is_file() and path.name[0] != "." and "unfinished" not in path.name
    }


def lost(after: Path, *allowed: Path) -> list[str]:
    """Return the files of the first allowed answer, or of this one, that are in no allowed one.

    Where another answer is wholly there, files of the first that it lacks may be gone.
    """
    now, states = files(after), [files(one) for one in allowed]

    def same(name: str, state: dict[str, Path]) -> bool:
        there = name in now and name in state
        return there and filecmp.cmp(now[name], state[name], shallow=False)

    damaged = [name for name in now if not any(same(name, state) for state in states)]
    if any(all(same(name, state) for name in state) for state in states[1:]):
        return damaged
    return damaged + [name for name in states[0] if name not in now]


def torture(victim: Victim, kills: int, folder: Path) -> Count:
    """Kill a command so often; return what came of it."""
    place = folder / victim.name.replace(" ", "-").replace(",", "")
    old, new, now = (place / name for name in ("old", "new", "now"))
    old.mkdir(parents=True)
    victim.prepare(old)
    warm((*victim.old, str(old / victim.out)))
    shutil.copytree(old, new)
    took_s = finish((*victim.new, str(new / victim.out)))
    count = Count(victim.name)
    damaged: list[str] = []
    words = (*victim.new, str(now / victim.out))
    late = attempt = 0
    while count.kills < kills and late < MOST_LATE:
        shutil.rmtree(now, ignore_errors=True)
        shutil.copytree(old, now)
        when = kill(words, now, took_s, writing=attempt % 2 == 0)
        attempt += 1
        late = late + 1 if when == "late" else 0
        count.writing += when == "writing"
        count.elsewhere += when == "elsewhere"
        damaged += [f"{name} is neither old nor new" for name in lost(now, old, new)]
        if victim.resumes and count.kills == kills:
            finish(words)
            damaged += [f"{name} is not new when run again" for name in lost(now, new)]
        if damaged:
            count.kept = place
            break
    count.lost = tuple(damaged)
    return count


def torture_trials(kills: int, folder: Path, seed: str) -> Count:
    """Kill the solving of a sealed set so often, and compare with one that ran in peace."""
    quiet, loud = folder / "trials" / "quiet" / "set", folder / "trials" / "loud" / "set"
    seal.seal(quiet, "set", specs(), random.Random(seed))  # noqa: S311 - a test's
    shutil.copytree(quiet.parent, loud.parent)
    took_s = finish(("dev", "trials", "run", str(quiet)))
    words = ("dev", "trials", "run", str(loud))
    count = Count("trials")
    theirs = _answers(quiet)
    differs: list[str] = []
    late, last = 0, False
    while not (last or differs):
        when = kill(words, loud, took_s / 2, writing=count.kills % 2 == 0)
        late = late + 1 if when == "late" else 0
        count.writing += when == "writing"
        count.elsewhere += when == "elsewhere"
        last = count.kills == kills or late == MOST_LATE
        if last:
            finish(words)
        ours = _answers(loud)
        differs = [f"{name}: {differing(ours[name], theirs[name])}" for name in ours
                   if ours[name] != theirs[name]]  # fmt: skip
        if not last and len(ours) == len(theirs):  # all is answered: begin again
            shutil.rmtree(loud / "reports")
    if last:
        differs += [f"{name} is not there" for name in theirs if name not in ours]
    for root in () if differs else (quiet, loud):
        finish(("dev", "trials", "reveal", str(root)))
    count.lost = tuple(differs)
    count.kept = folder / "trials" if differs else None
    return count


def differing(ours: object, theirs: object, place: str = "") -> str:
    """Return where two answers differ first, and how."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        for key in sorted({*ours, *theirs}):
            if ours.get(key) != theirs.get(key):
                return differing(ours.get(key), theirs.get(key), f"{place}.{key}")
    both_listed = isinstance(ours, list | tuple) and isinstance(theirs, list | tuple)
    if both_listed and len(ours) == len(theirs):
        for number, (a, b) in enumerate(zip(ours, theirs, strict=True)):
            if a != b:
                return differing(a, b, f"{place}[{number}]")
    return f"{place} is {str(ours)[:200]}, undisturbed {str(theirs)[:200]}"


def _answers(root: Path) -> dict[str, object]:
    """Return the reports of a set and the bytes of its residuals, how long they took apart."""
    found: dict[str, object] = {}
    for path in sorted(root.glob("reports/*/report.json")):
        report = json.loads(path.read_text())
        report["examined"].pop("seconds")
        found[path.parent.name] = report, (path.parent / "rows.csv").read_bytes()
    return found


@contextlib.contextmanager
def load(count: int) -> Iterator[None]:
    """Let so many other processes compute and write meanwhile."""
    others = [multiprocessing.get_context("spawn").Process(target=toil) for _ in range(count)]
    for other in others:
        other.start()
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.join()


def toil() -> None:
    """Compute and write until killed."""
    with tempfile.TemporaryFile() as file:
        while True:
            file.seek(0)
            file.write(b"".join(hashlib.sha256(b"%d" % n).digest() for n in range(30_000)))
            file.flush()


def one(name: str, kills: int, seed: int, folder: Path) -> Count:
    """Torture one command, in a process of its own."""
    os.environ.update(ALWAYS)
    random.seed(f"{seed} {name}")
    if name == "trials":
        return torture_trials(kills, folder, f"{seed} set")
    return torture(victims(folder)[name], kills, folder)


def shared(kills: int, folder: Path) -> dict[str, int]:
    """Return how many kills each command gets."""
    weights = {name: victim.share for name, victim in victims(folder).items()}
    weights["trials"] = TRIALS_SHARE * sum(weights.values())
    whole = sum(weights.values())
    found = {name: max(1, int(kills * weight / whole)) for name, weight in weights.items()}
    found["table"] += max(0, kills - sum(found.values()))
    return found


def main() -> int:
    """Torture every command; return 1 where anything was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commands", nargs="*", help="all, when none is named")
    parser.add_argument("--kills", type=int, default=200, help="in all")
    parser.add_argument("--seed", type=int, help="printed; drawn unless given")
    parser.add_argument("--keep", type=Path, default=Path("out/torture"), help="for what differs")
    parser.add_argument("--jobs", type=int, default=2, help="commands at the same time")
    parser.add_argument(
        "--load", type=int, default=0, help="other processes that compute and write"
    )
    told = parser.parse_args()
    seed = random.SystemRandom().randrange(10**6) if told.seed is None else told.seed
    counts = []
    started = time.monotonic()
    print(f"seed {seed}, {told.load} other processes")
    print(f"{'command':<22}{'kills':>6}{'writing':>9}{'elsewhere':>11}{'lost':>6}", flush=True)
    forge = multiprocessing.get_context("spawn")
    with (
        tempfile.TemporaryDirectory(prefix="torture-") as name,
        load(told.load),
        ProcessPoolExecutor(told.jobs, forge, max_tasks_per_child=1) as pool,
    ):
        prepare(Path(name))
        shares = shared(told.kills, Path(name))
        slowest_first = [what for what in reversed(shares) if what in (told.commands or shares)]
        runs = [pool.submit(one, what, shares[what], seed, Path(name)) for what in slowest_first]
        for run in itertools.chain(as_completed(runs), [None]):
            missing = told.kills - sum(count.kills for count in counts)
            if run is not None:
                count = run.result()
            elif missing > 0:
                # What ended before it could be killed is made up for by what can be killed.
                more = Path(name) / "more"
                prepare(more)
                count = pool.submit(one, "table", missing, seed, more).result()
            else:
                break
            counts.append(count)
            print(
                f"{count.name:<22}{count.kills:>6}{count.writing:>9}{count.elsewhere:>11}"
                f"{len(count.lost):>6}",
                *(f"\n    {what}" for what in count.lost),
                flush=True,
            )
            if count.kept is not None:
                kept = told.keep / str(seed) / count.kept.name
                shutil.copytree(count.kept, kept, dirs_exist_ok=True)
                print(f"    kept in {kept}; again with --seed {seed}", flush=True)
    bad = sum(len(count.lost) for count in counts)
    print(
        f"kills tried {sum(count.kills for count in counts)}, files lost {bad}, answers when run"
        f" again {'identical' if not bad else 'as told above'}; {time.monotonic() - started:.0f} s"
    )
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
