"""Make mutants of a Python source: one small wrong change each, as a careless hand makes it."""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

Change = Callable[[Any], ast.AST]

#: Function -> the one that a slip of the pen would call.
SLIPS = {"dsin": "dcos", "dcos": "dsin", "sin": "cos", "cos": "sin", "tan": "sin", "dasin": "dsin"}

#: Modules whose functions take and return REAL*8.
DOUBLE = {"math", "np", "numpy"}
#: Their functions that a careless port may call in REAL*4.
ROUNDED = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp", "log", "fmod"}

#: Operator -> its sign, the operator that it is taken for, and that one's sign.
OPERATORS = {
    ast.Add: ("+", ast.Sub, "-"),
    ast.Sub: ("-", ast.Add, "+"),
    ast.Mult: ("*", ast.Div, "/"),
    ast.Div: ("/", ast.Mult, "*"),
}

#: Comparison -> those that it is taken for: its bound on the other side, and itself turned.
TURNS = {
    ast.Gt: ((ast.GtE, ">="), (ast.Lt, "<")),
    ast.Lt: ((ast.LtE, "<="), (ast.Gt, ">")),
    ast.LtE: ((ast.Lt, "<"), (ast.GtE, ">=")),
    ast.GtE: ((ast.Gt, ">"), (ast.LtE, "<=")),
    ast.Eq: ((ast.NotEq, "!="),),
    ast.NotEq: ((ast.Eq, "=="),),
}


@dataclass(frozen=True)
class Mutant:
    """A mutated source, named by what was changed, so that a moved line does not rename it."""

    name: str
    source: str


def mutants(module: str, source: str) -> Iterator[Mutant]:
    """Yield every mutant of a module's source; docstrings and imports are left alone.

    A mutant may call ``real4``, which rounds to REAL*4, and the functions of
    :mod:`pyport.parity.evidence.mutants` that are injected beside it.
    """
    tree = ast.parse(source)
    numbered = _numbered(tree)
    seen: dict[str, int] = {}
    for index, node in enumerate(ast.walk(tree)):
        for label, change in _changes(node, numbered):
            mutated = copy.deepcopy(tree)
            target = list(ast.walk(mutated))[index]
            result = change(target)
            if result is not target:
                _replace(mutated, target, result)
            number = seen[label] = seen.get(label, 0) + 1
            name = f"{module}: {label}" + (f" ({number})" if number > 1 else "")
            yield Mutant(name, ast.unparse(ast.fix_missing_locations(mutated)))


def _numbered(tree: ast.AST) -> dict[str, str]:
    """Return for each of a row of names, p1 to p12, the next one, which it may be taken for."""
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    rows: dict[str, list[tuple[int, str]]] = {}
    for name in names:
        if found := re.fullmatch(r"([A-Za-z_]+)(\d+)", name):
            rows.setdefault(found[1], []).append((int(found[2]), name))
    result: dict[str, str] = {}
    for row in rows.values():
        ordered = [name for _, name in sorted(row)]
        if len(ordered) > 1:
            result |= dict(zip(ordered, [*ordered[1:], ordered[0]], strict=True))
    return result


def _changes(  # noqa: C901 - one case a kind of node
    node: ast.AST, numbered: dict[str, str]
) -> Iterator[tuple[str, Change]]:
    """Yield the changes that a node can suffer, each with its label."""
    match node:
        case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
            yield from _arithmetic_changes(node)
        case ast.Compare():
            for other, became in TURNS.get(type(node.ops[0]), ()):
                change = partial(_set, ops=[other()])
                yield f"{ast.unparse(node)} -> {became}", change
        case ast.BoolOp():
            yield f"{ast.unparse(node)} -> or", partial(_set, op=ast.Or())
            for i, value in enumerate(node.values):
                yield f"only {ast.unparse(value)}", partial(_operand, i)
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            yield f"{ast.unparse(node)} without its sign", lambda n: n.operand
        case ast.Constant(value=int() | float() as value):
            if not isinstance(value, bool):
                digit = _last_digit(value)
                yield f"{value!r} -> {digit!r}", partial(_constant, digit)
        case ast.Name(id=name, ctx=ast.Load()) if name in numbered:
            yield f"{name} -> {numbered[name]}", partial(_set, id=numbered[name])
        case ast.Call(func=ast.Name(id=name)):
            yield from _call_changes(name, ast.unparse(node))
        case ast.Call(func=ast.Attribute(value=ast.Name(id=module), attr=name)) if module in DOUBLE:
            yield from _double_changes(name, ast.unparse(node))


def _arithmetic_changes(node: ast.BinOp) -> Iterator[tuple[str, Change]]:
    """Yield the turned operator and, of a sum, the dropped term."""
    right = ast.unparse(node.right)
    sign, other, became = OPERATORS[type(node.op)]
    yield f"{sign} {right} -> {became} {right}", partial(_set, op=other())
    if sign in "+-":
        yield f"{sign} {right} dropped", lambda n: n.left


