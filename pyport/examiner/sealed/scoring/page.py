"""The public record, from sets that were published: the page of the proof, the ledger, the README.

Nothing is written by hand: what a page says is read from the files that `pyport dev prove` left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner.sealed.prove import ANSWERS, OPENED, SCORE, SEALED, VERDICTS, WHO, read_lines
from pyport.examiner.sealed.record.published import read_json, read_seal
from pyport.examiner.sealed.scoring import figures
from pyport.examiner.sealed.scoring.judge import Verdict
from pyport.examiner.sealed.scoring.sections import cosines_of, left_out, unknown, wrong
from pyport.examiner.sealed.seal import moved_on
from pyport.files import sha256

_HEAD = """# Does it find what was hidden?

<!-- written by `pyport dev trials page` -->

The claim: given recordings that differ from the simulation, `pyport diagnose` finds where, says
which physics was left out, models it, and the fit improves on data that it did not see.

The proof: causes are drawn at random and put into recordings by an examiner that imports nothing of
the program. Its telescope is made of rotations, its sky is ERFA's, with catalogue sources, real
dates and the Earth's real orientation. Where a law fixes the form of a cause, as it does for
refraction, aberration or an axis that leans, examiner and program hold the same law. Forms that no
law fixes, such as bumps, waves and steps, are drawn by the examiner's own formulae; it is not
claimed that they are unlike every shape that the program tries.

## What an outsider can check

A set stands in the repository's history in three commits.

1. *Sealed*: `sealed.json` alone, with the hashes of the program, the examiner and the thresholds,
   of each file of recordings, and of each truth with a nonce of 256 random bits.
2. *Answered*: what was answered to each case, by the program in a process that sees the
   recordings and cannot open the truth, and by two baselines.
3. *Opened*: all truths, their nonces, and the score.

```
pyport dev prove --verify NAME --again all
```

reads the history and nothing else. It checks the order of the commits, that the first two
hold nothing else, that no file was changed later, that program and examiner are those which stood
in the sealing commit, and every truth; it makes the recordings again from the opened seeds with
the code that was sealed, compares their hashes, judges every answer again and compares the score.
A history that was rewritten from its seal on would still deceive whoever first sees it later: to be
sure, keep the hash of `sealed.json` from the day of the sealing.

"The program" is the code that turns a file of recordings into report.json, all that `pyport
diagnose` imports but for its page and its pictures. Its hash is that of the syntax: a comment, a
docstring or the manual voids no proof, any other change does. Every set that was ever sealed
stands in the [ledger](proof/ledger.md).

Any other program can take [the challenge](challenge.md) and is scored by the same judge.

