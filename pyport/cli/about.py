"""Options that say about a file what it does not say itself."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from pyport.cli.manners import option


def _pairs(_: click.Context, option: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Return KEY=VALUE arguments as a dictionary."""
    pairs = {}
    for one in given:
        key, equals, value = one.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise click.BadParameter(f"{one!r}, expected KEY=VALUE", param=option)
        pairs[key.strip()] = value.strip()
    return pairs


def _columns(
    _: click.Context, __: click.Parameter, given: str | None
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return names that commas separate, and the map of columns that stands in their place."""
    if given is None:
        return (), {}
    if "=" in given or given.endswith(".toml"):
        from pyport.recordings.formats.mapped import parse

        return (), parse(given)
    return tuple(name.strip() for name in given.split(",")), {}


def about_file(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add options on a file of recordings; the command gets them as `given`, a `FileOptions`."""

    @functools.wraps(command)
    def bundled(
        about: dict[str, str],
        columns: tuple[tuple[str, ...], dict[str, str]],
        read_as: str,
        where: str,
        mount: str | None,
        **others: Any,  # noqa: ANN401 - whatever the command takes
    ) -> Any:  # noqa: ANN401 - whatever the command returns
        from pyport.recordings.raw import FileOptions

        names, mapping = columns
        if mount is not None:
            about = about | {"mount": mount}
        return command(given=FileOptions(about, names, read_as, where, mapping), **others)

    for add in reversed(_OPTIONS):
        bundled = add(bundled)
    return bundled


_OPTIONS = (
    option(
        "--set about",
        "A header key that the file lacks, such as latitude_deg=53.0955; repeat for more.",
        multiple=True,
        callback=_pairs,
        metavar="KEY=VALUE",
    ),
    option(
        "--columns",
        "Columns by other names: 'az_deg=AZd, d_el_arcsec=-dEl, session=id|date', by number "
        "(az_deg=8), or a MAP.toml of `pyport look`; or NAME,NAME for a CSV without a header.",
        callback=_columns,
        metavar="MAP",
    ),
    option(
        "--from read_as",
        "The file's format, where its suffix does not say it: see `pyport convert`.",
        metavar="FORMAT",
        default="",
    ),
    option(
        "--mount",
        "What the mount is: wheel-and-track, bearing, ...; as '# mount:' in the file.",
        metavar="KIND,KIND",
    ),
    option(
        "--where",
        'Use only these: --where "wind_speed_m_s < 5 and sun_el_deg < 0".',
        metavar="EXPRESSION",
        default="",
    ),
)
