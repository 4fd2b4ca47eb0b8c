"""Kill commands at random moments and look at their files: python tests/reliability/torture.py.

Every command has an old answer in place and is about to replace it by a new
one. It is killed (SIGKILL) at a random moment of its run, every second time at a
random moment after it has begun to write. Each of its files must then be the old
one or the new one, byte for byte. Trials are killed and called again until they
are done: their answers must be those of a run that nobody disturbed.
"""

from __future__ import annotations

import argparse
import filecmp
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pyport.trials import seal
from pyport.trials.protocol import Spec

PYPORT = (sys.executable, "-m", "pyport")
#: With a fixed date in binary tables, two runs of one command write the same bytes.
ALWAYS = {"SOURCE_DATE_EPOCH": "0", "OPENBLAS_NUM_THREADS": "1"}
ROWS = 150


@dataclass(frozen=True)
class Victim:
    """A command, how it is called for an old and a new answer, and the file or folder it writes."""

    name: str
    old: tuple[str, ...]
    new: tuple[str, ...]
    out: str


def victims(folder: Path) -> list[Victim]:
    """Return the commands to kill; makes the files that they read."""
    for number, name in enumerate(("old", "new")):
        case = Spec("one", "one", "refraction", 1.0, ROWS * (1 + number)).make(number)
        seal.write_recordings(case, folder / name / "night.csv")
    old, new = (str(folder / name / "night.csv") for name in ("old", "new"))
    few = ("--az", "0:10:1")
    binary = ("table", "--format", "binary")
    return [
        Victim("table", ("table", *few, "-o"), ("table", "-o"), "table.txt"),
        Victim("table, binary", (*binary, *few, "-o"), (*binary, "-o"), "table.bin"),
        Victim("convert to CSV", ("convert", old), ("convert", new), "night.csv"),
        Victim("convert to ECSV", ("convert", old), ("convert", new), "night.ecsv"),
        Victim("convert to Parquet", ("convert", old), ("convert", new), "night.parquet"),
        Victim("diagnose", ("diagnose", old, "--out"), ("diagnose", new, "--out"), "answer"),
    ]


def call(words: Sequence[str], **options: object) -> subprocess.Popen[bytes]:
    """Start pyport with nothing to say."""
    return subprocess.Popen(
        [*PYPORT, *words],
        env={**os.environ, **ALWAYS},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        **options,  # type: ignore[call-overload]
    )


def finish(words: Sequence[str]) -> float:
    """Run pyport to its end and return how long that took [s]."""
    started = time.monotonic()
    if call(words).wait():
        raise SystemExit(f"torture: `pyport {' '.join(words)}` fails on its own")
    return time.monotonic() - started


def begun(place: Path) -> bool:
    """Tell whether a temporary file stands in a folder or one below it."""
    for folder, _, names in os.walk(place):
        for name in names:
            if name.startswith(".") and Path(folder, name).suffix:
                return True
    return False


def kill(words: Sequence[str], place: Path, took_s: float, *, writing: bool) -> str:
    """Kill a run at a random moment and return when that was."""
    process = call(words)
    if writing:
        while process.poll() is None and not begun(place):
            time.sleep(0.0005)
        time.sleep(random.uniform(0, 0.02))  # noqa: S311 - no secret
    else:
        time.sleep(random.uniform(0, took_s))  # noqa: S311
    over = process.poll() is not None
    process.kill()
    process.wait()
    return "after the end" if over else "writing" if begun(place) else "elsewhere"


def files(place: Path) -> dict[str, Path]:
    """Return the files in a folder by their names in it, temporary ones apart."""
    return {
        str(path.relative_to(place)): path
        for path in sorted(place.rglob("*"))
        if path.is_file() and not path.name.startswith(".")
    }


def lost(after: Path, old: Path, new: Path) -> list[str]:
    """Return the files of an answer that are neither the old ones nor the new ones."""
    now, then, wanted = files(after), files(old), files(new)
    damaged = [
        name
        for name, path in now.items()
        if not any(
            name in kept and filecmp.cmp(path, kept[name], shallow=False) for kept in (then, wanted)
        )
    ]
    return damaged + [name for name in then if name not in now]


