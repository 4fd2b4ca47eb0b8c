"""What a file of recordings says against itself. It is read all the same; these notes are shown."""

from dataclasses import replace

from pyport.recordings.notes import directions, keys, offsets
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings


def noted(recordings: Recordings, raw: Raw) -> Recordings:
    """Return recordings with the notes of what `raw`, which they were read from, says of them."""
    notes = (
        *keys.notes(raw),
        directions.note(recordings, raw),
        directions.radians(recordings),
        offsets.note(recordings, raw),
    )
    return replace(recordings, notes=tuple(filter(None, notes)))
