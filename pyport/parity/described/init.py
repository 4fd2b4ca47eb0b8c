"""Write a first `parity.toml` from Fortran files; what the text does not say is marked."""

from __future__ import annotations

import contextlib
import io
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.parity.described.source import UNKNOWN, included, pieces, uses

HEAD = """\
# A first description of {files} for `pyport parity`; docs/parity-kit.md explains the keys.
# Look at every line with a question mark: the text does not say it. A key whose value is "?" must
# be filled in before anything runs; a comment "# ?" is a guess that you should check.

name = "{name}"
title = "the Fortran program"

[fortran]
files = [{quoted}]
{include}
# What the port is called and promises: "bits", "ulp" with `ulp = N`, or "within" with `within = X`.
[[port]]
name = "python"
promise = "bits"
"""

_REFUSED = {
    "complex": "COMPLEX is not supported",
    "byte": "BYTE is not supported",
    "type": "derived types are not supported",
}
_NOTED = [
    (r"\bREAD\s*[(*]", "reads from a file or terminal"),
    (r"\b(WRITE\s*\(|PRINT\b)", "writes to a file or terminal"),
    (r"\bSTOP\b", "may STOP the program"),
    (r"\bOPEN\s*\(", "opens a file"),
]


@dataclass
class _Unit:
    """A subprogram as crackfortran and the text tell of it."""

    name: str
    block: dict[str, Any]
    arguments: list[str]
    statements: list[str]
    is_entry: bool = False
    called: set[str] = field(default_factory=set)


def described(files: list[Path], out: Path, only: tuple[str, ...] = ()) -> str:
    """Return a first description of the subprograms in some files, to be written to `out`.

    `files`: Fortran files, all that the routines need.
    `out`: where the description will stand: names of files are relative to its folder.
    `only`: names of the routines to describe; all of them unless given.
    Raises `BadInput`: a file cannot be read, or holds no subprogram.
    """
    for path in files:
        if not path.is_file():
            raise BadInput("is not there: expected a Fortran file", path)
    units = [unit for path in files for unit in _units(path)]
    wanted = {one.upper() for one in only}
    missing = wanted - {one.name for one in units}
    if missing:
        known = ", ".join(sorted(one.name for one in units))
        raise BadInput(f"no routine {min(missing)}: the files hold {known}")
    units = [one for one in units if not wanted or one.name in wanted]
    if not units:
        raise BadInput("no subroutine or function: expected Fortran routines", files[0])
    names = [os.path.relpath(path, out.parent) for path in files]
    include = sorted({one for path in files for one in included(path, out.parent)})
    parts = [
        HEAD.format(
            files=", ".join(path.name for path in files),
            name=out.parent.resolve().name,
            quoted=", ".join(f'"{name}"' for name in names),
            include=f"include = [{', '.join(f'{name!r}' for name in include)}]\n".replace("'", '"')
            if include
            else "",
        )
    ]
    parts += _commons(units)
    parts += [_routine(one) for one in units]
    return "\n".join(parts)


def _units(path: Path) -> list[_Unit]:
    blocks = _cracked(path)
    texts = pieces(path)
    found = []
    for block in blocks:
        if block.get("block") not in {"subroutine", "function"}:
            continue
        name = block["name"].upper()
        statements = texts.get(name, [])
        arguments = [one.upper() for one in block.get("args", [])]
        found.append(_Unit(name, block, arguments, statements))
        for entry, given in block.get("entry", {}).items():
            own = [one.upper() for one in given]
            head = re.compile(rf"ENTRY\s+{entry}\b", re.IGNORECASE)
            start = next((i for i, s in enumerate(statements) if head.match(s)), 0)
            found.append(_Unit(entry.upper(), block, own, statements[start:], is_entry=True))
    return found


