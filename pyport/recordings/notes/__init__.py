"""What a file of recordings says against itself. It is read all the same; these notes are shown."""

from dataclasses import replace

from pyport.recordings.notes import directions, keys, offsets, times
from pyport.recordings.raw import REFRACTION, Raw
from pyport.recordings.schema import Recordings


def noted(recordings: Recordings, raw: Raw) -> Recordings:
    """Return recordings with the notes of what `raw`, which they were read from, says of them."""
    return replace(recordings, notes=tuple(sentences(recordings, raw).values()))


def sentences(recordings: Recordings, raw: Raw, *, by_row: bool = True) -> dict[str, str]:
    """Return a sentence for each kind of contradiction that there is, by what it is of.

    `by_row`: whether `--where` chooses among the rows of `raw`, and not among means of them.
    """
    found = {
        **{f"{KEY}{key}": text for key, text in keys.notes(raw)},
        "directions": directions.note(recordings, raw),
        "horizon": directions.below(recordings),
        "radians": directions.radians(recordings),
        "reader": raw.note,
        "refraction": raw.meta.get(REFRACTION, ""),
        "times": times.note(recordings),
        "offsets": offsets.note(recordings, raw, by_row=by_row),
    }
    return {kind: text for kind, text in found.items() if text}


#: What is of a header key, and of no row.
KEY = "key "
#: A log may grow by single rows, and one bad row says nothing of the others.
FEWEST_ROWS = 3
