"""Break the port, and the Fortran, in every small way, and see whether the comparison notices.

A mutant of the port is killed when its answers leave the oracle's stored answers or, failing that,
the compiled oracle's at more points. A mutant of the Fortran is compiled as an oracle of its own;
the unchanged port must leave it. Survivors must be explained in the description's file.
"""

from __future__ import annotations

import contextlib
import importlib.machinery
import importlib.util
import math
import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.parity.compare import Pair
from pyport.parity.compiled import build as building
from pyport.parity.compiled import oracle, stored
from pyport.parity.described import inputs
from pyport.parity.described.description import Batch, Description, Group, Port, Routine
from pyport.parity.described.functions import Function, ask_port, part, resolve, size
from pyport.parity.evidence.mutations import Mutant, fortran_mutants, mutants
from pyport.runs.stages import track

#: Points that are looked at first: most mutants are killed by them.
FIRST = 200
#: What a mutant may call that its module does not import.
INJECTED = {
    "real4": np.float32,
    "real8": np.float64,
    "dsin": math.sin,
    "dcos": math.cos,
    "dtan": math.tan,
}

#: The answers that a mutant has to survive, by routine.
Reference = dict[str, tuple[Batch, Batch]]


class _Mutated(importlib.machinery.SourceFileLoader):
    """Finds one module, the mutant, and loads it from another text than its file's."""

    def __init__(self, name: str, path: str, source: str):
        super().__init__(name, path)
        self.source = source

    def get_code(self, fullname: str) -> Any:  # noqa: ANN401, ARG002 - the base class's
        """Return the code of the other text."""
        return self.source_to_code(self.source.encode(), self.path)

    def exec_module(self, module: ModuleType) -> None:
        """Run the text where a mutant finds what it may call."""
        vars(module).update(INJECTED)
        super().exec_module(module)

    def find_spec(self, fullname: str, *_: object) -> importlib.machinery.ModuleSpec | None:
        """Return the mutant's specification."""
        if fullname != self.name:
            return None
        return importlib.util.spec_from_file_location(fullname, self.path, loader=self)


def modules_of(description: Description, port: Port) -> dict[str, Path]:
    """Return the modules that hold a port's functions, by name."""
    found = {}
    for routine in description.routines:
        if port.name in routine.ports:
            function = resolve(description, routine.ports[port.name])
            file = sys.modules[function.__module__].__file__
            if file is not None:
                found[function.__module__] = Path(file)
    return found


@contextlib.contextmanager
def mutated(
    description: Description, port: Port, modules: dict[str, Path], changed: str, source: str
) -> Iterator[dict[str, Function]]:
    """Provide a port's functions by routine, with one module's source replaced.

    The other modules of the port are imported anew, so that they find the mutant; afterwards
    everything is as it was.
    """
    names = set(modules)
    for one in description.routines:
        if port.name in one.ports:
            names.add(one.ports[port.name].partition(":")[0])
    before = {name: sys.modules.pop(name) for name in names if name in sys.modules}
    finder = _Mutated(changed, str(modules[changed]), source)
    sys.meta_path.insert(0, finder)
    try:
        yield {
            one.name: resolve(description, one.ports[port.name])
            for one in description.routines
            if port.name in one.ports
        }
    finally:
        sys.meta_path.remove(finder)
        for name in names:
            sys.modules.pop(name, None)
        sys.modules.update(before)
        for name, module in before.items():
            parent, _, last = name.rpartition(".")
            # a package that stayed got the new module as an attribute
            if parent in sys.modules and parent not in before:
                setattr(sys.modules[parent], last, module)


def notices(
    description: Description, port: Port, functions: dict[str, Function], reference: Reference
) -> bool:
    """Tell whether the functions' answers differ from the expected ones, looking at a few first."""
    for some in (slice(0, FIRST), slice(FIRST, None)):
        for name, function in functions.items():
            if name not in reference:
                continue
            # what remembers is asked from the start again
            here = slice(0, some.stop) if description.routine(name).sequence else some
            batch, expected = (part(one, here) for one in reference[name])
            if size(batch) and _differs(description, port, name, function, batch, expected):
                return True
    return False


def _differs(
    description: Description, port: Port, name: str, function: Function, batch: Batch, right: Batch
) -> bool:
    routine = description.routine(name)
    try:
        actual = ask_port(description, port, routine, batch, function)
    except (BadInput, ArithmeticError, LookupError, ValueError, TypeError, NameError):
        return True
    apart = Pair(routine, batch, right, actual, actual.raised).distances()
    return any(one.any() for one in apart.values())


def references(description: Description, random_points: int) -> Iterator[tuple[str, Reference]]:
    """Yield what a mutant has to survive, the quick sets first."""
    for group in sorted(description.groups, key=lambda one: bool(one.sample)):
        yield _reference(description, group)
    if oracle.available(description):
        asked = oracle.of(description.path, "reference")
        more: Reference = {}
        for routine in description.routines:
            batch = inputs.some(description, routine, random_points, 80)
            more[routine.name] = batch, asked.ask(routine, batch)
        yield "oracle", more


def _reference(description: Description, group: Group) -> tuple[str, Reference]:
    found: Reference = {}
    on_paper = all(stored.path_of(description, group, r).is_file() for r in description.routines)
    for routine in description.routines:
        if on_paper:
            known = stored.load(description, group, routine)
            found[routine.name] = known.batch, known.answers
        else:
            batch = inputs.sample(description, group, routine)
            asked = oracle.of(description.path, "reference")
            found[routine.name] = batch, asked.ask(routine, batch)
    return f"{'stored ' if on_paper else ''}{group.name}", found


