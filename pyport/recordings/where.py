"""Filters of recordings: a small language of comparisons, and nothing that runs code.

    wind_speed_m_s < 5 and (sun_el_deg < 0 or source in ("3C84", "3C273"))

Columns by the contract's names, angles in any unit; numbers, text in quotes
and times such as "2026-03-01T02:00"; `<` `<=` `>` `>=` `==` `!=` `in`, `and`
`or` `not`, parentheses. A comparison with something unknown is not true.
Python's parser reads it; of what that knows nothing else is let through.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.recordings.naming import column, names
from pyport.recordings.raw import seconds_of
from pyport.recordings.schema import Recordings, SetAside

Truth = NDArray[np.bool_]
Test = Callable[[Recordings], Truth]

#: No filter that a person writes is longer, or nests deeper.
LONGEST, DEEPEST = 2000, 20
#: Numbers that differ by less than this share are equal.
SAME = 1e-12

_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}


def where(recordings: Recordings, expression: str) -> Recordings:
    """Return the recordings for which an expression holds; the others are excluded by it.

    Raises `BadInput`: the expression is none, or names something that these recordings lack.
    """
    keep = parse(expression)(recordings)
    aside = tuple(SetAside(int(line), f"not where {expression}") for line in recordings.line[~keep])
    return replace(recordings.take(keep), set_aside=recordings.set_aside + aside)


def parse(expression: str) -> Test:
    """Return what tells for each recording whether an expression holds.

    Raises `BadInput`: the expression is none; the message tells where.
    """
    if len(expression) > LONGEST:
        raise BadInput(f"where: {len(expression)} characters, expected at most {LONGEST}")
    if not expression.strip():
        raise BadInput("where: nothing, expected a comparison such as `el_deg > 30`")
    try:
        tree = ast.parse(f"({expression}\n)", mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else "it nests too deep"
        raise BadInput(
            f"where: cannot read {expression[:60]!r}: {reason.partition('.')[0]}"
        ) from None
    return _Reader(f"({expression}\n)").test(tree.body, 0)


class _Reader:
    """Makes tests of the parts of an expression; `text` is what they were parsed from."""

    def __init__(self, text: str) -> None:
        self.text = text

    def wrong(self, node: ast.AST, wanted: str) -> BadInput:
        """Return an error that says what stands where, and what was expected."""
        there = ast.get_source_segment(self.text, node) or ""
        place = getattr(node, "col_offset", 1)
        return BadInput(f"where: {there[:20]!r} at character {place}, expected {wanted}")

    def test(self, node: ast.expr, depth: int) -> Test:
        """Return the test of a comparison, or of several between words."""
        if depth > DEEPEST:
            raise self.wrong(node, f"at most {DEEPEST} levels")
        if isinstance(node, ast.BoolOp):
            join = np.all if isinstance(node.op, ast.And) else np.any
            tests = [self.test(one, depth + 1) for one in node.values]
            return lambda recordings: join([test(recordings) for test in tests], axis=0)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            inner = self.test(node.operand, depth + 1)
            return lambda recordings: ~inner(recordings)
        if isinstance(node, ast.Compare):
            return self.comparison(node)
        raise self.wrong(node, "a comparison such as `el_deg > 30`")

    def comparison(self, node: ast.Compare) -> Test:
        """Return the test of `NAME sign VALUE` or `NAME in (VALUE, ...)`."""
        if not isinstance(node.left, ast.Name):
            raise self.wrong(node.left, "the name of a column")
        if len(node.ops) > 1:
            raise self.wrong(node, "one comparison, and `and` before the next")
        name, sign, right = node.left.id, node.ops[0], node.comparators[0]
        if isinstance(sign, ast.In | ast.NotIn):
            listed = right.elts if isinstance(right, ast.Tuple) else [right]
            values = [self.value(one) for one in listed]
            if not values:
                raise self.wrong(right, "a value at least")
            negated = isinstance(sign, ast.NotIn)
            return lambda recordings: (
                negated ^ np.any([_compared(recordings, name, ast.Eq, v) for v in values], axis=0)
            )
        if type(sign) not in _COMPARE:
            raise self.wrong(node, "`<`, `<=`, `>`, `>=`, `==`, `!=` or `in`")
        value = self.value(right)
        return lambda recordings: _compared(recordings, name, type(sign), value)

    def value(self, node: ast.expr) -> float | str:
        """Return a number or a text."""
        inner, sign = node, 1
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
            inner, sign = node.operand, -1 if isinstance(node.op, ast.USub) else 1
        if isinstance(inner, ast.Constant):
            if isinstance(inner.value, int | float) and not isinstance(inner.value, bool):
                with contextlib.suppress(OverflowError):
                    return sign * float(inner.value)
                raise self.wrong(node, "a number below 1.8e308")
            if isinstance(inner.value, str) and inner is node:
                return inner.value
        raise self.wrong(node, "a number or text in quotes")


def _compared(
    recordings: Recordings, name: str, sign: type[ast.cmpop], value: float | str
) -> Truth:
    """Return where a column compares so with a value; unknown is neither."""
    cells = column(recordings, name)
    if cells is None:
        known = ", ".join(names(recordings))
        raise BadInput(f"where: these recordings have no {name!r}, they have {known}")
    if cells.dtype.kind == "U":
        return np.asarray(
            _COMPARE[sign](cells, value if isinstance(value, str) else f"{value:.15g}")
        )
    if isinstance(value, str):
        value = _moment(name, value)
    same = np.isclose(cells, value, rtol=SAME, atol=0)  # 60 deg are no round number of radians
    if sign in (ast.Eq, ast.NotEq):
        return np.asarray((same == (sign is ast.Eq)) & np.isfinite(cells))
    beyond = _COMPARE[sign](cells, value)
    return np.asarray(np.where(same, sign in (ast.LtE, ast.GtE), beyond) & np.isfinite(cells))


def _moment(name: str, text: str) -> float:
    """Return a time as seconds since 1970."""
    if name == "time_utc":
        try:
            return seconds_of(text)
        except ValueError:
            raise BadInput(f"where: {text!r} is no ISO 8601 time") from None
    raise BadInput(f"where: {name} holds numbers, and {text!r} is none")
