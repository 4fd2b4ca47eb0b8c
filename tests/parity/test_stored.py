"""The oracle's stored answers: complete, small, and rewritten to the same bytes."""

import numpy as np
import pytest

from pyport.errors import BadInput
from pyport.parity import golden, stored
from pyport.parity.points import table


@pytest.mark.oracle
@pytest.mark.usefixtures("same_library")
@pytest.mark.parametrize("name", stored.SETS)
def test_rewriting_changes_nothing(oracle, name, tmp_path):
    """The installed oracle gives the stored numbers, and a file that holds them is left alone."""
    path = tmp_path / f"{name}.json"
    path.write_bytes((stored.FOLDER / path.name).read_bytes())

    assert golden.write(oracle, name, tmp_path) is False


@pytest.mark.oracle
@pytest.mark.usefixtures("same_library")
def test_changed_number_is_rewritten(oracle, tmp_path):
    """A stored file with one digit changed is put right."""
    true = (stored.FOLDER / "edges.json").read_text()
    path = tmp_path / "edges.json"
    path.write_text(true.replace('"0x1p+0", ', '"0x0p+0", ', 1))

    assert golden.write(oracle, "edges", tmp_path) is True
    assert path.read_text().partition('"units"')[2] == true.partition('"units"')[2]


@pytest.mark.parametrize("name", ["table", "edges"])
def test_stored_points_are_those_of_the_set(name, tmp_path):
    """A stored file holds the very points that its set is made of."""
    kept, at = stored.load(name).at, golden.points_of(name, tmp_path)

    np.testing.assert_array_equal(kept.az, at.az)
    np.testing.assert_array_equal(kept.alt, at.alt)
    np.testing.assert_array_equal(kept.p, at.p)


def test_digests_tell_azimuths_apart():
    """One changed bit in the table changes the digest of its azimuth alone."""
    answers = np.ones((len(table()), 5), dtype=np.float32)
    changed = answers.copy()
    changed[95 * 7 + 3, 2] = np.nextafter(changed[0, 2], np.float32(2))
    differing = [
        i
        for i, (a, b) in enumerate(
            zip(stored.digests(answers), stored.digests(changed), strict=True)
        )
        if a != b
    ]

    assert differing == [7]


@pytest.mark.parametrize(
    ("text", "message"), [("", "no JSON"), ('{"schema": "x/1"}', "expected schema")]
)
def test_broken_file_is_named(tmp_path, text, message):
    """A stored file that cannot be read is named with what was expected."""
    (tmp_path / "table.json").write_text(text)

    with pytest.raises(BadInput, match=message):
        stored.load("table", tmp_path)
