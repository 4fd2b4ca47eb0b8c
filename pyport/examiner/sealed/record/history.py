"""What a repository's history holds: which commit added what, and the code that stood there."""

from __future__ import annotations

import io
import subprocess
import tarfile
from dataclasses import dataclass
from pathlib import Path

from pyport.errors import BadInput


@dataclass(frozen=True)
class History:
    """A repository.

    `root`: the folder of its checkout.
    """

    root: Path

    @classmethod
    def of(cls, place: Path) -> History:
        """Find the repository that a place is in.

        Raises `BadInput`: it is in none, or git is not installed.
        """
        inside = next(one for one in (place, *place.resolve().parents) if one.is_dir())
        return cls(Path(_git(inside, "rev-parse", "--show-toplevel").decode().strip()))

    def commits(self, path: Path) -> list[str]:
        """Return the commits that added or changed a file, the first one first."""
        printed = self._git(
            "log", "--full-history", "--reverse", "--format=%H", "--", self._name(path)
        )
        return printed.decode().split()

    def holds(self, path: Path) -> bool:
        """Tell whether the last commit has a file as it lies there."""
        tracked = self._git("ls-tree", "HEAD", "--", self._name(path))
        return bool(tracked) and not self._git("status", "--porcelain", "--", self._name(path))

    def blob(self, commit: str, path: Path) -> bytes:
        """Return a file as it stood in a commit."""
        return self._git("show", f"{commit}:{self._name(path)}")

    def files(self, commit: str, folder: Path) -> set[str]:
        """Return the names of the files that a folder had in a commit."""
        printed = self._git("ls-tree", "-r", "--name-only", commit, "--", f"{self._name(folder)}/")
        return {Path(line).name for line in printed.decode().splitlines()}

    def touched(self, commit: str) -> list[str]:
        """Return the paths that a commit added, changed or removed."""
        printed = self._git("show", "--format=", "--name-only", "--no-renames", "-m", commit)
        return printed.decode().split("\n")[:-1]

    def before(self, first: str, second: str) -> bool:
        """Tell whether a commit is a forebear of another."""
        return first != second and first in self._git("rev-list", second).decode().split()

    def unpack(self, commit: str, folder: str, to: Path) -> Path:
        """Write a folder as it stood in a commit, links left out, and return where it is."""
        with tarfile.open(fileobj=io.BytesIO(self._git("archive", commit, folder))) as held:
            held.extractall(to, [one for one in held if not one.issym()], filter="data")
        return to / folder

    def _name(self, path: Path) -> str:
        return path.resolve().relative_to(self.root.resolve()).as_posix()

    def _git(self, *words: str) -> bytes:
        return _git(self.root, *words)


def _git(place: Path, *words: str) -> bytes:
    try:
        done = subprocess.run(  # noqa: S603 - git, with words of this program
            ["git", "-C", str(place), *words],  # noqa: S607 - wherever it is installed
            capture_output=True,
            check=False,
        )
    except FileNotFoundError:
        raise BadInput("git is not installed, expected it: a proof is in a history") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().removeprefix("fatal: ")
        raise BadInput(f"git {words[0]}: {said[:200]}", place)
    return done.stdout
