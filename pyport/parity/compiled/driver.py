"""The Fortran that calls each routine once for each of n points; it computes nothing.

What it takes and gives are flat arrays, whatever the routine's own arguments are: LOGICAL comes as
INTEGER, CHARACTER as bytes, members of COMMON blocks like arguments. A build that promotes REAL*4
promotes these arrays too. f2py reads the same arrays from a signature file, where all are `intent
(inout)`: an array of another type or layout is an error there, never a converted copy.
"""

from __future__ import annotations

from pyport.parity.described.description import Build, Description, Routine, Variable

#: The extension module that f2py makes of the loops.
MODULE = "parity_routines"
#: The routine that writes gcov's counters: an extension module is never unloaded.
WRITE_COUNTERS = "parity_write_counters"


def entry(number: int) -> str:
    """Return the name under which the loop over the routine of that number is called."""
    return f"parity_loop_{number}"


def passed(routine: Routine) -> list[Variable]:
    """Return the variables for which the loop takes an array, in its order."""
    return [one for one in routine.variables if one.kind is not None]


def source(description: Description, build: Build) -> str:
    """Return the loops over all routines of a description, and what else a build calls."""
    loops = [
        _loop(description, number, routine) for number, routine in enumerate(description.routines)
    ]
    return "\n".join([*loops, *([counters()] if build.counted else [])])


def signature(description: Description, build: Build) -> str:
    """Return the signature file from which f2py wraps the loops of a build."""
    lines = [f"python module {MODULE}", "interface"]
    for number, routine in enumerate(description.routines):
        names = [f"x{k}" for k in range(len(passed(routine)))]
        lines += [
            f"subroutine {entry(number)}({', '.join(['n', *names])})",
            "  integer*8, intent(in), required :: n",
            *(
                f"  {_stored(one, build)}, intent(inout), dimension({_extent(one)}) :: {name}"
                for one, name in zip(passed(routine), names, strict=True)
            ),
            f"end subroutine {entry(number)}",
        ]
    if build.counted:
        lines += [f"subroutine {WRITE_COUNTERS}()", f"end subroutine {WRITE_COUNTERS}"]
    return "\n".join([*lines, "end interface", f"end python module {MODULE}", ""])


def _stored(one: Variable, build: Build) -> str:
    """Return the kind of the elements of a variable's array, as they are in a build."""
    kind = one.type
    if kind.base == "character":
        return "integer*1"
    if kind.base == "logical":
        return "integer*4"
    return f"{kind.base}*{kind.dtype(promoted=build.promoted).itemsize}"


def _extent(one: Variable) -> str:
    first = [one.type.size] if one.type.base == "character" else one.shape
    return ", ".join([*map(str, first), "n"])


def counters() -> str:
    """Return the subroutine that writes gcov's counters."""
    return f"""
subroutine {WRITE_COUNTERS}()
  implicit none
  interface
    subroutine dump() bind(C, name="__gcov_dump")
    end subroutine dump
  end interface
  call dump()
end subroutine {WRITE_COUNTERS}
"""


def _declared(one: Variable) -> str:
    kind = one.type
    if kind.base == "character":
        return f"character(len={kind.size})"
    return f"{kind.base}({kind.size})"


def _dimensions(shape: tuple[int, ...]) -> str:
    return f"({', '.join(map(str, shape))})" if shape else ""


def _array(one: Variable, name: str) -> str:
    kinds = {"character": "integer(1)", "logical": "integer(4)"}
    kind = kinds.get(one.type.base, f"{one.type.base}({one.type.size})")
    return f"{kind} :: {name}({_extent(one)})"


def _at(one: Variable, name: str, first: str) -> str:
    """Return the element, or section, of such an array at point i."""
    return f"{name}({', '.join([first] * len(one.shape) + ['i'])})"


def _loop(description: Description, number: int, routine: Routine) -> str:
    variables = passed(routine)
    arrays = {one.key: f"x{k}" for k, one in enumerate(variables)}
    declared = [_array(one, arrays[one.key]) for one in variables]
    blocks, members = _blocks(description, variables)
    declared += blocks
    locals_: dict[str, str] = {}
    before, after = [], []
    for k, one in enumerate(variables):
        if one.common is None and one.type.base not in {"logical", "character"}:
            continue
        locals_[one.key] = members.get((one.common, one.key), f"l{k}")
        if one.common is None:
            declared.append(f"{_declared(one)} :: {locals_[one.key]}{_dimensions(one.shape)}")
        into, back = _copied(one, arrays[one.key], locals_[one.key])
        if one.intent != "result":
            before.append(into)
        after.append(back)
    externals = {str(one.fixed): None for one in routine.arguments if one.kind is None}
    words = [
        str(one.fixed)
        if one.kind is None
        else locals_.get(one.key) or _at(one, arrays[one.key], "1")
        for one in routine.arguments
    ]
    continued = ", &\n        ".join(words)
    call = f"{routine.name}({continued})"
    result = routine.result
    kind = "" if result is None else f"{_declared(result)}, "
    declared += [f"{kind}external :: {routine.name}", *(f"external :: {one}" for one in externals)]
    if result is None:
        call = f"call {call}"
    else:
        call = f"{locals_.get(result.key) or _at(result, arrays[result.key], '1')} = {call}"
    names = ", &\n    ".join(["n", *arrays.values()])
    lines = [
        f"subroutine {entry(number)}({names})",
        "  implicit none",
        "  integer(8) :: n, i",
        *(f"  {line}" for line in declared),
        "  do i = 1, n",
        *(f"    {line}" for line in [*before, call, *after]),
        "  end do",
        f"end subroutine {entry(number)}",
        "",
    ]
    return "\n".join(lines)


def _blocks(
    description: Description, variables: list[Variable]
) -> tuple[list[str], dict[tuple[str | None, str], str]]:
    """Return the declarations of COMMON blocks, and the names of their members here."""
    declared: list[str] = []
    names: dict[tuple[str | None, str], str] = {}
    for b, block in enumerate(sorted({one.common for one in variables if one.common is not None})):
        members = description.commons[block]
        for k, one in enumerate(members):
            names[block, one.key] = f"c{b}_{k}"
            declared.append(f"{_declared(one)} :: c{b}_{k}{_dimensions(one.shape)}")
        declared.append(f"common /{block}/ {', '.join(f'c{b}_{k}' for k in range(len(members)))}")
    return declared, names


def _copied(one: Variable, array: str, name: str) -> tuple[str, str]:
    section = _at(one, array, ":")
    if one.type.base == "character":
        bytes_ = f"{array}(:, i)"
        return f"{name} = transfer({bytes_}, {name})", f"{bytes_} = transfer({name}, {bytes_})"
    if one.type.base == "logical":
        return f"{name} = {section} /= 0", f"{section} = merge(1, 0, {name})"
    return f"{name} = {section}", f"{section} = {name}"