def torture(victim: Victim, kills: int, folder: Path) -> tuple[Counter[str], int]:
    """Kill a command so often; return when, and how many files were lost."""
    place = folder / victim.name.replace(" ", "-").replace(",", "")
    old, new, now = (place / name for name in ("old", "new", "now"))
    for one in (old, new):
        one.mkdir(parents=True)
    finish([*victim.old, str(old / victim.out)])
    took_s = finish([*victim.new, str(new / victim.out)])
    when: Counter[str] = Counter()
    damaged = 0
    for number in range(kills):
        shutil.rmtree(now, ignore_errors=True)
        shutil.copytree(old, now)
        words = [*victim.new, str(now / victim.out)]
        when[kill(words, now, took_s, writing=number % 2 == 0)] += 1
        bad = lost(now, old, new)
        damaged += len(bad)
        for name in bad:
            print(f"    lost: {name} of {victim.name}", flush=True)
    finish([*victim.new, str(now / victim.out)])
    left = {name: path.read_bytes() for name, path in files(now).items() if name in files(new)}
    if left != {name: path.read_bytes() for name, path in files(new).items()}:
        damaged += 1
        print(f"    lost: {victim.name} does not recover", flush=True)
    return when, damaged


def torture_trials(kills: int, folder: Path) -> tuple[Counter[str], int]:
    """Kill the solving of a sealed set so often, and compare with one that ran in peace."""
    quiet, loud = folder / "quiet" / "set", folder / "loud" / "set"
    specs = [
        Spec("null", "null", rows=ROWS, noise="white"),
        *(Spec("one", "one", one, 1.0, ROWS) for one in ("refraction", "tilt", "drift")),
        Spec("unknown", "unknown", "mixed_wave", 1.0, ROWS),
    ]
    seal.seal(quiet, "set", specs)
    shutil.copytree(quiet.parent, loud.parent)
    took_s = finish(["trials", "run", str(quiet)])
    when: Counter[str] = Counter()
    for _ in range(kills):
        process = call(["trials", "run", str(loud)], start_new_session=True)
        time.sleep(random.uniform(0, 0.7 * took_s))  # noqa: S311
        when["after the end" if process.poll() is not None else "elsewhere"] += 1
        if process.poll() is None:
            os.killpg(process.pid, 9)
        process.wait()
        if len(_answers(loud)) == len(specs):  # all is answered: begin again
            shutil.rmtree(loud / "reports")
    finish(["trials", "run", str(loud)])
    for root in (quiet, loud):
        finish(["trials", "reveal", str(root)])
    ours, theirs = _answers(loud), _answers(quiet)
    wrong = sum(ours.get(name) != theirs[name] for name in theirs)
    same = "identical" if not wrong else f"{wrong} of {len(theirs)} differ"
    print(f"{'':<22}answers after being resumed: {same}", flush=True)
    return when, wrong


def _answers(root: Path) -> dict[str, object]:
    """Return the reports of a set and the bytes of its residuals, how long they took apart."""
    found: dict[str, object] = {}
    for path in sorted(root.glob("reports/*/report.json")):
        report = json.loads(path.read_text())
        report["examined"].pop("seconds")
        found[path.parent.name] = report, (path.parent / "rows.csv").read_bytes()
    return found


def main() -> int:
    """Torture every command; return 1 where anything was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200, help="in all")
    parser.add_argument("--seed", type=int, default=None)
    told = parser.parse_args()
    random.seed(told.seed)
    tried = damaged = 0
    with tempfile.TemporaryDirectory(prefix="torture-") as name:
        folder = Path(name)
        all_of_them = victims(folder)
        each, rest = divmod(told.kills, len(all_of_them) + 1)
        shares = [each + (n < rest) for n in range(len(all_of_them) + 1)]
        print(f"{'command':<22}{'kills':>6}{'writing':>9}{'elsewhere':>11}{'after':>7}{'lost':>6}")
        runs = [
            *(
                (one.name, lambda kills, one=one: torture(one, kills, folder))
                for one in all_of_them
            ),
            ("trials", lambda kills: torture_trials(kills, folder)),
        ]
        for (what, run), kills in zip(runs, shares, strict=True):
            when, bad = run(kills)
            tried, damaged = tried + kills, damaged + bad
            print(
                f"{what:<22}{kills:>6}{when['writing']:>9}{when['elsewhere']:>11}"
                f"{when['after the end']:>7}{bad:>6}",
                flush=True,
            )
    print(f"kills tried {tried}, files lost {damaged}")
    return int(damaged > 0)


if __name__ == "__main__":
    sys.exit(main())
