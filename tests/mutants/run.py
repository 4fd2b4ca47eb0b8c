"""Break the noise, the diagnosis, the fit and the effects in small ways; see what the tests notice.

`make mutants-diagnosis`. Every threshold is doubled and halved; mutants.toml has the others: a
text that stands once in a file, what it becomes, and the tests that must fail. All tests are
collected once; each mutant is a forked process, in which the code of one module is changed and
those tests run up to the first failure. Survivors must be explained.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import dataclasses
import importlib
import os
import re
import sys
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

ROOT = Path(__file__).parent.parent.parent
LIST = Path(__file__).with_name("mutants.toml")
DECISIONS = "tests/diagnosis/decisions"


@dataclass(frozen=True)
class Mutant:
    """A change of one file, what it is of, the tests that must notice, why it may survive."""

    of: str
    file: str
    was: str
    became: str
    tests: tuple[str, ...]
    reason: str = ""
    first: str = ""

    @property
    def name(self) -> str:
        """Return what is changed, on one line."""
        return " ".join(f"{self.file}: {self.was} -> {self.became}".split())

    @property
    def module(self) -> str:
        """Return the dotted name of the changed module."""
        return "pyport." + self.file.removesuffix(".py").replace("/", ".")

    @property
    def text(self) -> str:
        """Return the file as the mutant has it."""
        return self.before.replace(self.was, self.became)

    @property
    def before(self) -> str:
        """Return the file as it is."""
        return (ROOT / "pyport" / self.file).read_text(encoding="utf-8")


def thresholds() -> Iterator[Mutant]:
    """Yield every threshold doubled and halved."""
    text = (ROOT / "pyport" / "thresholds.py").read_text(encoding="utf-8")
    notes = tomllib.loads(LIST.read_text(encoding="utf-8"))
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name, value = node.targets[0].id, ast.unparse(node.value)
            was = re.search(rf"^{name} = .*$", text, re.MULTILINE)[0]
            half = f"{value} // 2" if re.fullmatch(r"\d+", value) else f"({value}) / 2"
            for became in (f"2 * ({value})", half):
                label = f"{name} = {became}"
                reason = notes["reasons"].get(label, "")
                changed = "thresholds.py", was, label
                yield Mutant("thresholds", *changed, (DECISIONS,), reason, notes["first"][name])


def listed() -> Iterator[Mutant]:
    """Yield the mutants of the list."""
    for group in tomllib.loads(LIST.read_text(encoding="utf-8"))["group"]:
        for row in group["mutants"]:
            was, became, *reason = row[1:]
            tests = tuple(group["tests"])
            yield Mutant(group["of"], row[0], was, became, tests, *reason)


def put_in_place(mutant: Mutant) -> None:
    """Give the functions of a module the code of its changed text, and its numbers to all."""
    module = importlib.import_module(mutant.module)
    new = ModuleType(mutant.module)
    new.__file__ = module.__file__
    exec(compile(mutant.text, str(module.__file__), "exec"), vars(new))  # noqa: S102 - a mutant
    for name, was in list(vars(module).items()):
        became = vars(new).get(name)
        if name.lstrip("_").isupper() and isinstance(was, int | float | tuple):
            for other in list(sys.modules.values()):
                if getattr(other, name, None) is was:
                    setattr(other, name, became)
    _patch(vars(module), vars(new), mutant.module, set())


def _patch(  # noqa: C901 - one case a kind of what holds code
    was: Any, became: Any, module: str, seen: set[int]
) -> None:
    """Change code in functions, classes and what holds them, of one module, one by one."""
    if id(was) in seen or type(was) is not type(became):
        return
    seen.add(id(was))
    pairs: list[tuple[Any, Any]] = []
    if isinstance(was, FunctionType):
        if was.__module__ == module:
            with contextlib.suppress(ValueError):  # another number of free variables
                was.__code__ = became.__code__
                was.__defaults__ = became.__defaults__
            cells = zip(was.__closure__ or (), became.__closure__ or (), strict=False)
            pairs = [(one.cell_contents, other.cell_contents) for one, other in cells]
            pairs.append((getattr(was, "__wrapped__", None), getattr(became, "__wrapped__", None)))
    elif isinstance(was, property):
        pairs = [(was.fget, became.fget)]
    elif isinstance(was, cached_property):
        pairs = [(was.func, became.func)]
    elif isinstance(was, classmethod | staticmethod):
        pairs = [(was.__func__, became.__func__)]
    elif isinstance(was, type):
        if was.__module__ == module:
            pairs = [(one, vars(became).get(name)) for name, one in vars(was).items()]
    elif isinstance(was, dict):
        pairs = [(one, became.get(name)) for name, one in list(was.items())]
    elif isinstance(was, list | tuple):
        pairs = list(zip(was, became, strict=False))
    elif dataclasses.is_dataclass(was):
        pairs = [(getattr(was, f.name), getattr(became, f.name)) for f in dataclasses.fields(was)]
    for one, other in pairs:
        _patch(one, other, module, seen)


class Loop:
    """Runs mutants in the place of the tests that were collected."""

    def __init__(self, mutants: list[Mutant], jobs: int, patience_s: float):
        self.mutants, self.jobs, self.patience_s = mutants, jobs, patience_s
        self.killed: dict[Mutant, bool] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Fork a process for every mutant; one whose tests do not end in time is killed by them."""
        waiting, running = self.mutants[::-1], {}
        while waiting or running:
            while waiting and len(running) < self.jobs:
                mutant = waiting.pop()
                child = os.fork()
                if child == 0:
                    self._run(session.items, mutant)
                running[child] = mutant, time.monotonic() + self.patience_s
            time.sleep(0.02)
            for child, (mutant, until) in list(running.items()):
                done, status = os.waitpid(child, os.WNOHANG)
                if not done and time.monotonic() > until:
                    os.kill(child, 9)
                    done, status = os.waitpid(child, 0)
                if done:
                    del running[child]
                    self.killed[mutant] = status != 0
                    if status == 0 and mutant.was:
                        say(f"survived: {mutant.name}\n    {mutant.reason or 'NOT EXPLAINED'}")
        return True

    def _run(self, items: list[pytest.Item], mutant: Mutant) -> None:
        """Run the tests of a mutant in this process, and end it."""
        status = 1
        with contextlib.suppress(BaseException), Path(os.devnull).open("w") as nothing:
            os.dup2(nothing.fileno(), 1)
            os.dup2(nothing.fileno(), 2)
            if mutant.was:
                put_in_place(mutant)
            status = int(any(_fails(one) for one in self.of(items, mutant)))
        os._exit(status)

    def of(self, items: list[pytest.Item], mutant: Mutant) -> Iterator[pytest.Item]:
        """Yield the tests of a mutant: what it names first, then in the order of its files."""
        own = [one for test in mutant.tests for one in items if one.nodeid.startswith(test)]
        if mutant.first:
            own.sort(key=lambda one: mutant.first not in one.nodeid)
        yield from own


