"""Compile the Fortran of a description, patched, with its loops, into a module that f2py wraps.

`patch` is not on every machine, and forgives what must not be forgiven here (fuzz, offsets).
"""

from __future__ import annotations

import hashlib
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.files import sha256
from pyport.parity.compiled import driver
from pyport.parity.described.description import Build, Description
from pyport.runs.checkpoint import cache_folder

HUNK = re.compile(r"@@ -(\d+)(?:,(\d+))? \+\d+(?:,\d+)? @@")
TARGET = re.compile(r"^\+\+\+ (?:\S*/)?(\S+)", re.MULTILINE)


class PatchDoesNotApply(Exception):  # noqa: N818 - reads as the sentence it is
    """A patch whose context is not what the file holds."""


def apply_patch(lines: list[str], patch: str) -> list[str]:
    """Return `lines` (without newlines) changed by a unified diff of one file."""
    rows = patch.splitlines()
    first = next((i for i, row in enumerate(rows) if HUNK.match(row)), len(rows))
    result: list[str] = []
    position = 0
    for number, row in enumerate(rows[first:], start=first + 1):
        if header := HUNK.match(row):
            start = int(header[1]) - (header[2] != "0")
            result += lines[position:start]
            position = start
            continue
        mark, text = row[:1], row[1:]
        if not mark or mark not in " -+":
            raise PatchDoesNotApply(f"line {number}: neither context nor change: {row!r}")
        if mark != "+":
            if lines[position : position + 1] != [text]:
                raise PatchDoesNotApply(
                    f"line {number}: line {position + 1} of the source is not {text!r}"
                )
            position += 1
        if mark != "-":
            result.append(text)
    return result + lines[position:]


def patched(source: Path, patches: list[Path]) -> str:
    """Return the text of `source` changed by those of the patches that name it, in order."""
    lines = source.read_text(encoding="ascii").splitlines()
    for path in patches:
        text = path.read_text(encoding="ascii")
        target = TARGET.search(text)
        if target is None:
            raise PatchDoesNotApply(f"{path}: no '+++ FILE' line")
        if target[1] == source.name:
            try:
                lines = apply_patch(lines, text)
            except PatchDoesNotApply as error:
                raise PatchDoesNotApply(f"{path}: {error}") from None
    return "\n".join(lines) + "\n"


LIBRARY = f"{driver.MODULE}.so"
LOOPS = "parity_loops.f90"
SIGNATURE = f"{driver.MODULE}.pyf"
#: What f2py writes for a signature file, and what of its own is compiled with it, as objects.
WRAPPER = {f"{driver.MODULE}module.c": "wrapper.o", "fortranobject.c": "fortranobject.o"}


def command_of(compiler: str) -> str | None:
    """Return the command of a compiler, with a version after its name where it has one."""
    if shutil.which(compiler):
        return compiler
    versions = [one.name for one in Path("/usr/bin").glob(f"{compiler}*")]
    return next(filter(shutil.which, sorted(versions, reverse=True)), None)


@cache
def c_compiler() -> str | None:
    """Return the command of a C compiler: the one that built this Python where it is there."""
    words = str(sysconfig.get_config_var("CC") or "").split()
    return next(filter(shutil.which, [*words[:1], "gcc", "cc", "clang"]), None)


def lacking(compiler: str) -> str:
    """Name what a machine lacks to build the oracle; nothing where it lacks nothing."""
    if command_of(compiler) is None:
        return compiler
    if c_compiler() is None:
        return "a C compiler"
    if not (Path(sysconfig.get_path("include")) / "Python.h").is_file():
        return "Python.h (of Python's development files)"
    return ""


@cache
def version(compiler: str) -> str:
    """Return the first line of what a compiler says of itself."""
    asked = subprocess.run(  # noqa: S603 - a compiler's name, from the description
        [compiler, "--version"], check=True, capture_output=True, text=True
    )
    return asked.stdout.splitlines()[0]


def sources(description: Description, build: Build) -> dict[str, str]:
    """Return the patched text of each file by its name.

    Raises `BadInput`: a file is missing, is no text, or a patch does not apply.
    """
    texts: dict[str, str] = {}
    for path in (*description.include, *description.files):
        if path.name in texts:
            raise BadInput(f"two files named {path.name}: expected one", description.path)
        try:
            texts[path.name] = patched(path, list(build.patches))
        except PatchDoesNotApply as error:
            raise BadInput(str(error), description.path) from None
        except (OSError, UnicodeDecodeError) as error:
            raise BadInput(f"cannot be read ({error}): expected Fortran", path) from None
    return texts