Beside the drawn cases stand real recordings, each with a fact that was never in them: [the
GMRT](proof/gmrt.md), whose antennas were surveyed; [the RT32's published
table](proof/published-table.md), which holds what its routines do not; [the MMT](proof/mmt.md),
whose model was published night by night; [IRAM's 30 m](proof/iram.md), whose dampers were
softened on a known day; [RTS2](proof/rts2.md), [the LMT](proof/lmt.md) and
[AuxTel](proof/auxtel.md), whose models others fitted. `pyport dev acceptance` and `pyport dev
real` print what else is promised.
"""

_NONE = """
## No set of this kind is sealed yet

The last one was sealed and opened in an older way, with {program}:
[876 cases](proof/first.md), of whose rows with a threshold three did not pass.
"""

_CHECK = """
### Every truth by hand

```python
import hashlib, json, lzma

folder = "{folder}/"
cases = json.load(open(folder + "sealed.json"))["cases"]
sealed = {{one["case"]: one["truth_commitment"] for one in cases}}
for line in lzma.open(folder + "opened.jsonl.xz", "rt", encoding="utf-8").readlines()[1:]:
    one = json.loads(line)
    bare = bytes.fromhex(one["nonce"]) + one["truth"].encode()
    assert hashlib.sha256(bare).hexdigest() == sealed.pop(one["case"])
assert not sealed
```
"""

_CAPTIONS = {
    "detection.png": "How often a single cause is detected, and named right first, against rho.",
    "length.png": "The same against the number of recordings.",
    "calibration.png": "Stated p-values where nothing is hidden: on the line they are honest.",
    "skill.png": "How much of what a refit of the true form gains on unseen data was gained.",
    "confusion.png": "What was said first of what was hidden, in per cent of its cases.",
}

#: What the last set of the older kind was answered by.
_OLDER = "a program that has changed since (commit `0bfcbba`)"
_MARKS = {True: "yes", False: "**no**", None: "shown"}
_NAMES = dict(zip(WHO, ("pyport", *WHO[1:]), strict=True))


@dataclass(frozen=True)
class Published:
    """A set as it stands in the repository.

    `sealed`: its seal; `score`: what it scored, None where it was not opened yet.
    """

    folder: Path
    sealed: dict[str, Any]
    score: dict[str, Any] | None

    @property
    def verdicts(self) -> list[Verdict]:
        """Return what each of the program's answers was worth.

        Raises `BadInput`: the file is of another examiner.
        """
        path = self.folder / VERDICTS
        try:
            return [Verdict(**one) for one in read_lines(path.read_bytes())]
        except TypeError as error:
            raise BadInput(f"these are no verdicts ({error})", path) from None


def published(sets: Path) -> list[Published]:
    """Return the sets of a folder in the order in which they were sealed."""
    found = []
    for path in sets.glob(f"*/{SEALED}"):
        opened = path.with_name(SCORE)
        score = read_json(opened) if opened.exists() else None
        found.append(Published(path.parent, read_seal(path), score))
    return sorted(found, key=lambda one: str(one.sealed["sealed_utc"]))


def last(some: Sequence[Published]) -> Published | None:
    """Return the last set that was opened."""
    return next((one for one in reversed(some) if one.score), None)


def program(one: Published | None) -> str:
    """Return of which program a set speaks, and whether it is this one, in words."""
    if one is None:
        return _OLDER
    name = f"program `{one.sealed['solver_sha256'][:16]}`"
    changed = moved_on(one.sealed, "solver")
    return f"{name}, which has changed since" if changed else f"{name}, which is this version"


def readme(some: Sequence[Published]) -> str:
    """Return what the README says of the proof."""
    one = last(some)
    cases = len(one.sealed["cases"]) if one else 876
    return (
        f"Does it find what is missing? [The proof](docs/proof.md): {cases:,} sealed cases,\n"
        f"opened once, with every wrong answer, of {program(one)}.\n"
        "Any other program can take [the challenge](docs/challenge.md).\n"
    )


def proof(some: Sequence[Published], docs: Path) -> str:
    """Return the page of the proof, and draw its pictures into the folder of the last opened set.

    `docs`: the folder of the page, which links are relative to.
    """
    one = last(some)
    if one is None:
        return _HEAD + _NONE.format(program=program(None))
    return "\n".join([_HEAD, *_section(one, docs), _CHECK.format(folder=one.folder)])


def _section(one: Published, docs: Path) -> list[str]:
    score, verdicts = one.score or {}, one.verdicts
    place = one.folder.resolve().relative_to(docs.resolve()).as_posix()
    pictures = [
        f"![{_CAPTIONS[name]}]({place}/{name})\n\n{_CAPTIONS[name]}\n"
        for name in figures.write(one.folder, verdicts)
    ]
    return [
        f"## {score['name']}: {'passed' if score['passed'] else 'not passed'}\n",
        f"{len(verdicts):,} cases, sealed {one.sealed['sealed_utc']}, of {program(one)}.",
        f"The seal is `{sha256(one.folder / SEALED)}`.\n",
        "rho is what the base model leaves of a cause, rms, over the noise, on the axis where it",
        "is greater. Brackets hold counts and Wilson's 95 % interval. Beside the program stand",
        "two baselines: term picking by BIC, and the cross-validated lasso, over [the classical",
        "list](challenge.md).\n",
        _table(score),
        "Rows that did not pass are [explained](proof/reasons.md).\n",
        *pictures,
        left_out(verdicts),
        unknown(verdicts, cosines_of(one.folder)),
        wrong(verdicts),
    ]


def _table(score: dict[str, Any]) -> str:
    """Return the rows of the program with those of the baselines beside them."""
    others = {
        by: {row["what"]: row["result"] for row in rows} for by, rows in score["beside"].items()
    }
    lines = [
        f"| what | needed | {' | '.join(_NAMES[by] for by in WHO)} | passed |",
        "|---|---|" + "---|" * len(WHO) + "---|",
    ]
    for row in score["table"]:
        beside = [others[by].get(row["what"], "-") for by in WHO[1:]]
        cells = [row["what"], row["needed"], row["result"], *beside, _MARKS[row["passed"]]]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def ledger(some: Sequence[Published]) -> str:
    """Return an entry for each set: what was sealed, and what it scored."""
    return "\n".join(_entry(one) for one in some)


def _entry(one: Published) -> str:
    sealed, score = one.sealed, one.score
    lines = [
        f"## {sealed['name']}\n",
        f"Sealed {sealed['sealed_utc']}, {len(sealed['cases']):,} cases.\n",
        f"- seal `{sha256(one.folder / SEALED)}`",
        f"- program `{sealed['solver_sha256']}`",
        f"- examiner `{sealed['examiner_sha256']}`",
    ]
    for what, name in (("answers", ANSWERS), ("opening", OPENED)):
        if (path := one.folder / name).exists():
            lines.append(f"- {what} `{sha256(path)}`")
    if score is None:
        return "\n".join([*lines, "\nNot opened yet.\n"])
    passed = "passed" if score["passed"] else "not passed"
    rows = [
        f"| {row['what']} | {row['result']} | {row['needed']} | {_MARKS[row['passed']]} |"
        for row in score["table"]
    ]
    heading = f"\n### Score of {sealed['name']}: {passed}\n"
    return "\n".join(
        [*lines, heading, "| what | result | needed | passed |", "|---|---|---|---|", *rows, ""]
    )