def _fails(item: pytest.Item) -> bool:
    return any(one.failed for one in runtestprotocol(item, nextitem=None, log=False))


def say(line: str) -> None:
    """Print a line at once."""
    sys.__stdout__.write(line + "\n")
    sys.__stdout__.flush()


def main() -> int:
    """Run all mutants, or those of some groups, and print what survived; 1 for an unexplained."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("of", nargs="*", help="groups; all by default")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--patience", type=float, default=300, help="seconds for one's tests")
    asked = parser.parse_args()
    every = [one for one in (*thresholds(), *listed()) if not asked.of or one.of in asked.of]
    files = tuple(dict.fromkeys(test for one in every for test in one.tests))
    unchanged = Mutant("unchanged", "", "", "", files)
    gone = [one for one in every if one.before.count(one.was) != 1]
    every = [one for one in every if one not in gone]
    for one in gone:
        say(f"does not stand once in the file any more: {one.name}")
    os.chdir(ROOT)
    start = time.monotonic()
    loop = Loop([unchanged, *every], asked.jobs, asked.patience)
    options = ("--assert=plain", "-p", "no:cacheprovider", "-p", "no:terminal")
    pytest.main([*options, *files], plugins=[loop])
    if loop.killed.pop(unchanged, True):
        say("the tests fail without a mutant")
        return 2
    for of in dict.fromkeys(one.of for one in every):
        own = [loop.killed[one] for one in every if one.of == of]
        say(f"{of:14} {sum(own):4} of {len(own):4} killed")
    for one, dead in loop.killed.items():
        if dead and one.reason:
            say(f"explained as a survivor, yet killed: {one.name}")
    dead, took = sum(loop.killed.values()), time.monotonic() - start
    say(f"{dead} of {len(every)} mutants killed, {100 * dead / len(every):.1f} %, in {took:.0f} s")
    left = (one for one, killed in loop.killed.items() if not killed)
    return int(bool(gone) or not all(one.reason for one in left))


if __name__ == "__main__":
    sys.exit(main())
