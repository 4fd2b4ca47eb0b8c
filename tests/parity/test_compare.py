"""The comparator counts, ranks and names what differs."""

import numpy as np
import pytest

from pyport.parity.compare import compare, hexadecimal
from pyport.parity.points import MODEL3_DEG, points
from pyport.parity.ulp import UNLIKE

AT = points([0.25, 0.5, 0.75], [0.5, 0.5, 0.5], MODEL3_DEG)


def answers(*column):
    """Return answers whose first output is `column` and the others zero."""
    result = np.zeros((len(column), 5), dtype=np.float32)
    result[:, 0] = column
    return result


def test_equal_answers_differ_nowhere():
    """Equal answers: nothing differs and there is no worst input."""
    first = compare(answers(1, 2, 3), answers(1, 2, 3), AT)[0]

    assert (first.points, first.differing, first.most, first.worst) == (3, 0, 0, None)


def test_worst_input_is_named():
    """The line about a difference names routine, output, worst input and distance."""
    first, *others = compare(answers(1, 2, 3), answers(1, 2 + 2**-21, 3 + 2**-19), AT)

    assert str(first).startswith("Model azimuth: 2 of 3 differ, worst by 8 ulp at az=0x1.8p-1 ")
    assert [c.differing for c in others] == [0, 0, 0, 0]


def test_quantiles_and_sum():
    """Comparisons add up; quantiles are those of the joined points."""
    one = compare(answers(1, 2, 3), answers(1, 2, 3 + 2**-20), AT)[0]
    two = compare(answers(1, 1, 1), answers(1, np.nan, 1), AT)[0]
    both = one + two

    assert (both.points, both.differing, both.most) == (6, 2, UNLIKE)
    assert both.quantile(0.5) == 0
    assert both.quantile(5 / 6) == 4
    assert both.worst == two.worst == (two + one).worst


@pytest.mark.parametrize("value", [0.0, -0.0, 1.0, 0.1, -3e38, 1e-45, np.inf])
def test_hexadecimal_reads_back(value):
    """The hexadecimal literal of a REAL*4 reads back to the same bits."""
    value = np.float32(value)
    again = np.float32(float.fromhex(hexadecimal(value)))

    assert again.view(np.uint32) == value.view(np.uint32)
