"""What a user may get wrong, and how it is said."""

from __future__ import annotations

from pathlib import Path


class BadInput(ValueError):  # noqa: N818 - the name says whose mistake it is
    """Input that cannot be used: file, line, what is wrong and what was expected.

    The command line prints it as one line and exits with status 2.
    """

    def __init__(self, message: str, file: str | Path | None = None, line: int | None = None):
        self.message = " ".join(message.split())
        self.file = None if file is None else str(file)
        self.line = line
        place = "" if file is None else f"{file}:{1 if line is None else line}: "
        super().__init__(place + self.message)
