"""Make the shipped recordings, and the figures of README.md, from the printed tables."""

from __future__ import annotations

from pyport.files import write_file
from pyport.recordings.files import DATA
from pyport.studies.gmrt.recovery import build, checks


def main() -> None:
    """Write every file of recordings, Table 18, and the figures of the README."""
    build.write_all(DATA)
    text = checks.readme()
    write_file(checks.README, text)


if __name__ == "__main__":
    main()
