"""The columns of recordings: each once, and listed for those who write files."""

import re
from pathlib import Path

from pyport.columns import ANGLES, COLUMNS, LABELS, SPELLED, angle_of, shown

MANUAL = Path(__file__).parents[1] / "docs" / "recordings.md"


def test_each_column_stands_once() -> None:
    """No two columns share a name, here or in files."""
    names = [one.name for one in COLUMNS]
    written = [one.spelled for one in COLUMNS]

    assert len(set(names)) == len(names)
    assert len(set(written)) == len(written)


def test_the_manual_lists_each_column() -> None:
    """Who writes a file finds every column, as files spell it, in the table of the manual."""
    listed = set(re.findall(r"`([a-z_0-9]+)`", MANUAL.read_text("utf-8")))
    wanted = {
        f"{one.name}_deg" if one.name in ANGLES and not one.written else one.spelled
        for one in COLUMNS
    }

    assert wanted <= listed


def test_names_in_files_lead_back() -> None:
    """A written name means the column it is of, and a picture has words for it."""
    for one in COLUMNS:
        angle = angle_of(one.spelled)
        if angle is not None:
            assert angle == (one.name, one.scale)
        assert shown(one.name)[0] == one.words
        assert one.name in LABELS or SPELLED.get(one.name, one.name) == one.spelled