def _call_changes(name: str, text: str) -> Iterator[tuple[str, Change]]:
    """Yield another function, arguments swapped, and the wrong kind of REAL."""
    if name in SLIPS:
        yield f"{text} -> {SLIPS[name]}", lambda n: _set(n, func=ast.Name(SLIPS[name]))
    if name in {"datan2", "dsign", "sign"}:
        yield f"{text} with arguments swapped", lambda n: _set(n, args=n.args[::-1])
    if name == "real4":
        yield f"{text} left in REAL*8", _left_in_double
    if name in {"sin", "cos", "tan"}:
        yield (
            f"{text} by REAL*8, rounded",
            lambda n: _call("real4", _call(f"d{name}", _call("float", n.args[0]))),
        )
    if name in {"dsin", "dcos", "dasin", "datan2", "dsqrt", "dmod"}:
        yield f"{text} in REAL*4", lambda n: _call("float", _call("real4", copy.deepcopy(n)))
    if name in {"min", "max"}:
        yield f"{text} not taken", lambda n: n.args[1]


def _double_changes(name: str, text: str) -> Iterator[tuple[str, Change]]:
    """Yield what may befall a call of Python's own mathematics: another function, REAL*4."""
    if name in {"sin", "cos"}:
        other = SLIPS[name]
        yield f"{text} -> {other}", lambda n: _set(n, func=_set(n.func, attr=other))
    if name in {"atan2", "fmod", "copysign"}:
        yield f"{text} with arguments swapped", lambda n: _set(n, args=n.args[::-1])
    if name in ROUNDED:
        yield f"{text} in REAL*4", lambda n: _call("float", _call("real4", copy.deepcopy(n)))


def _left_in_double(node: Any) -> ast.AST:  # noqa: ANN401 - a call
    """Return what is rounded as it was; NumPy would take a bare constant for a REAL*4."""
    value: ast.expr = node.args[0]
    return _call("real8", value) if isinstance(value, ast.Constant) else value


def _operand(number: int, node: Any) -> ast.AST:  # noqa: ANN401 - a BoolOp
    operand: ast.AST = node.values[number]
    return operand


def _constant(value: float, _: ast.AST) -> ast.AST:
    return ast.Constant(value)


def _call(function: str, argument: Any) -> ast.Call:  # noqa: ANN401 - an expression
    return ast.Call(ast.Name(function), [argument], [])


def _last_digit(value: float) -> float:
    """Return a number with its last digit one higher, or one lower where that is a 9."""
    digits, exponent, power = re.sub(r"\.0$", "", repr(value)).partition("e")
    last = int(digits[-1])
    changed = digits[:-1] + str(last - 1 if last == 9 else last + 1)
    return type(value)(changed + exponent + power)


def _changes_value(code: str, exponent: int) -> bool:
    """Tell whether a REAL*8 constant, its exponent's letter there, is another as a REAL*4."""
    before = re.search(r"\d*\.?\d*$", code[:exponent])
    after = re.match(r"[+-]?\d+", code[exponent + 1 :])
    if before is None or after is None:
        return True
    value = float(f"{before[0]}e{after[0]}")
    with np.errstate(over="ignore"):
        return float(np.float32(value)) != value


#: In Fortran's text: what stands there, and what a slip makes of it.
_FORTRAN_SLIPS = [
    (r"(?<=[\w)])\s*\+\s*(?=[\w(])", "-"),
    (r"(?<=[\w)])\s*-\s*(?=[\w(])", "+"),
    (r"(?i)\.lt\.", ".le."),
    (r"(?i)\.gt\.", ".ge."),
    (r"(?i)\.le\.", ".lt."),
    (r"(?i)\.ge\.", ".gt."),
    (r"(?i)\.and\.", ".or."),
    (r"(?i)\bd?sin\(", "dcos("),
    (r"(?i)(?<=\d)d(?=[+-]?\d)", "e"),
]


def fortran_mutants(name: str, text: str) -> Iterator[tuple[str, str]]:
    """Yield mutants of a Fortran file: what was changed, and the whole text.

    Comments, declarations and FORMATs are left alone. A mutant need not compile.
    """
    lines = text.splitlines()
    free = name.lower().endswith((".f90", ".f95", ".f03"))
    for number, line in enumerate(lines):
        code = line.split("!")[0]
        comment = not code.strip() or (not free and line[:1] in "cC*")
        if comment or re.match(
            r"(?i)[\s\d]*(real|integer|double|logical|character|common|implicit|dimension|format"
            r"|subroutine|function|external|save|end|include|write|print|read|entry)",
            code,
        ):
            continue
        start = 0 if free else 6
        for pattern, became in _FORTRAN_SLIPS:
            for found in re.finditer(pattern, code):
                # an exponent's sign is part of its constant
                exponent = found.start() and re.search(r"(?i)\d\.?[de]$", code[: found.start()])
                if found.start() < start or (exponent and became in "+-"):
                    continue
                changed = code[: found.start()] + became + code[found.end() :]
                if became == "e" and not _changes_value(code, found.start()):
                    continue
                label = f"{name}:{number + 1}: {code.strip()} -> {changed.strip()}"
                yield label, "\n".join([*lines[:number], changed, *lines[number + 1 :]]) + "\n"


def _set(node: ast.AST, **fields: object) -> ast.AST:
    for name, value in fields.items():
        setattr(node, name, value)
    return node


def _replace(tree: ast.AST, old: ast.AST, new: ast.AST) -> None:
    for parent in ast.walk(tree):
        for name, value in ast.iter_fields(parent):
            if value is old:
                setattr(parent, name, new)
            elif isinstance(value, list) and any(item is old for item in value):
                value[[item is old for item in value].index(True)] = new