def _cracked(path: Path) -> list[dict[str, Any]]:
    """Return what NumPy's crackfortran finds in a file."""
    from numpy.f2py import crackfortran

    crackfortran.verbose, crackfortran.quiet = 0, 1
    crackfortran.include_paths = [str(path.parent)]
    here = Path.cwd()
    renamed = dict(crackfortran.badnames)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            os.chdir(path.parent.resolve())
            crackfortran.badnames.clear()  # LONG stays LONG: no C is made of it
            blocks: list[dict[str, Any]] = crackfortran.crackfortran([path.name])
    except (Exception, SystemExit) as error:  # noqa: BLE001 - it raises whatever befalls it
        raise BadInput(f"crackfortran cannot read it ({error}): expected Fortran", path) from None
    finally:
        os.chdir(here)
        crackfortran.badnames.update(renamed)
    inside = [one for block in blocks for one in [block, *block.get("body", [])]]
    modules = [one for one in blocks if one.get("block") == "module"]
    # procedures of a module are not supported
    refused = {id(one) for module in modules for one in module.get("body", [])}
    return [one for one in inside if one not in modules and id(one) not in refused]


def _intent(statements: list[str], name: str) -> tuple[str, str]:
    """Return an argument's intent, and a mark where it is a guess."""
    read, written, passed = uses(statements, name)
    if passed and not written:
        return UNKNOWN, "# ? it is passed to another routine: in, out or inout"
    if written:
        return ("inout", "# ? it is read before it is set") if read else ("out", "")
    return "in", "" if read else "# ? it is not used"


def _kind(variable: dict[str, Any]) -> tuple[str, str]:  # noqa: PLR0911 - one a type
    """Return a kind, and why it is refused or marked."""
    base = variable.get("typespec", "")
    if base == "double precision":
        return "real*8", ""
    if base in _REFUSED:
        return "", _REFUSED[base]
    selector = variable.get("kindselector", {})
    size = selector.get("*") or selector.get("kind")
    if base == "character":
        length = variable.get("charselector", {})
        text = str(length.get("*") or length.get("len") or "1").strip("()")
        if not text.isdigit():
            return UNKNOWN, "# ? character*N: its length is the caller's"
        return f"character*{text}", ""
    size = {"4": "4", "8": "8", "1": "1", "2": "2", None: "4"}.get(size)
    if base in {"real", "integer", "logical"} and size is not None:
        if base == "real" and size not in {"4", "8"}:
            return "", f"REAL*{size} is not supported"
        return f"{base}*{size}", ""
    return UNKNOWN, "# ? the text does not declare it"


def _shape(variable: dict[str, Any]) -> str:
    dimensions = variable.get("dimension", [])
    if not dimensions:
        return ""
    if all(str(one).isdigit() for one in dimensions):
        return f"shape = [{', '.join(dimensions)}]"
    return f'shape = "{UNKNOWN}"  # ? the text says ({", ".join(map(str, dimensions))}): numbers'


def _commons(units: list[_Unit]) -> list[str]:
    """Return a table for each COMMON block, as the first routine that has it declares it."""
    done: dict[str, str] = {}
    for unit in units:
        for block, members in unit.block.get("common", {}).items():
            name = "" if block == "_BLNK_" else block.upper()
            if name in done:
                continue
            lines = ["[[common]]", f'name = "{name}"', ""]
            for member in members:
                variable = unit.block["vars"][member]
                kind, mark = _kind(variable)
                lines += ["[[common.member]]", f'name = "{member.upper()}"']
                lines.append(f'kind = "{kind or UNKNOWN}"  {mark}'.rstrip())
                lines += [_shape(variable)] if variable.get("dimension") else []
                lines.append("")
            done[name] = "\n".join(lines)
    return list(done.values())


def _routine(unit: _Unit) -> str:
    """Return the tables of a routine, or why it is refused, in comments."""
    tables, reasons = _arguments(unit)
    kind = "entry" if unit.is_entry else unit.block["block"]
    if reasons:
        return "".join(f"# {kind} {unit.name} is left out: {one}.\n" for one in reasons)
    text = "\n".join(unit.statements)
    notes = [f"# ? it {what}" for pattern, what in _NOTED if re.search(pattern, text)]
    saved = _remembers(unit)
    lines = [f"# {kind} {unit.name}({', '.join(unit.arguments)})", *notes, "[[routine]]"]
    lines += [f'name = "{unit.name}"', f'port = "port:{unit.name.lower()}"  # ? module:function']
    if saved:
        lines.append(f"sequence = true  # ? it remembers ({saved}): points are asked in order")
        lines.append(f'reset = "port:reset_{unit.name.lower()}"  # ? makes the port forget')
    return "\n".join([*lines, "", *tables])


