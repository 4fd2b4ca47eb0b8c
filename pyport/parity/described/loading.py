"""Read a `parity.toml`; what is wrong in it is one line with file and line number."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.parity.described.description import (
    INTENTS,
    PROMISES,
    Build,
    Description,
    Group,
    Kind,
    Port,
    Routine,
    Variable,
)
from pyport.parity.described.source import NUMBERS, Lines, Table

#: What gfortran needs to take an old text, and to complain where it would cut a line.
LANGUAGE = ("-std=legacy", "-Wline-truncation", "-Werror=line-truncation")
#: Every operation rounded where the text rounds it.
REFERENCE = ("-O0", "-ffp-contract=off")


def load(path: str | Path) -> Description:
    """Read a description.

    Raises `BadInput`: the file is missing, no TOML, or says what it must not: file, line, what was
      expected.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"cannot be read ({error}): expected a parity.toml", path) from None
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        raise BadInput(f"no TOML: {error}", path, int(line[1]) if line else None) from None
    return _description(path, Lines(text), content)


def _description(path: Path, lines: Lines, content: dict[str, Any]) -> Description:
    top = Table(path, lines, "", 0, content)
    fortran = Table(path, lines, "fortran", 0, top.take("fortran", dict))
    builds, matrix = _builds(path, lines, fortran, top.take("build", dict, {}))
    counter: dict[str, int] = {}

    def each(name: str, inside: list[dict[str, Any]]) -> list[Table]:
        first = counter.get(name, 0)
        counter[name] = first + len(inside)
        return [Table(path, lines, name, first + i, one) for i, one in enumerate(inside)]

    commons = {}
    for one in each("common", top.tables("common")):
        members = [_variable(m, {}) for m in each("common.member", one.tables("member"))]
        commons[str(one.take("name", str, "")).upper()] = tuple(members)
        one.done("name member")
    ports = tuple(_port(one) for one in each("port", top.tables("port")))
    if not ports:
        ports = (Port("python", "bits"),)
    names = [one.name for one in ports]
    routines = []
    for one in each("routine", top.tables("routine")):
        arguments = [
            _variable(a, commons) for a in each("routine.argument", one.tables("argument"))
        ]
        routines.append(_routine(one, arguments, names))
    groups = tuple(_group(one) for one in each("group", top.tables("group")))
    if not routines:
        raise top.wrong("no [[routine]]: expected at least one")
    files = fortran.paths("files")
    if not files:
        raise fortran.wrong(
            "`files` is missing or empty: expected the names of Fortran files", "files"
        )
    description = Description(
        path=path,
        name=top.take("name", str, path.parent.resolve().name),
        title=top.take("title", str, "the Fortran routines"),
        files=files,
        include=fortran.paths("include"),
        commons=commons,
        builds=builds,
        matrix=matrix,
        routines=tuple(routines),
        ports=ports,
        groups=groups or (Group("edges", "edges"), Group("random", "random", draws=True)),
        ledger=_path(top, "ledger"),
        answers=path.parent / top.take("answers", str, "answers"),
        survivors=_path(top, "survivors"),
        page=top.take("page", dict, {}),
        mutants=_mutants(top),
    )
    fortran.done("files include patches compiler language flags matrix compilers")
    top.done(
        "name title ledger answers survivors fortran build common port group routine page mutants"
    )
    _consistent(top, description)
    return description


def _path(table: Table, key: str) -> Path | None:
    name = table.take(key, str, None)
    return None if name is None else table.path.parent / name


def _builds(
    path: Path, lines: Lines, fortran: Table, others: dict[str, Any]
) -> tuple[dict[str, Build], tuple[Build, ...]]:
    compiler = fortran.take("compiler", str, "gfortran")
    language = fortran.words("language", LANGUAGE)
    flags = fortran.words("flags", REFERENCE)
    patches = fortran.paths("patches")
    builds = {"reference": Build("reference", language + flags, patches, compiler)}
    for name, content in others.items():
        one = Table(path, lines, f"build.{name}", 0, content)
        own = language + one.words("flags", flags)
        of = one.paths("patches") if "patches" in one.content else patches
        builds[name] = Build(name, own, of, one.take("compiler", str, compiler))
        one.done("flags patches compiler")
    matrix = [
        Build(f"{compiler} {' '.join(row)}", (*language, *row), patches, compiler)
        for row in fortran.take("matrix", list, [])
    ]
    matrix += [
        replace(one, name=f"{compiler} {' '.join(one.flags[len(language) :])}")
        for name, one in builds.items()
        if name != "reference"
    ]
    # other compilers, where they are installed: a name may carry a version after it
    for row in fortran.take("compilers", list, []):
        matrix += [Build(" ".join(row), tuple(row[1:]), patches, row[0])]
    return builds, tuple(matrix)


def _port(one: Table) -> Port:
    promise = one.take("promise", str, "bits")
    if promise not in PROMISES:
        raise one.wrong(
            f"`promise` = {promise!r}: expected one of {', '.join(PROMISES)}", "promise"
        )
    port = Port(
        name=one.take("name", str),
        promise=promise,
        vectorised=one.take("vectorised", bool, default=False),
        ulp=one.take("ulp", int, 0),
        within=float(one.take("within", NUMBERS, 0.0)),
        absolute=float(one.take("absolute", NUMBERS, 0.0)),
        moved=tuple(name.lower() for name in one.words("moved")),
        builds=one.words("builds"),
        title=one.take("title", str, ""),
    )
    one.done("name promise vectorised ulp within absolute moved builds title")
    return port