def port_survivors(
    description: Description, port: Port, random_points: int
) -> tuple[int, list[str], dict[str, int]]:
    """Run the mutants of a port; return their number, the survivors, and what killed how many."""
    modules = modules_of(description, port)
    made: list[tuple[str, Mutant]] = [
        (name, mutant)
        for name, path in modules.items()
        for mutant in mutants(name.rpartition(".")[2], path.read_text(encoding="utf-8"))
    ]
    left, killed = made, {}
    for name, reference in references(description, random_points):
        survivors = []
        for module, mutant in track(left, f"Mutants against {name}"):
            try:
                with mutated(description, port, modules, module, mutant.source) as functions:
                    if not notices(description, port, functions, reference):
                        survivors.append((module, mutant))
            except (ArithmeticError, NameError, TypeError, ValueError, ImportError):
                continue  # it does not even load
        killed[name] = len(left) - len(survivors)
        left = survivors
        if not left:
            break
    return len(made), [mutant.name for _, mutant in left], killed


def fortran_survivors(
    description: Description, port: Port, most: int
) -> tuple[list[str], list[str]]:
    """Compile mutants of the Fortran; return all, and those that the port's answers agree with.

    The description's own mutants, or `most` of those that can be made of the text, evenly.
    """
    reference: dict[str, list[tuple[Batch, Batch]]] = {}
    for group in description.groups:
        for name, (batch, _) in _reference(description, group)[1].items():
            routine = description.routine(name)
            if port.name in routine.ports:
                answers = ask_port(description, port, routine, batch)
                reference.setdefault(name, []).append((batch, answers))
    tried, survivors = [], []
    for label, file, text in track(_fortran_mutants(description, most), "Mutants of the Fortran"):
        try:
            library = building.library(description, description.reference, {file: text})
        except BadInput as error:
            if description.mutants:
                raise BadInput(f"{label}: {error}", description.path) from None
            continue
        tried.append(label)
        try:
            if not _leaves(description, library, reference):
                survivors.append(label)
        finally:
            shutil.rmtree(library.parent, ignore_errors=True)
    return tried, survivors


def _fortran_mutants(description: Description, most: int) -> list[tuple[str, str, str]]:
    texts = building.sources(description, description.reference)
    if not description.mutants:
        made = [
            (label, name, text)
            for name in (one.name for one in description.files)
            for label, text in fortran_mutants(name, texts[name])
        ]
        return made[:: max(1, math.ceil(len(made) / most))] if most else []
    found = []
    for file, was, became in description.mutants:
        if texts.get(file, "").count(was) != 1:
            raise BadInput(f"mutants: {was!r} does not stand once in {file}", description.path)
        found.append((f"{file}: {was} -> {became}", file, texts[file].replace(was, became)))
    return found


def _leaves(
    description: Description, library: Path, reference: dict[str, list[tuple[Batch, Batch]]]
) -> bool:
    """Tell whether the port's answers leave those of a mutated library."""
    asked = oracle.Oracle(description, description.reference, library)
    try:
        for name, sets in reference.items():
            routine: Routine = description.routine(name)
            for batch, port in sets:
                try:
                    answers = asked.ask(routine, batch)
                except BadInput:  # it ends the program, or changes what it must not
                    return True
                apart = Pair(routine, batch, answers, port).distances()
                if any(one.any() for one in apart.values()):
                    return True
    finally:
        asked.close()
    return False


def mutate(description: Description, random_points: int, fortran: int) -> dict[str, Any]:
    """Make and run all mutants of the first port that promises bits, and of the Fortran."""
    port = next((one for one in description.ports if one.promise == "bits"), description.ports[0])
    reasons = _reasons(description)
    number, survivors, killed = port_survivors(description, port, random_points)
    tried, unnoticed = fortran_survivors(description, port, fortran)
    return {
        "schema": "pyport.parity-mutants/1",
        "port": number,
        "killed": killed,
        "survivors": [{"mutant": name, "reason": reasons.get(name)} for name in survivors],
        "outdated": sorted(set(reasons) - set(survivors) - set(unnoticed)),
        "fortran": tried,
        "fortran_survivors": [n for n in unnoticed if n not in reasons],
    }


def _reasons(description: Description) -> dict[str, str]:
    path = description.survivors
    if path is None or not path.is_file():
        return {}
    try:
        rows = tomllib.loads(path.read_text(encoding="utf-8")).get("survivor", [])
        return {one["mutant"]: one["reason"] for one in rows}
    except (ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{error!r}: expected [[survivor]] with mutant and reason", path) from None


def show(content: dict[str, Any]) -> str:
    """Return what became of the mutants as text."""
    lines = [f"{content['port']} mutants of the port:"]
    lines += [f"  {number:4} killed by {name}" for name, number in content["killed"].items()]
    lines.append(f"  {len(content['survivors']):4} survived")
    for one in content["survivors"]:
        lines += [f"  {one['mutant']}", f"    {one['reason'] or 'NOT EXPLAINED'}"]
    unnoticed = content["fortran_survivors"]
    lines.append(f"{len(content['fortran'])} mutants of the Fortran: {len(unnoticed)} survived")
    lines += [f"  {name}" for name in unnoticed]
    lines += [f"explained as a survivor, yet killed or gone: {n}" for n in content["outdated"]]
    return "\n".join(lines)


def complete(content: dict[str, Any]) -> bool:
    """Tell whether every mutant was noticed, or its survival explained."""
    unexplained = [one for one in content["survivors"] if not one["reason"]]
    return not (unexplained or content["fortran_survivors"] or content["outdated"])
