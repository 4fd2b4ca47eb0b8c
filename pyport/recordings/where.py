"""Filters of recordings: a small language of comparisons, and nothing that runs code.

    wind_speed_m_s < 5 and (sun_el_deg < 0 or source in ("3C84", "3C273"))

Columns by the contract's names, angles in any unit; numbers, text in quotes
and times such as "2026-03-01T02:00"; `<` `<=` `>` `>=` `==` `!=` `in`, `and`
`or` `not`, parentheses. A comparison with something unknown is not true.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.recordings.naming import column, names
from pyport.recordings.schema import Recordings, SetAside

Truth = NDArray[np.bool_]
Test = Callable[[Recordings], Truth]

#: No filter that a person writes is longer, or nests deeper.
LONGEST, DEEPEST = 2000, 20
#: Numbers that differ by less than this share are equal.
SAME = 1e-12

_TOKEN = re.compile(
    r"""\s*(?:(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)
    |(?P<text>"[^"]*"|'[^']*')
    |(?P<name>[A-Za-z_]\w*)
    |(?P<sign><=|>=|==|!=|<|>|\(|\)|,))""",
    re.VERBOSE,
)
_COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}
_WORDS = frozenset({"and", "or", "not", "in"})


class _Token(NamedTuple):
    kind: str
    text: str
    place: int


def where(recordings: Recordings, expression: str) -> Recordings:
    """Return the recordings for which an expression holds; the others are excluded by it.

    Raises
    ------
    BadInput
        The expression is none, or names something that these recordings lack.
    """
    keep = parse(expression)(recordings)
    aside = tuple(SetAside(int(line), f"not where {expression}") for line in recordings.line[~keep])
    return replace(recordings.take(keep), set_aside=recordings.set_aside + aside)


def parse(expression: str) -> Test:
    """Return what tells for each recording whether an expression holds.

    Raises
    ------
    BadInput
        The expression is none; the message tells where.
    """
    if len(expression) > LONGEST:
        raise BadInput(f"where: {len(expression)} characters, expected at most {LONGEST}")
    tokens = _Tokens(expression, list(_tokens(expression)))
    test = _either(tokens, 0)
    if (rest := tokens.next()) is not None:
        raise tokens.error("expected `and`, `or` or the end", rest)
    return test


def _tokens(expression: str) -> Iterator[_Token]:
    place = 0
    while expression[place:].strip():
        match = _TOKEN.match(expression, place)
        if match is None or match.lastgroup is None:
            rest = expression[place:].strip()
            raise BadInput(f"where: cannot read {rest[:20]!r} at character {place + 1}")
        yield _Token(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup))
        place = match.end()


@dataclass
class _Tokens:
    """The tokens of an expression, and which comes next."""

    expression: str
    tokens: list[_Token]
    at: int = 0

    def next(self) -> _Token | None:
        """Return the next token without taking it."""
        return self.tokens[self.at] if self.at < len(self.tokens) else None

    def take(self, *texts: str) -> bool:
        """Take the next token if it is one of these."""
        token = self.next()
        if token is None or token.kind == "text" or token.text not in texts:
            return False
        self.at += 1
        return True

    def error(self, wanted: str, token: _Token | None) -> BadInput:
        """Return an error that says what stands where, and what was expected."""
        if token is None:
            return BadInput(f"where: the expression ends, {wanted}")
        return BadInput(f"where: {token.text[:20]!r} at character {token.place + 1}, {wanted}")


def _either(tokens: _Tokens, depth: int) -> Test:
    tests = [_both(tokens, depth)]
    while tokens.take("or"):
        tests.append(_both(tokens, depth))
    return lambda recordings: np.any([test(recordings) for test in tests], axis=0)


def _both(tokens: _Tokens, depth: int) -> Test:
    tests = [_one(tokens, depth)]
    while tokens.take("and"):
        tests.append(_one(tokens, depth))
    return lambda recordings: np.all([test(recordings) for test in tests], axis=0)


def _one(tokens: _Tokens, depth: int) -> Test:
    if depth > DEEPEST:
        raise tokens.error(f"expected at most {DEEPEST} levels", tokens.next())
    if tokens.take("not"):
        inner = _one(tokens, depth + 1)
        return lambda recordings: ~inner(recordings)
    if tokens.take("("):
        inside = _either(tokens, depth + 1)
        if not tokens.take(")"):
            raise tokens.error("expected `)`", tokens.next())
        return inside
    return _comparison(tokens)


def _comparison(tokens: _Tokens) -> Test:
    """Return the test of `NAME sign VALUE` or `NAME in (VALUE, ...)`."""
    name = tokens.next()
    if name is None or name.kind != "name" or name.text in _WORDS:
        raise tokens.error("expected the name of a column", name)
    tokens.at += 1
    negated = tokens.take("not")
    if tokens.take("in"):
        values = _values(tokens)
        return lambda recordings: (
            negated
            ^ np.any([_compared(recordings, name.text, "==", value) for value in values], axis=0)
        )
    sign = tokens.next()
    if negated or sign is None or sign.text not in _COMPARE:
        raise tokens.error("expected `<`, `<=`, `>`, `>=`, `==`, `!=` or `in`", sign)
    tokens.at += 1
    value = _value(tokens)
    return lambda recordings: _compared(recordings, name.text, sign.text, value)


def _values(tokens: _Tokens) -> list[float | str]:
    if not tokens.take("("):
        raise tokens.error("expected `(`", tokens.next())
    values = [_value(tokens)]
    while tokens.take(","):
        values.append(_value(tokens))
    if not tokens.take(")"):
        raise tokens.error("expected `,` or `)`", tokens.next())
    return values


def _value(tokens: _Tokens) -> float | str:
    token = tokens.next()
    if token is None or token.kind not in {"number", "text"}:
        raise tokens.error("expected a number or text in quotes", token)
    tokens.at += 1
    return float(token.text) if token.kind == "number" else token.text[1:-1]


def _compared(recordings: Recordings, name: str, sign: str, value: float | str) -> Truth:
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
    if sign in {"==", "!="}:
        return np.asarray((same == (sign == "==")) & np.isfinite(cells))
    beyond = _COMPARE[sign](cells, value)
    return np.asarray(np.where(same, "=" in sign, beyond) & np.isfinite(cells))


def _moment(name: str, text: str) -> float:
    """Return a time as seconds since 1970."""
    if name == "time_utc":
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:
            raise BadInput(f"where: {text!r} is no ISO 8601 time") from None
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    raise BadInput(f"where: {name} holds numbers, and {text!r} is none")