def library(description: Description, build: Build, changed: dict[str, str] | None = None) -> Path:
    """Return the compiled library, from the cache where the same text was compiled before.

    `description`, `build`: what to compile and how.
    `changed`: texts that stand in for files, as mutants do; these are not cached.
    Raises `BadInput`: there is no compiler, or it refuses: its first message.
    """
    texts = sources(description, build) | (changed or {})
    texts[LOOPS] = loops = driver.source(description, build)
    compiler = command_of(build.compiler)
    missing = lacking(build.compiler)
    if compiler is None or missing:
        raise BadInput(f"no {missing} on this machine: expected what compiles the Fortran")
    wrapper = wrapped(driver.signature(description, build))
    if changed is not None:
        folder = Path(tempfile.mkdtemp(prefix="parity-"))
        compile_into(folder, description, build, compiler, texts, wrapper)
        return folder / LIBRARY
    what = [version(compiler), platform.machine(), *build.flags, loops, wrapper.name]
    what += [f"{name}\n{text}" for name, text in texts.items()]

    def make(folder: Path) -> None:
        compile_into(folder, description, build, compiler, texts, wrapper)

    return _kept(what, LIBRARY, make) / LIBRARY


def wrapped(signature: str) -> Path:
    """Return a folder with f2py's wrapper of a signature file as objects, from the cache or made.

    The wrapper depends on the routines' arguments alone: builds and mutants share it.
    """
    from numpy import f2py

    compiler = c_compiler()
    if compiler is None:
        raise BadInput("no C compiler on this machine: expected one for the wrapper of f2py")
    home = Path(f2py.get_include())
    include = [np.get_include(), str(home), sysconfig.get_path("include")]

    def make(folder: Path) -> None:
        (folder / SIGNATURE).write_text(signature, encoding="ascii", newline="\n")
        # -P: what lies in the folder is no module to import
        _call(sys.executable, ["-P", "-m", "numpy.f2py", "--quiet", SIGNATURE], folder)
        shutil.copy(home / "fortranobject.c", folder)
        for name, made in WRAPPER.items():
            options = ["-O1", "-fPIC", "-w", *(f"-I{one}" for one in include)]
            _call(compiler, [*options, "-c", name, "-o", made], folder)

    what = [version(compiler), platform.machine(), sys.version, np.__version__, *include, signature]
    return _kept(what, list(WRAPPER.values())[-1], make)


def _kept(what: list[str], made: str, make: Callable[[Path], None]) -> Path:
    """Return the folder of the cache for `what`; where the file `made` is not in it, make it."""
    key = hashlib.sha256("\0".join(what).encode()).hexdigest()[:32]
    home = cache_folder() / "fortran" / key
    if not (home / made).is_file():
        home.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f"{key}.", dir=home.parent))
        try:
            make(folder)
            folder.replace(home)
        except OSError:
            if not (home / made).is_file():  # another process was not faster
                raise
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    return home


def compile_into(
    folder: Path,
    description: Description,
    build: Build,
    compiler: str,
    texts: dict[str, str],
    wrapper: Path,
) -> None:
    """Compile texts into an extension module in `folder`, with f2py's objects from `wrapper`.

    Objects are linked apart, without the flags: linking with -ffast-math would switch the whole
    process to flushing subnormals.
    """
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii", newline="\n")
    flags = build.flags
    if Path(compiler).name.partition("-")[0] != "gfortran":
        flags = tuple(one for one in flags if one.startswith("-O"))
    objects = []
    for name in [one.name for one in description.files] + [LOOPS]:
        objects.append(f"{Path(name).stem}.o")
        _call(compiler, [*flags, "-I.", "-fPIC", "-c", name, "-o", objects[-1]], folder)
    objects += [str(wrapper / one) for one in WRAPPER.values()]
    coverage = ["--coverage"] if build.counted else []
    _call(compiler, [*coverage, "-shared", *objects, "-o", LIBRARY], folder)


def _call(program: str, arguments: list[str], folder: Path) -> None:
    done = subprocess.run(  # noqa: S603 - a compiler, or f2py
        [program, *arguments], cwd=folder, check=False, capture_output=True, text=True
    )
    if done.returncode:
        raise BadInput(_first_message(done.stderr))


def _first_message(stderr: str) -> str:
    """Return the first error of a compiler or linker as one line."""
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    place = next((line for line in lines if re.match(r"[\w.\-]+:\d+:", line)), "")
    said = [line for line in lines if re.search(r"error|undefined reference", line, re.IGNORECASE)]
    said = said or lines or ["no message"]
    if "undefined reference" in said[0] or "undefined symbol" in said[0]:
        return f"does not link: {said[0]}"
    return f"does not compile: {place} {said[0]}".replace("  ", " ")


def provenance(description: Description, build: Build) -> dict[str, Any]:
    """Return what a build is made of: compiler, flags, digests of the files as they are kept."""
    compiler = command_of(build.compiler)
    found = re.findall(r"\d+\.\d+\.\d+", version(compiler) if compiler else "")
    name = "gcc" if build.compiler == "gfortran" else build.compiler
    return {
        "compiler": f"{name} {found[-1] if found else 'unknown'}",
        "flags": " ".join(build.flags),
        "published_sha256": {one.name: sha256(one) for one in sorted(description.files)},
    }
