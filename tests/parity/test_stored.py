"""The oracle's stored answers: complete, small, and rewritten to the same bytes."""

import dataclasses

import numpy as np
import pytest
import rt32

from pyport.errors import BadInput
from pyport.parity.compiled import oracle as compiled
from pyport.parity.compiled import stored
from pyport.parity.described import inputs

SETS = [(group, routine) for group in rt32.GROUPS for routine in ("Model", "ModelA", "Hjump")]


@pytest.fixture
def beside(tmp_path):
    """Return the description with its answers in a folder of the test's."""
    return dataclasses.replace(rt32.DESCRIPTION, answers=tmp_path)


@pytest.fixture
def oracles(oracle):
    """Return both compiled builds."""
    return {"reference": oracle, "promoted": compiled.of(rt32.DESCRIPTION.path, "promoted")}


@pytest.mark.oracle
@pytest.mark.usefixtures("same_library")
@pytest.mark.parametrize(("group", "routine"), SETS)
def test_rewriting_changes_nothing(oracles, group, routine, beside):
    """The oracle gives the stored numbers, and a file that holds them is left alone."""
    group, routine = rt32.GROUPS[group], rt32.DESCRIPTION.routine(routine)
    there = stored.path_of(rt32.DESCRIPTION, group, routine)
    stored.path_of(beside, group, routine).write_bytes(there.read_bytes())

    assert stored.write(beside, group, routine, oracles) is False


@pytest.mark.oracle
@pytest.mark.usefixtures("same_library")
def test_changed_number_is_rewritten(oracles, beside):
    """A stored file with one digit changed is put right."""
    group, routine = rt32.GROUPS["edges"], rt32.DESCRIPTION.routine("Hjump")
    true = stored.path_of(rt32.DESCRIPTION, group, routine).read_text()
    path = stored.path_of(beside, group, routine)
    path.write_text(true.replace('"0x1p+0", ', '"0x0p+0", ', 1))

    assert stored.write(beside, group, routine, oracles) is True
    assert path.read_text().partition('"units"')[2] == true.partition('"units"')[2]


@pytest.mark.parametrize(("group", "routine"), SETS)
def test_stored_points_are_those_of_the_set(group, routine):
    """A stored file holds the very points that its set is made of."""
    group, routine = rt32.GROUPS[group], rt32.DESCRIPTION.routine(routine)
    kept = stored.load(rt32.DESCRIPTION, group, routine).batch
    if group.draws:
        assert {len(values) for values in kept.values()} == {group.keep}
        return
    made = inputs.sample(rt32.DESCRIPTION, group, routine)

    assert kept.keys() == made.keys()
    assert all(kept[key].tobytes() == made[key].tobytes() for key in kept)


def test_digests_distinguish_azimuths():
    """One changed bit in the table changes the digest of its azimuth alone."""
    group, routine = rt32.GROUPS["table"], rt32.DESCRIPTION.routine("Model")
    answers = {one.key: np.ones(541 * 95, dtype=np.float32) for one in routine.outputs}
    before = stored.digests(routine, group, answers)
    answers["dalt"][95 * 7 + 3] = np.nextafter(np.float32(1), np.float32(2))
    after = stored.digests(routine, group, answers)

    assert [i for i, (a, b) in enumerate(zip(before, after, strict=True)) if a != b] == [7]


@pytest.mark.parametrize(
    ("text", "message"),
    [("", "no JSON"), ('{"schema": "x/1"}', "expected schema"), (None, "is not there")],
)
def test_broken_file_is_named(beside, text, message):
    """A stored file that cannot be read is named with what was expected."""
    group, routine = rt32.GROUPS["table"], rt32.DESCRIPTION.routine("Model")
    if text is not None:
        stored.path_of(beside, group, routine).write_text(text)

    with pytest.raises(BadInput, match=message):
        stored.load(beside, group, routine)
