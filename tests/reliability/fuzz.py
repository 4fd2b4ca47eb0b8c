"""Bounded fuzzing of every reader: python tests/reliability/fuzz.py --seconds 600 [READER...].

Each reader gets an equal share of the processor's time, in a process of its own,
forked from this one: good files spoilt at random first, then bytes guided by
coverage (atheris, where this Python has it). Readers are those of files, the
options of the quick commands, and the Python interface, whose calls are drawn from
the bytes. An input may be read or refused by `BadInput` on one line.
Anything else is a failure: another exception, more than 10 s, more than 4 GB, a
file opened elsewhere than where the input lies, a program run, a connection.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

LONGEST_S = 10
LARGEST_BYTES = 4 * 2**30
GUIDED = importlib.util.find_spec("atheris") is not None
#: What is watched to guide.
INSTRUMENTED = [
    *("pyport.recordings", "pyport.formats", "pyport.steering", "pyport.models.model", "tomllib"),
    *("pyport.examiner.sealed.record.published", "pyport.watch.follow", "pyport.planning"),
]
#: Share of a reader's time for spoilt files, where there is atheris too.
SHARE = 0.3
LONGEST_INPUT = 4096
#: Different failures of one reader that are kept.
MOST_KEPT = 10
WORDS = (
    *Path(__file__).with_name("words.txt").read_text(encoding="utf-8").split(),
    *("\ufeff", "é", "\0", "\r\n", "\t", " "),
)


class Escape(Exception):  # noqa: N818 - what it is, not whose
    """A reader reached for something that an input must not make it reach for."""


class Tally:
    """What came of the inputs so far, kept in a file so that a kill loses nothing of it."""

    def __init__(self, folder: Path) -> None:
        """Begin with nothing tried."""
        self.folder = folder
        self.found: dict[str, Any] = {"tried": 0, "read": 0, "failures": {}}
        self.slowest = 0.0
        self.saved = 0.0

    def failed(self, what: str, data: bytes, said: str = "") -> None:
        """Keep the first input that failed so, and what was said then."""
        if what not in self.found["failures"] and len(self.found["failures"]) < MOST_KEPT:
            name = f"failure-{len(self.found['failures']):02d}"
            (self.folder / name).write_bytes(data)
            self.found["failures"][what] = f"{said} ({self.folder / name})"
            self.save()

    def save(self) -> None:
        """Write what is known."""
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        told = {**self.found, "slowest_s": round(self.slowest, 2), "peak_mb": peak}
        whole = self.folder / "tally.tmp"
        whole.write_text(json.dumps(told))
        whole.replace(self.folder / "tally.json")
        self.saved = time.monotonic()


class Attempt:
    """One reader, a folder for its input, and what came of each."""

    def __init__(self, name: str, folder: Path) -> None:
        """Import the reader and read its seeds, so that later imports are no surprise."""
        readers = importlib.import_module("readers").readers()
        self.reader = readers[name]
        self.tally = Tally(folder)
        self.scratch = Path(tempfile.mkdtemp(prefix="fuzz-", dir=_memory()))
        tempfile.tempdir = str(self.scratch)
        self.guarded = False
        self.inside = False
        self.escape = ""
        from pyport.errors import BadInput

        self.refusal = BadInput
        for seed in self.reader.seeds:
            self(seed)
        sys.addaudithook(self._watch)
        self.guarded = True

    def __call__(self, data: bytes) -> None:
        """Let the reader read these bytes, and note what came of it."""
        path = self.scratch / f"input{self.reader.suffix}"
        path.write_bytes(data)
        found = self.tally.found
        found["tried"] += 1
        wrong = said = ""
        started = time.process_time()
        self.inside = True
        try:
            self.reader.read(path)
            found["read"] += 1
        except self.refusal as error:
            if len(str(error).splitlines()) > 1:
                wrong = "a refusal of several lines"
        except BaseException as error:  # noqa: BLE001 - each of them is a finding
            wrong, said = _where(error), str(error)[:80]
        self.inside = False
        if wrong:
            self.tally.failed(wrong, data, said)
        if self.escape:
            self.tally.failed(f"reached for {self.escape}", data)
            self.escape = ""
        took = time.process_time() - started
        self.tally.slowest = max(self.tally.slowest, took)
        if took > LONGEST_S:
            self.tally.failed("took longer than 10 s", data)
        if time.monotonic() - self.tally.saved > 1:
            self.tally.save()

    def _watch(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Stop what a reader has no business with."""
        if not (self.inside and self.guarded):
            return
        if event in {"subprocess.Popen", "os.system", "os.exec", "socket.connect"}:
            raise self._escaped(event)
        if event == "open" and isinstance(arguments[0], str | bytes):
            path = os.path.realpath(os.fsdecode(arguments[0]))
            writes = isinstance(arguments[2], int) and arguments[2] & (os.O_WRONLY | os.O_RDWR)
            allowed = [str(self.scratch)]
            if not writes:
                allowed += [sys.prefix, sys.base_prefix, str(Path(__file__).parents[2])]
                allowed += ["/dev/urandom", "/proc", "/sys", "/usr/share/zoneinfo"]
            if not path.startswith(tuple(allowed)):
                raise self._escaped(f"open {path}")

    def _escaped(self, what: str) -> Escape:
        """Note it here: a reader may take the exception for the file's fault."""
        self.escape = what
        return Escape(what)


