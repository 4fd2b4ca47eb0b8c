"""The comparator counts, ranks and names what differs."""

import numpy as np
import pytest
import rt32
from rt32_inputs import MODEL3_DEG, points

from pyport.parity.compare import UNLIKE, Comparison, Pair
from pyport.parity.described.description import Kind
from pyport.parity.described.functions import spell, unspell

AT = points([0.25, 0.5, 0.75], [0.5, 0.5, 0.5], MODEL3_DEG)
MODEL = rt32.DESCRIPTION.routine("Model")


def answers(*column):
    """Return answers of Model whose azimuth is `column` and whose altitude is zero."""
    return {"daz": np.float32(column), "dalt": np.zeros(len(column), np.float32)}


def compare(expected, actual, raised=None):
    """Compare answers of Model."""
    return Pair(MODEL, AT, expected, actual, raised or {}).compare()


def test_equal_answers_differ_nowhere():
    """Equal answers: nothing differs and there is no worst input."""
    first = compare(answers(1, 2, 3), answers(1, 2, 3))[0]

    assert (first.points, first.differing, first.most, first.worst) == (3, 0, 0, None)


def test_worst_input_is_named():
    """The line about a difference names routine, output, worst input and distance."""
    first, *others = compare(answers(1, 2, 3), answers(1, 2 + 2**-21, 3 + 2**-19))

    assert str(first).startswith("Model azimuth: 2 of 3 differ, worst by 8 ulp at Az=0x1.8p-1 ")
    assert [c.differing for c in others] == [0]


def test_quantiles_and_sum():
    """Comparisons add up; quantiles are those of the joined points."""
    one = compare(answers(1, 2, 3), answers(1, 2, 3 + 2**-20))[0]
    two = compare(answers(1, 1, 1), answers(1, np.nan, 1))[0]
    both = one + two

    assert (both.points, both.differing, both.most) == (6, 2, UNLIKE)
    assert both.quantile(0.5) == 0
    assert both.quantile(5 / 6) == 4
    assert both.worst == two.worst == (two + one).worst
    assert Comparison.from_json(both.as_json()) == both


def test_what_a_port_raises_is_its_answer():
    """An exception at one point differs there, and its text is what the port said."""
    first, second = compare(answers(1, 2, 3), answers(1, 2, 3), {1: "ValueError: domain"})

    assert (first.differing, second.differing, first.most) == (1, 1, UNLIKE)
    assert first.worst.actual == "ValueError: domain"
    assert first.worst.inputs["Az"] == "0x1p-1"


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("real*4", [0.0, -0.0, 1.0, 0.1, -3e38, 1e-45, np.inf]),
        ("real*8", [0.1, -0.0, np.inf, 5e-324]),
        ("integer*2", [-3, 32767]),
        ("logical*4", [True, False]),
        ("character*4", [b"ab  ", b"    "]),
    ],
)
def test_every_kind_reads_back(kind, values):
    """What is spelled of a value of any kind reads back to the same bits."""
    kind = Kind.read(kind)
    array = np.array(values, kind.dtype())

    assert unspell([spell(one) for one in array], kind).tobytes() == array.tobytes()
