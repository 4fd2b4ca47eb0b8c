"""Files written whole or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

#: A temporary file that nobody has touched for so long is what a killed run left [s].
ABANDONED_S = 3600.0


@contextlib.contextmanager
def write_whole(path: str | Path, mode: str = "w") -> Iterator[IO[Any]]:
    """Open a file that replaces `path` only when everything was written.

    The new content goes to a temporary file in the same folder, is synced to
    disk and renamed over the old one, whose mode it keeps; an exception or a kill
    leaves the old file as it was. What a killed run left behind is removed by a
    later one. A link stays one: what it names is replaced. Into a pipe or a device
    the content goes as it comes.

    Parameters
    ----------
    path
        The file to write.
    mode
        ``"w"`` for text (UTF-8, newlines as written) or ``"wb"`` for bytes.

    Raises
    ------
    OSError
        The file cannot be written; its name is that of `path`.
    """
    given, path = str(path), Path(os.path.realpath(path))
    options = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    temporary = ""
    try:
        there = path.stat() if path.exists() else None
        if there is not None and not (stat.S_ISREG(there.st_mode) or stat.S_ISDIR(there.st_mode)):
            # mypy knows no overload of a mode and options that depend on it, here and below
            with path.open(mode, **options) as file:  # type: ignore[call-overload]
                yield file
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        _remove_abandoned(path)
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with os.fdopen(handle, mode, **options) as file:  # type: ignore[call-overload]
            yield file
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(_usual_mode() if there is None else stat.S_IMODE(there.st_mode))
        Path(temporary).replace(path)
        temporary = ""
        _sync_folder(path.parent)
    except OSError as error:
        # the temporary name, or none at all (a full disk), says nothing to whoever reads this
        if error.filename is None or Path(error.filename).name.startswith(f".{path.name}."):
            text = f"cannot be written: {error.strerror or error}"
            raise OSError(error.errno, text, given) from error
        raise
    finally:
        if temporary:
            with contextlib.suppress(OSError):
                Path(temporary).unlink()


def write_file(path: str | Path, content: str | bytes) -> None:
    """Write a file, whole or not at all: text as UTF-8, newlines as they are, or bytes."""
    with write_whole(path, "w" if isinstance(content, str) else "wb") as file:
        file.write(content)


def copy_whole(source: Path, target: Path) -> None:
    """Copy the bytes of a file."""
    write_file(target, source.read_bytes())


def _usual_mode() -> int:
    """Return what a new file's mode is, as far as the umask allows."""
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def _sync_folder(folder: Path) -> None:
    """Let the new name reach the disk too, where folders can be synced."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _remove_abandoned(path: Path) -> None:
    """Remove what runs that were killed while they wrote `path` left an hour ago or earlier."""
    prefix = f".{path.name}."
    with contextlib.suppress(OSError):
        for one in os.scandir(path.parent):
            mine = one.name.startswith(prefix) and len(one.name) == len(prefix) + 8
            if mine and time.time() - one.stat().st_mtime > ABANDONED_S:
                Path(one.path).unlink()


def is_file(path: str | Path) -> bool:
    """Tell whether there is such a file; a name too long for one is no file's."""
    try:
        return Path(path).is_file()
    except OSError:
        return False


def is_folder(path: str | Path) -> bool:
    """Tell whether there is such a folder; a name too long for one is no folder's."""
    try:
        return Path(path).is_dir()
    except OSError:
        return False


def is_spelled(name: str | Path) -> bool:
    """Tell whether a name of a file is UTF-8: bytes that are none come as lone surrogates."""
    try:
        str(name).encode()
    except UnicodeEncodeError:
        return False
    return True


def sha256(path: str | Path) -> str:
    """Return the SHA-256 of a file's bytes as hexadecimal text."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def tree(folder: Path) -> str:
    """Return one SHA-256 for all files in a folder, names and bytes, compiled ones apart.

    Links are followed: a checkout, which has some folders elsewhere, and what is
    installed from it are one program.
    """
    found = [
        Path(place, name)
        for place, _, names in os.walk(folder, followlinks=True)
        if "__pycache__" not in Path(place).parts
        for name in names
    ]
    whole = hashlib.sha256()
    for path in sorted(found):
        whole.update(f"{sha256(path)}  {path.relative_to(folder).as_posix()}\n".encode())
    return whole.hexdigest()
