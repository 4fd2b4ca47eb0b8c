"""Examiner and pupil, who share no formula, mean the same by every name in the catalogue.

The examiner's offsets come from rotations and ERFA, the catalogue's from its
formulae; sign, size and shape must agree wherever the base lets them be seen.
"""

import numpy as np
import pytest

from pyport.effects import CATALOGUE
from pyport.effects.empirical.oscillations import oscillation
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.faults import SWALLOWED
from pyport.examiner.worlds.kinds import HIDEABLE, make_case
from pyport.examiner.worlds.mount import Stand
from pyport.recordings import read

#: Causes whose place has to be searched for first: no member of the family is the very one.
SEARCHED = {"subreflector_jump": 0.4, "source_position": 0.4}


def compared(effect, tmp_path):
    """Return the case and, for each member of the family, its cosine and coefficients by name."""
    kind = "held" if effect in SWALLOWED else "one"
    case = make_case(kind, 11, effect=effect, rho=0.5, rows=300, noise="white")
    path = tmp_path / "recordings.csv"
    write_recordings(case, path)
    recordings = read(path)
    has_x, has_y = np.isfinite(recordings.x), np.isfinite(recordings.y)

    def stack(x, y):
        return np.concatenate([x[has_x], y[has_y]])

    base, _ = np.linalg.qr(stack(*Stand().columns(recordings.at.az, recordings.at.el)))

    def left(columns):
        return columns - base @ (base.T @ columns) if kind == "one" else columns

    signature = left(stack(*case.signature))
    name = case.truth["effects"][0]["effect"]
    members = []
    period_s = case.truth["effects"][0]["facts"].get("period_s")
    known = [oscillation(period_s)] if period_s else CATALOGUE[name].variants(recordings.at)
    for member in known:
        columns = left(stack(*member.columns(recordings.at)))
        length = np.linalg.norm(columns, axis=0)
        seen = length > 0
        values, *_ = np.linalg.lstsq(columns[:, seen] / length[seen], signature, rcond=1e-8)
        fitted = columns[:, seen] / length[seen] @ values
        coefficients = [c for c, there in zip(member.coefficients, seen, strict=True) if there]
        found = {
            c.name: (value / c.scale, c.expected)
            for c, value in zip(coefficients, values / length[seen], strict=True)
        }
        members.append((np.linalg.norm(fitted) / np.linalg.norm(signature), found))
    return case, members


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect",
    [
        *(name for name in HIDEABLE if name != "wandering_oscillation"),  # it has no curve
        *(name for name in SWALLOWED if name != "ut1"),
    ],
)
def test_catalogue_and_rotations_agree(effect, tmp_path):
    """The best member of the family spans what the examiner made, and its coefficients are true."""
    case, members = compared(effect, tmp_path)
    cosine, found = max(members, key=lambda member: member[0])
    (cause,) = case.truth["effects"]

    assert cosine > SEARCHED.get(effect, 0.97)
    for name, true in cause["parameters"].items():
        if name in found and abs(true) > 0.2 * cause["size"] and effect not in SEARCHED:
            assert found[name][0] == pytest.approx(true, rel=0.03), name
    for name, (value, expected) in found.items():
        if expected is not None and cause["fixed_by_nature"]:
            assert value == pytest.approx(expected, rel=0.03), name