def _remembers(unit: _Unit) -> str:
    """Return what tells that a routine remembers from call to call, "" where nothing does."""
    initial = [s for s in unit.statements if s.startswith("DATA")]
    names = {n for s in initial for n in re.findall(r"(?:DATA|,)\s*(\w+)\s*(?:\(|/)", s)}
    changed = [n for n in sorted(names) if uses(unit.statements, n)[1]]
    if changed:
        return f"DATA {', '.join(changed)}"
    return "SAVE" if any(re.match(r"SAVE\b", s) for s in unit.statements) else ""


def _arguments(unit: _Unit) -> tuple[list[str], list[str]]:
    """Return a table for each argument, member of COMMON and result; reasons to refuse them."""
    variables = unit.block["vars"]
    externals = {one.upper() for one in unit.block.get("externals", [])}
    tables: list[str] = []
    reasons: list[str] = []
    for name in unit.arguments:
        variable = variables.get(name.lower(), {})
        if name.startswith("E__"):
            reasons.append("an argument * (alternate return) is not supported")
            continue
        if name in externals or "external" in variable.get("attrspec", []):
            tables.append(
                f'[[routine.argument]]\nname = "{name}"\nkind = "external"\n'
                f'value = "{UNKNOWN}"  # ? the Fortran function that it gets\n'
                f'python = "{UNKNOWN}"  # ? module:function\n'
            )
            continue
        tables.append(_argument(unit, name, variable, reasons))
    if unit.block["block"] == "function":
        name = unit.block.get("result", unit.block["name"])
        name = unit.name.lower() if unit.is_entry else name
        variable = variables.get(name, {})
        tables.append(_argument(unit, unit.name, variable, reasons, intent="result"))
    for block, members in unit.block.get("common", {}).items():
        for member in members:
            read, written, passed = uses(unit.statements, member.upper())
            if read or written or passed:
                intent, mark = _intent(unit.statements, member.upper())
                shown = "" if block == "_BLNK_" else block.upper()
                tables.append(
                    f'[[routine.argument]]\nname = "{member.upper()}"\ncommon = "{shown}"\n'
                    + f'intent = "{intent}"  {mark}'.rstrip()
                    + ("\nrange = [-1.0, 1.0]  # ? where it is used\n" if read else "\n")
                )
    if not any(re.search(r'intent = "(out|inout|result|\?)"', one) for one in tables):
        reasons.append("it sets no argument, result or member of COMMON that can be compared")
    return tables, reasons


def _argument(
    unit: _Unit, name: str, variable: dict[str, Any], reasons: list[str], intent: str = ""
) -> str:
    kind, mark = _kind(variable)
    if not kind:
        reasons.append(f"its argument {name}: {mark}")
        return ""
    if kind.startswith("character") and variable.get("dimension"):
        reasons.append(f"its argument {name}: arrays of CHARACTER are not supported")
    said = ""
    if not intent:
        intent, said = _intent(unit.statements, name)
    lines = ["[[routine.argument]]", f'name = "{name}"', f'kind = "{kind}"  {mark}'.rstrip()]
    lines.append(f'intent = "{intent}"  {said}'.rstrip())
    lines += [_shape(variable)] if variable.get("dimension") else []
    if intent not in {"out", "result"}:
        if kind.startswith("integer"):
            lines.append("range = [-10, 10]  # ? where it is used; `value = N` for a fixed one")
        elif kind.startswith("real"):
            lines.append('range = [-1.0, 1.0]  # ? where it is used; and `unit = "rad"`')
            lines += _thresholds(unit, name)
        elif kind.startswith("character"):
            lines.append('values = [""]  # ? the texts that occur')
    return "\n".join(lines) + "\n"


def _thresholds(unit: _Unit, name: str) -> list[str]:
    """Return the numbers with which the text compares an argument."""
    number = r"(-?\d+\.?\d*(?:[ED][+-]?\d+)?)(?![\w.]*[A-Z])"
    pattern = rf"(?<!\w){name}\s*(?:\.(?:LT|LE|GT|GE|EQ|NE)\.|[<>=/]=?)\s*{number}"
    found = [
        float(one.upper().replace("D", "E"))
        for statement in unit.statements
        if re.search(r"\.(LT|LE|GT|GE|EQ|NE)\.|[<>]|==|/=", statement)
        for one in re.findall(pattern, statement)
    ]
    return [f"thresholds = {sorted(set(found))}"] if found else []
