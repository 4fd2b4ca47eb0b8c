"""Bounded fuzzing of every reader: python tests/reliability/fuzz.py --seconds 600 [READER...].

Each reader gets an equal share of the time, in a process of its own: spoilt
good files by hypothesis first, then bytes guided by coverage (atheris, where
this Python has it). An input may be read or refused by `BadInput` on one line.
Anything else is a failure: another exception, more than 10 s, more than 4 GB, a
file opened elsewhere than where the input lies, a program run, a connection.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import traceback
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

LONGEST_S = 10
LARGEST_BYTES = 4 * 2**30
#: Share of a reader's time for hypothesis, where there is atheris too.
SHARE = 0.3
LONGEST_INPUT = 4096
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
        if what not in self.found["failures"]:
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
        started = time.monotonic()
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
        took = time.monotonic() - started
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
    """Spoil good files by hypothesis until a time; what was read is kept for what comes next."""
    from hypothesis import HealthCheck, given, settings
    from hypothesis import strategies as st

    pieces = st.sampled_from(WORDS).map(str.encode) | st.binary(max_size=4)
    changes = st.lists(
        st.tuples(st.integers(0, 3), st.floats(0, 1), st.integers(1, 20), pieces),
        min_size=1,
        max_size=5,
    )

    @settings(
        max_examples=100, database=None, deadline=None, suppress_health_check=list(HealthCheck)
    )
    @given(st.sampled_from(attempt.reader.seeds), changes)
    def once(seed: bytes, wanted: list[tuple[int, float, int, bytes]]) -> None:
        if time.monotonic() > until:
            return
        data = seed
        for kind, share, length, piece in wanted:
            place = int(share * len(data))
            rest = data[place + length :]
            middle = (piece, b"", data[place : place + length] * 2, piece * length)[kind]
            data = data[:place] + middle + (data[place:] if kind == 0 else rest)
        read = attempt.tally.found["read"]
        attempt(data)
        if attempt.tally.found["read"] > read and len(data) <= LONGEST_INPUT:
            (corpus / f"spoilt-{attempt.tally.found['tried'] % 200:03d}").write_bytes(data)

    while time.monotonic() < until:
        once()


def work(name: str, seconds: float, folder: Path) -> None:
    """Fuzz one reader for a while; does not return."""
    resource.setrlimit(resource.RLIMIT_AS, (LARGEST_BYTES, LARGEST_BYTES))
    guided = importlib.util.find_spec("atheris") is not None
    if guided:
        import atheris

        with atheris.instrument_imports(include=["pyport.recordings", "pyport.formats",
                                                 "pyport.steering", "pyport.models.model",
                                                 "pyport.examiner.sealed.published", "tomllib"],
                                        enable_loader_override=False):  # fmt: skip
            attempt = Attempt(name, folder)
    else:
        attempt = Attempt(name, folder)
    corpus = folder / "corpus"
    corpus.mkdir(exist_ok=True)
    for n, seed in enumerate(attempt.reader.seeds):
        (corpus / f"seed-{n}").write_bytes(seed)
    started = time.monotonic()
    spoil(attempt, started + seconds * (SHARE if guided else 1), corpus)
    attempt.tally.found["spoilt"] = attempt.tally.found["tried"]
    attempt.tally.save()
    if guided:
        words = folder / "words"
        words.write_text("".join(f'"{_escaped(word)}"\n' for word in WORDS if word))

        def one(data: bytes) -> None:
            attempt(data)
            if time.monotonic() - started > seconds:
                attempt.tally.save()
                os._exit(0)

        options = [f"-dict={words}", f"-max_len={LONGEST_INPUT}", "-timeout=60", "-rss_limit_mb=0"]
        options += ["-verbosity=0", "-print_final_stats=0", f"-artifact_prefix={folder}/stopped-"]
        atheris.Setup([name, *options, str(corpus)], one)
        atheris.Fuzz()


def _escaped(word: str) -> str:
    return "".join(f"\\x{byte:02x}" for byte in word.encode())


def reached(name: str, folder: Path) -> str:
    """Return how many lines of a reader's functions the inputs that were kept run through."""
    import coverage

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
    parser.add_argument("--seconds", type=float, default=600, help="in all")
    parser.add_argument("--jobs", type=int, default=2, help="readers at the same time")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"))
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--reached", action="store_true", help=argparse.SUPPRESS)
    told = parser.parse_args()
    if told.worker:
        work(told.readers[0], told.seconds, told.out)
        return 0
    if told.reached:
        sys.stdout.write(reached(told.readers[0], told.out))
        return 0
    names = told.readers or list(importlib.import_module("readers").readers())
    share = told.seconds * told.jobs / len(names)
    guided = importlib.util.find_spec("atheris") is not None
    how = "hypothesis and atheris" if guided else "hypothesis (no atheris for this Python)"
    print(f"{len(names)} readers, {share:.0f} s each, {told.jobs} at a time, {how}", flush=True)
    print(f"{'reader':<22}{'tried':>9}{'read':>9}{'lines':>9}{'slowest':>9}{'MB':>6}  failures")
    with ThreadPoolExecutor(told.jobs) as pool:
        results = list(pool.map(lambda name: _one(name, share, told.out / name), names))
    tried = sum(one["tried"] for one in results)
    failures = sum(len(one["failures"]) for one in results)
    print(f"inputs tried {tried}, failures {failures}")
    return int(failures > 0)


def _one(name: str, seconds: float, folder: Path) -> dict[str, Any]:
    """Fuzz one reader, print its line, and return its tally."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in (*folder.glob("failure-*"), *folder.glob("stopped-*"), *folder.glob("tally.json")):
        old.unlink()
    command = [sys.executable, __file__, name, "--out", str(folder)]
    with (folder / "log").open("wb") as log:
        worker = [*command, "--worker", "--seconds", str(seconds)]
        try:
            done = subprocess.run(
                worker, stdout=log, stderr=log, timeout=2 * seconds + 300, check=False
            )
            ended = f"status {done.returncode}" if done.returncode else ""
        except subprocess.TimeoutExpired:
            ended = "no end"
    lines = subprocess.run(
        [*command, "--reached"], capture_output=True, text=True, check=False, timeout=300
    )
    tally = folder / "tally.json"
    found: dict[str, Any] = (
        json.loads(tally.read_text())
        if tally.exists()
        else {"tried": 0, "read": 0, "failures": {}, "slowest_s": 0, "peak_mb": 0}
    )
    if ended:
        found["failures"][f"the process ended with {ended}"] = str(folder / "log")
    print(
        f"{name:<22}{found['tried']:>9}{found['read']:>9}{lines.stdout or '-':>9}"
        f"{found['slowest_s']:>7} s{found['peak_mb']:>6}  {len(found['failures'])}",
        flush=True,
    )
    for what, said in found["failures"].items():
        print(f"    {what}: {said}", flush=True)
    return found


if __name__ == "__main__":
    sys.exit(main())
