"""A pytest plugin: ``pytest --parity parity.toml`` holds the ports that it describes.

One test for each routine, port and group of inputs, and one in which Hypothesis looks for an input
of its own. Everything else is imported when such a test is collected.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pyport.parity.described.description import Description, Group, Port, Routine

#: Points that a test draws of each group that draws, and examples that Hypothesis tries.
POINTS, EXAMPLES = 1000, 100


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("parity", "ports held to their Fortran")
    group.addoption("--parity", action="append", default=[], metavar="PARITY.TOML")
    group.addoption("--parity-points", type=int, default=POINTS, metavar="N")
    group.addoption("--parity-examples", type=int, default=EXAMPLES, metavar="N")


def pytest_configure(config: pytest.Config) -> None:
    """Have the descriptions collected beside whatever else is."""
    config.args.extend(str(Path(one).resolve()) for one in config.getoption("--parity"))


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Collect a description that was named."""
    named = {Path(one).resolve() for one in parent.config.getoption("--parity")}
    return ParityFile.from_parent(parent, path=file_path) if file_path in named else None


class ParityFile(pytest.File):
    """A description."""

    def collect(self) -> Iterator[pytest.Item]:
        """Yield a test for each routine, port and group."""
        from pyport.errors import BadInput
        from pyport.parity.described.loading import load

        try:
            description = load(self.path)
        except BadInput as error:
            raise self.CollectError(str(error)) from None
        for routine in description.routines:
            for port in description.ports_of(routine):
                for group in (*description.groups, None):
                    name = f"{routine.name}-{port.name}-{group.name if group else 'hypothesis'}"
                    yield ParityItem.from_parent(
                        self, name=name, case=(description, routine, port, group)
                    )


class ParityItem(pytest.Item):
    """One port of one routine at one group of inputs; without a group wherever Hypothesis looks."""

    def __init__(self, *, case: tuple[Description, Routine, Port, Group | None], **arguments: Any):  # noqa: ANN401
        super().__init__(**arguments)
        self.case = case

    def runtest(self) -> None:
        """Fail where the promise is broken."""
        from pyport.parity.compiled import oracle

        description, _, _, group = self.case
        live = oracle.available(description)
        broken = self._at(group, live=live) if group else self._anywhere(live=live)
        if broken:
            raise BrokenPromise(broken)

    def _at(self, group: Group, *, live: bool) -> str:
        from pyport.parity.compiled import stored
        from pyport.parity.described import inputs
        from pyport.parity.described.functions import ask_port
        from pyport.parity.evidence.shrink import failing, minimal
        from pyport.parity.promise import kept
        from pyport.parity.run import asker, hold_live, hold_stored

        description, routine, port, _ = self.case
        if live:
            points = self.config.getoption("--parity-points")
            batch = inputs.points(description, group, routine, points, 0)
            held = hold_live(description, routine, batch)[port.name, routine.name]
        else:
            known = stored.load(description, group, routine)
            held = hold_stored(description, routine, known, ask_port)[port.name, routine.name]
        if kept(port, routine, held):
            return ""
        ask = asker(description)
        fails = (lambda *of: failing(description, ask, *of)) if live else None
        lines = [str(one) for one in held.beyond if one.differing]
        return "\n".join([*lines, f"minimal: {minimal(port, routine, held, fails)}"])

    def _anywhere(self, *, live: bool) -> str:
        from pyport.parity.evidence.shrink import search
        from pyport.parity.run import asker

        description, routine, port, _ = self.case
        pytest.importorskip("hypothesis")
        if not live:
            pytest.skip("no Fortran or no compiler: the stored answers are all there is")
        if routine.sequence or not routine.inputs:
            pytest.skip("it has no inputs, or remembers: its answers depend on more than a point")
        examples = self.config.getoption("--parity-examples")
        found = search(description, port, routine, asker(description), examples)
        return "" if found is None else f"minimal: {found}"

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:  # noqa: ANN401
        """Say what differs; a traceback would show the plugin alone."""
        from pyport.errors import BadInput

        if isinstance(excinfo.value, BrokenPromise | BadInput):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Return what a report calls it."""
        return self.path, None, f"parity: {self.name}"


class BrokenPromise(Exception):  # noqa: N818 - reads as the sentence it is
    """A port that breaks its promise."""