def _group(one: Table) -> Group:
    make = one.take("make", str, one.content.get("name", ""))
    if make not in {"edges", "random"}:
        one.callable("make", make)
    group = Group(
        name=one.take("name", str),
        make=make,
        draws=one.take("draws", bool, default=make == "random"),
        sample=one.take("sample", str, ""),
        keep=one.take("keep", int, 200),
        seed=one.take("seed", int, 0),
        digest=one.take("digest", int, 0),
    )
    one.done("name make draws sample keep seed digest")
    return group


def _variable(one: Table, commons: dict[str, tuple[Variable, ...]]) -> Variable:
    name = one.take("name", str)
    block = one.take("common", str, None)
    kind: Kind | None = None
    shape = one.take("shape", list, [])
    if block is not None:
        members = {m.key: m for m in commons.get(block.upper(), ())}
        if name.lower() not in members:
            raise one.wrong(f"no member {name} in a [[common]] named {block!r}", "common")
        kind, shape = members[name.lower()].kind, list(members[name.lower()].shape)
    else:
        text = one.take("kind", str)
        if text != "external":
            try:
                kind = Kind.read(text)
            except ValueError as error:
                raise one.wrong(str(error), "kind") from None
    if not all(isinstance(d, int) and d > 0 for d in shape):
        raise one.wrong(f"`shape` = {shape!r}: expected numbers, such as [3, 3]", "shape")
    if shape and kind is not None and kind.base == "character":
        raise one.wrong(f"{name}: arrays of CHARACTER are not supported", "shape")
    intent = one.take("intent", str, "in")
    if intent not in INTENTS:
        raise one.wrong(f"`intent` = {intent!r}: expected one of {', '.join(INTENTS)}", "intent")
    low, high = one.pair("range") or (-1.0, 1.0)
    physical = one.take("physical", dict, None)
    result = Variable(
        name=name,
        kind=kind,
        intent=intent,
        shape=tuple(shape),
        label=one.take("label", str, name),
        unit=one.take("unit", str, ""),
        low=low,
        high=high,
        logarithmic=one.take("logarithmic", bool, default=False),
        thresholds=tuple(one.take("thresholds", list, [])),
        values=tuple(one.take("values", list, [])),
        fixed=one.take("value", (int, float, str, bool, list), None),
        python=one.take("python", str, ""),
        common=None if block is None else block.upper(),
        limits=one.pair("limits"),
        ulp=one.take("ulp", int, None),
        within=one.take("within", NUMBERS, None),
        turn=one.take("turn", NUMBERS, None),
        physical=None
        if physical is None
        else (
            str(physical.get("unit", "")),
            float(physical.get("factor", 1.0)),
            str(physical.get("cosine", "")).lower(),
        ),
    )
    if kind is None and not isinstance(result.fixed, str):
        raise one.wrong(f"{name} is EXTERNAL: expected `value`, the Fortran function it gets")
    if result.logarithmic and not 0 < low < high:
        raise one.wrong(f"{name} is logarithmic: expected a range of sizes above 0", "range")
    one.done(
        "name kind intent shape label unit range logarithmic thresholds values value python "
        "common limits ulp within turn physical"
    )
    return result


def _routine(one: Table, variables: list[Variable], ports: list[str]) -> Routine:
    name = one.take("name", str)
    given = one.take("port", (str, dict), {})
    given = {ports[0]: given} if isinstance(given, str) else given
    for port, function in given.items():
        if port not in ports:
            raise one.wrong(
                f"no [[port]] named {port!r}: expected one of {', '.join(ports)}", "port"
            )
        one.callable("port", function)
    known = {v.key: v for v in variables}
    # a member of a COMMON block that the port takes or returns stands after the arguments
    call = one.words("call", tuple(v.key for v in variables if v.intent in {"in", "inout"}))
    outputs = [v.key for v in variables if v.intent == "result"]
    outputs += [v.key for v in variables if v.intent in {"out", "inout"}]
    returns = one.words("returns", tuple(outputs))
    for key, names in (("call", call), ("returns", returns)):
        for missing in [n for n in names if n.lower() not in known]:
            raise one.wrong(f"`{key}`: {name} has no argument {missing!r}", key)
    if {n.lower() for n in returns} != set(outputs):
        raise one.wrong(
            f"`returns`: expected each output of {name} once: {', '.join(outputs)}", "returns"
        )
    if not outputs:
        raise one.wrong(f"{name} has no output: give an argument intent out, inout or result")
    routine = Routine(
        name=name,
        variables=tuple(variables),
        ports=given,
        call=tuple(n.lower() for n in call),
        returns=tuple(n.lower() for n in returns),
        sequence=one.take("sequence", bool, default=False),
        reset=one.take("reset", str, ""),
        note=" ".join(one.take("note", str, "").split()),
    )
    one.done("name port call returns sequence reset note argument")
    if len(known) != len(variables):
        raise one.wrong(f"{name} has two arguments of one name")
    return routine


def _mutants(top: Table) -> tuple[tuple[str, str, str], ...]:
    rows = top.take("mutants", list, [])
    if not all(isinstance(r, list) and len(r) == 3 for r in rows):
        raise top.wrong("`mutants`: expected rows of three texts, [FILE, WAS, BECAME]", "mutants")
    return tuple((a, b, c) for a, b, c in rows)


def _consistent(top: Table, description: Description) -> None:
    """Refuse what contradicts itself between tables."""
    names = [one.name.lower() for one in description.routines]
    for name in {n for n in names if names.count(n) > 1}:
        raise top.wrong(f"two [[routine]] tables are named {name}")
    for port in description.ports:
        for build in port.builds:
            if build not in description.builds:
                raise top.wrong(f"port {port.name}: no [build.{build}]")
        if port.promise == "spread" and not (port.moved or port.builds):
            raise top.wrong(
                f"port {port.name} promises its ulp beyond the spread: expected `moved` or `builds`"
            )
