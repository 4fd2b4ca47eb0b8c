"""The ledger: every set ever sealed, and what came of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pyport.examiner.sealed.examine import Score
from pyport.examiner.sealed.seal import Folder
from pyport.files import sha256, write_whole

_HEAD = """# Ledger of sealed sets

Every set that was ever sealed, in order, with its score, good or bad. A set is
solved once and opened once. `pyport dev trials seal` and `pyport dev trials score` write here.
"""


def enter_seal(ledger: Path, root: Path, sealed: dict[str, Any]) -> None:
    """Write down that a set was sealed."""
    _append(
        ledger,
        f"""
## {sealed["name"]}

Sealed {sealed["sealed_utc"]}, {len(sealed["cases"])} cases.

- seal `{sha256(Folder(root).seal)}`
- solver `{sealed["solver_sha256"]}`
- examiner `{sealed["examiner_sha256"]}`
""",
    )


def enter_score(ledger: Path, root: Path, score: Score) -> None:
    """Write down what a set scored; its seal says which one it is."""
    failed = [one for one in score.verdicts if one.failed]
    lines = "\n".join(map(str, score.rows))
    _append(
        ledger,
        f"""
### Score of {score.name}: {"passed" if score.passed else "not passed"}

Seal `{sha256(Folder(root).seal)}`; {len(failed)} cases without a report.

| what | result | needed | passed |
|---|---|---|---|
{lines}
""",
    )


def _append(ledger: Path, text: str) -> None:
    """Add an entry, once: a run that was killed after it did so says it again when called again."""
    before = ledger.read_text(encoding="utf-8") if ledger.exists() else _HEAD
    if text in before:
        return
    with write_whole(ledger) as file:
        file.write(before + text)
