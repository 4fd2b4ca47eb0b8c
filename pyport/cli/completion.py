"""`pyport completion`: what a shell needs to complete commands, options and names."""

from __future__ import annotations

import click


@click.command(
    "completion",
    epilog='Examples: eval "$(pyport completion bash)" in ~/.bashrc; '
    "pyport completion fish > ~/.config/fish/completions/pyport.fish",
)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str) -> None:
    """Print the lines that teach SHELL to complete pyport's commands, options and names."""
    from click.shell_completion import get_completion_class

    from pyport.cli import pyport

    kind = get_completion_class(shell)
    if kind is None:  # the choice above holds only what click knows
        raise click.UsageError(f"no completion for {shell}")
    click.echo(kind(pyport, {}, "pyport", "_PYPORT_COMPLETE").source())
