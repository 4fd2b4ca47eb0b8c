"""The GMRT's elevation offsets of 2003."""

from pathlib import Path

NAMES: tuple[str, ...] = ()


def path(name: str) -> Path:
    raise KeyError(name)
