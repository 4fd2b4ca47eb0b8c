"""Header keys that are not understood though they are nearly those that are."""

from __future__ import annotations

from collections.abc import Iterator

from pyport.recordings.naming import key_meant
from pyport.recordings.raw import Raw


def notes(raw: Raw) -> Iterator[tuple[str, str]]:
    """Yield each such key, and that it is not used and which one may be meant.

    A key that is there in its right spelling is not missed; nor is the usual zero of azimuth.
    """
    for key, value in raw.meta.items():
        right = key_meant(key, value)
        if right is None or key in raw.columns or right in raw.meta:
            continue
        if right == "azimuth_zero" and "south" not in value.lower():
            continue
        line = f" in line {raw.key_line[key]}" if key in raw.key_line else ""
        said = f"header key {key!r}{line} is not known and not used: {right!r} may be meant"
        yield key, said
