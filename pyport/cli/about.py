"""Options that say about a file what it does not say itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click


def _pairs(_: click.Context, option: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Return KEY=VALUE arguments as a dictionary."""
    pairs = {}
    for one in given:
        key, equals, value = one.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise click.BadParameter(f"{one!r}, expected KEY=VALUE", param=option)
        pairs[key.strip()] = value.strip()
    return pairs


def _names(_: click.Context, __: click.Parameter, given: str | None) -> tuple[str, ...]:
    """Return names that commas separate."""
    return () if given is None else tuple(name.strip() for name in given.split(","))


def about_file(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--set KEY=VALUE` (as `about`), `--columns` and `--from` (as `read_as`) to a command."""
    keys = click.option(
        "--set",
        "about",
        multiple=True,
        callback=_pairs,
        metavar="KEY=VALUE",
        help="A header key that the file lacks, such as latitude_deg=53.0955; repeat for more.",
    )
    columns = click.option(
        "--columns",
        callback=_names,
        metavar="NAME,NAME",
        help="Names of the columns of a CSV file without a header, units and all.",
    )
    read_as = click.option(
        "--from",
        "read_as",
        default="",
        metavar="FORMAT",
        help="The file's format, where its suffix does not tell: see `pyport convert`.",
    )
    return keys(columns(read_as(command)))