def _memory() -> str | None:
    """Return a folder in memory where there is one: no input needs to reach a disk."""
    return "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # noqa: S108


def _where(error: BaseException) -> str:
    """Return what was raised, and the last line of pyport that it came through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [one for one in frames if "/pyport/" in one.filename]
    last = ours[-1] if ours else frames[-1]
    return f"{type(error).__name__} at {Path(last.filename).name}:{last.lineno}"


def spoil(attempt: Attempt, until: float, corpus: Path) -> None:
    """Spoil good files at random until a time; what was read is kept for what comes next."""
    rng = random.Random(attempt.reader.name)  # noqa: S311 - no secret
    pieces = [word.encode() for word in WORDS]
    while time.process_time() < until:
        data = rng.choice(attempt.reader.seeds)
        for _ in range(rng.randint(1, 5)):
            place = rng.randint(0, len(data))
            length = rng.randint(1, 20)
            piece = rng.choice(pieces) if rng.random() < 0.7 else rng.randbytes(rng.randint(0, 4))
            end = place if rng.random() < 0.25 else place + length
            middle = rng.choice((piece, b"", data[place : place + length] * 2, piece * length))
            data = data[:place] + middle + data[end:]
        read = attempt.tally.found["read"]
        attempt(data)
        if attempt.tally.found["read"] > read and len(data) <= LONGEST_INPUT:
            (corpus / f"spoilt-{attempt.tally.found['tried'] % 200:03d}").write_bytes(data)


def work(name: str, seconds: float, folder: Path) -> None:
    """Fuzz one reader for so much of the processor's time; does not return."""
    resource.setrlimit(resource.RLIMIT_AS, (LARGEST_BYTES, LARGEST_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (int(2 * seconds) + 120,) * 2)
    attempt = Attempt(name, folder)
    corpus = folder / "corpus"
    corpus.mkdir(exist_ok=True)
    for n, seed in enumerate(attempt.reader.seeds):
        (corpus / f"seed-{n}").write_bytes(seed)
    started = time.process_time()
    spoil(attempt, started + seconds * (SHARE if GUIDED else 1), corpus)
    attempt.tally.found["spoilt"] = attempt.tally.found["tried"]
    attempt.tally.save()
    if not GUIDED:
        os._exit(0)
    import atheris

    words = folder / "words"
    words.write_text("".join(f'"{_escaped(word)}"\n' for word in WORDS if word))

    def one(data: bytes) -> None:
        attempt(data)
        if time.process_time() - started > seconds:
            attempt.tally.save()
            os._exit(0)

    options = [f"-dict={words}", f"-max_len={LONGEST_INPUT}", "-timeout=600", "-rss_limit_mb=0"]
    options += ["-verbosity=0", "-print_final_stats=0", f"-artifact_prefix={folder}/stopped-"]
    atheris.Setup([name, *options, str(corpus)], one)
    atheris.Fuzz()


def imported() -> dict[str, Any]:
    """Return the readers, their code watched where that guides."""
    if not GUIDED:
        return dict(importlib.import_module("readers").readers())
    import atheris

    with atheris.instrument_imports(include=INSTRUMENTED, enable_loader_override=False):
        return dict(importlib.import_module("readers").readers())


def begin(name: str, seconds: float, folder: Path) -> int:
    """Fork a process that fuzzes a reader, what it prints in a file; return its number."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in (*folder.glob("failure-*"), *folder.glob("stopped-*"), *folder.glob("tally.json")):
        old.unlink()
    sys.stdout.flush()
    number = os.fork()
    if number:
        return number
    try:
        log = os.open(folder / "log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(log, 1)
        os.dup2(log, 2)
        work(name, seconds, folder)
    except BaseException:  # noqa: BLE001 - said, and told by the status
        os.write(2, traceback.format_exc().encode())
    os._exit(1)


def ended(name: str, status: int, folder: Path) -> dict[str, Any]:
    """Return the tally of a reader, and print its line."""
    tally = folder / "tally.json"
    found: dict[str, Any] = (
        json.loads(tally.read_text())
        if tally.exists()
        else {"tried": 0, "read": 0, "failures": {}, "slowest_s": 0, "peak_mb": 0}
    )
    if status:
        found["failures"][f"the process ended with {status}"] = str(folder / "log")
    print(
        f"{name:<22}{found['tried']:>9}{found['read']:>9}{found['slowest_s']:>7} s"
        f"{found['peak_mb']:>6}  {len(found['failures'])}",
        *(f"\n    {what}: {said}" for what, said in found["failures"].items()),
        flush=True,
    )
    return found


def _escaped(word: str) -> str:
    return "".join(f"\\x{byte:02x}" for byte in word.encode())


def reached(name: str, folder: Path) -> str:
    """Return how many lines of a reader's functions the inputs that were kept run through."""
    import coverage

    os.chdir(Path(__file__).parent)  # the folder of the last one is gone
    readers = importlib.import_module("readers").readers()
    reader = readers[name]
    modules = [importlib.import_module(one) for one in reader.modules]
    files = [str(one.__file__) for one in modules]
    watcher = coverage.Coverage(data_file=None, include=files)
    from pyport.errors import BadInput

    inputs = [path.read_bytes() for path in sorted((folder / "corpus").iterdir())]
    with tempfile.TemporaryDirectory(dir=_memory()) as scratch, watcher.collect():
        path = Path(scratch) / f"input{reader.suffix}"
        for data in inputs:
            path.write_bytes(data)
            try:
                reader.read(path)
            except BadInput:
                pass
            except Exception:  # noqa: BLE001, S110 - counted already
                pass
    hit = of = 0
    for module, file in zip(modules, files, strict=True):
        _, statements, _, missing, _ = watcher.analysis2(file)
        # what is read when the module is imported is no reader's doing: lines in functions count
        inner = set(statements) & _inside_functions(str(module.__file__))
        of += len(inner)
        hit += len(inner - set(missing))
    return f"{hit}/{of}"


def _inside_functions(file: str) -> set[int]:
    import ast

    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    readers = [
        one
        for one in ast.walk(tree)
        if isinstance(one, ast.FunctionDef) and not one.name.lstrip("_").startswith("writ")
    ]
    return {
        line
        for one in readers
        for line in range(one.body[0].lineno, (one.end_lineno or one.lineno) + 1)
    }


def main() -> int:
    """Fuzz the readers that are named, or all; return 1 after failures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="*")
    parser.add_argument("--seconds", type=float, default=600, help="in all, of each processor")
    parser.add_argument("--jobs", type=int, default=2, help="readers at the same time")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"))
    parser.add_argument("--reached", action="store_true", help=argparse.SUPPRESS)
    told = parser.parse_args()
    told.out = told.out.resolve()
    if told.reached:
        sys.stdout.write(
            "".join(f" {name} {reached(name, told.out / name)}" for name in told.readers)
        )
        return 0
    known = imported()
    names = told.readers or list(known)
    share = told.seconds * told.jobs / len(names)
    how = "spoilt and guided" if GUIDED else "spoilt (no atheris for this Python)"
    print(f"{len(names)} readers, {share:.0f} s each, {told.jobs} at a time, {how}", flush=True)
    print(f"{'reader':<22}{'tried':>9}{'read':>9}{'slowest':>9}{'MB':>6}  failures", flush=True)
    waiting, running, results = list(names), {}, []
    while waiting or running:
        while waiting and len(running) < told.jobs:
            name = waiting.pop(0)
            running[begin(name, share, told.out / name)] = name
        number, status = os.wait()
        name = running.pop(number)
        results.append(ended(name, os.waitstatus_to_exitcode(status), told.out / name))
    # in a process whose code is not watched already
    again = [sys.executable, __file__, *names, "--out", str(told.out), "--reached"]
    lines = subprocess.run(again, stdout=subprocess.PIPE, text=True, check=False)
    print(f"lines of each reader that the inputs kept run through:{lines.stdout}")
    tried = sum(one["tried"] for one in results)
    failures = sum(len(one["failures"]) for one in results)
    print(f"inputs tried {tried}, failures {failures}")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
