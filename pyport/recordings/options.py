"""What a user says about a file that the file does not say itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class FileOptions:
    """Header keys and column names that come from the command line.

    Attributes
    ----------
    keys
        Header keys such as `latitude_deg`; they win over the file's own.
    columns
        Names of the columns of a CSV file without a line of names.
    mapping
        The contract's columns by what this file calls them: see `pyport.recordings.formats.mapped`.
    format
        The file's format, where its suffix does not tell it.
    where
        An expression: rows for which it does not hold are excluded.
    """

    keys: Mapping[str, str] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    format: str = ""
    where: str = ""
    mapping: Mapping[str, str] = field(default_factory=dict)


NOTHING = FileOptions()
