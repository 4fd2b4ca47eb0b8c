"""Groups of commands: one file a command, imported when it is called; names of former versions."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

import click

from pyport.cli.manners import with_quiet


class Lazy(click.Group):
    """A group that imports a command's module only when the command is asked for.

    Parameters
    ----------
    name
        The group's name on the command line.
    package
        The package whose modules define one `command` each.
    sentences
        Command -> the sentence that `--help` shows without importing it.
    former
        Name of a former version -> the words that stand for it now.
    """

    def __init__(
        self,
        name: str,
        package: str,
        sentences: Mapping[str, str],
        former: Mapping[str, str] | None = None,
        **attributes: Any,  # noqa: ANN401 - click's
    ) -> None:
        settings = {"help_option_names": ["-h", "--help"]}
        super().__init__(name, context_settings=settings, **attributes)
        self.package = package
        self.sentences = dict(sorted(sentences.items()))
        self.former = former or {}

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click's signature
        """Return the names of all commands."""
        return list(self.sentences)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import the module of a command and return its `command`."""
        if name in self.former:
            return self._former(ctx, name)
        if name not in self.sentences:
            return None
        module = importlib.import_module(f"{self.package}.{name.replace('-', '_')}")
        return with_quiet(module.command)

    def _former(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return the command that a former name stands for; its new name goes to standard error."""
        *groups, last = self.former[name].split()
        command: click.Command | None = self
        for word in (*groups, last):
            command = command.get_command(ctx, word) if isinstance(command, click.Group) else None
        if not ctx.resilient_parsing:
            click.echo(f"pyport: `pyport {name}` is `pyport {self.former[name]}` now", err=True)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """List the commands, importing none."""
        with formatter.section("Commands"):
            formatter.write_dl(list(self.sentences.items()))
