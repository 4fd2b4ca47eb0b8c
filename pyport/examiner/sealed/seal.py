"""Sealing and opening: a truth is fixed before anyone solves, and shown after everyone has.

A set is a folder:

    sealed.json     hashes of everything below, of the solver and of the examiner: published
    recordings/     what the solver sees
    reports/        what it said
    opened/         truths and nonces, after the opening

and a vault beside it, which holds truths and nonces until then.
"""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner.sealed.protocol import THRESHOLDS, Spec, draft
from pyport.examiner.sealed.record import code, files
from pyport.examiner.sealed.record.compact import rows_of
from pyport.examiner.sealed.record.files import canonical, write_recordings
from pyport.examiner.sealed.record.published import read_answers, read_report, read_seal
from pyport.files import copy_whole, sha256, write_file
from pyport.runs.stages import track

SCHEMA = "pyport.sealed/2"


@dataclass(frozen=True)
class Folder:
    """Where the parts of a set are, and whose answers are meant: the program's, or a baseline's."""

    root: Path
    by: str = "reports"

    @property
    def seal(self) -> Path:
        """Return the file that is published."""
        return self.root / "sealed.json"

    @property
    def vault(self) -> Path:
        """Return where truths are until they are opened."""
        return self.root.with_name(f"{self.root.name}.vault")

    @property
    def draft(self) -> Path:
        """Return what was drawn for the set, there while it is being sealed."""
        return self.vault / "draft.json"

    @property
    def opened(self) -> Path:
        """Return where truths are afterwards."""
        return self.root / "opened"

    @property
    def answers(self) -> Path:
        """Return the file that holds the hashes of all reports, written at the opening."""
        return self.root / "answers.json"

    def recordings(self, case: str) -> Path:
        """Return what may be seen of a case."""
        return self.root / "recordings" / f"{case}.csv"

    def report(self, case: str) -> Path:
        """Return what the solver said of it."""
        return self.root / self.by / case / "report.json"

    def rows(self, case: str) -> Path:
        """Return its residuals, reading by reading."""
        return self.root / self.by / case / "rows.csv"


def write_json(path: Path, data: Any) -> None:  # noqa: ANN401 - whatever JSON holds
    """Write readable JSON, whole or not at all."""
    write_file(path, json.dumps(data, indent=1, ensure_ascii=False) + "\n")


def seal(
    root: Path, name: str, specs: Sequence[Spec], chance: random.Random | None = None
) -> dict[str, Any]:
    """Draw the truths of a set, write its recordings, and publish what fixes them.

    Killed and called again with the same cases it goes on, and seals the set that it began.

    `root`: folder of the set, new or empty; the vault is made beside it.
    `name`: what the set is called in the ledger.
    `specs`: its cases, before their seeds are drawn.
    `chance`: what order, seeds and nonces are drawn from; the system's entropy when not given.
    Raises `BadInput`: the folder holds something already: a set is sealed once. Or sealing was
      begun there with other cases, or by another program.
    """
    folder = Folder(root)
    if folder.seal.exists() or not folder.draft.exists():
        for place in (root, folder.vault):
            # A hidden file is what is left of a run that was killed as it began.
            if place.exists() and any(one.name[0] != "." for one in place.iterdir()):
                raise BadInput("this folder is not empty: expected a new one for each set", place)
    drawn = draft(folder.draft, name, specs, chance or random.SystemRandom())
    cases = [_seal_case(folder, one) for one in track(drawn["cases"], "sealing")]
    sealed = {
        "schema": SCHEMA,
        "name": name,
        "sealed_utc": datetime.now(UTC).isoformat(timespec="seconds"),
        "solver_sha256": drawn["solver_sha256"],
        "examiner_sha256": drawn["examiner_sha256"],
        "solver_parts": files.parts(code.SOLVER),
        "examiner_parts": files.parts(code.EXAMINER),
        "libraries": drawn["libraries"],
        "thresholds": THRESHOLDS,
        "cases": cases,
    }
    write_json(folder.seal, sealed)
    folder.draft.unlink()
    return sealed


def _seal_case(folder: Folder, drawn: dict[str, Any]) -> dict[str, Any]:
    """Make one case, put its truth into the vault, and return what is published of it.

    The nonce is written last: where it is, the case was made before.
    """
    case, seed, spec = (drawn[key] for key in ("case", "seed", "spec"))
    truth, nonce = (folder.vault / f"{case}.{kind}" for kind in ("truth.json", "nonce"))
    if not nonce.exists():
        made = Spec(**spec).make(seed)
        write_recordings(made, folder.recordings(case))
        entry = {"case": case, "seed": seed, "spec": spec, "truth": made.truth}
        write_file(truth, canonical(entry))
        write_file(nonce, drawn["nonce"])
    text = truth.read_bytes().decode("utf-8")
    return {
        "case": case,
        "recordings_sha256": sha256(folder.recordings(case)),
        "truth_commitment": files.commitment(drawn["nonce"], text),
        "arguments": json.loads(text)["truth"]["arguments"],
    }


def reveal(root: Path) -> int:
    """Open a set: fix what was answered, then move the truths out of the vault; return how many.

    Raises `BadInput`: a case has no answer yet, or a truth is not the one that was sealed.
    """
    folder = Folder(root)
    sealed = read_seal(folder.seal)
    names = [one["case"] for one in sealed["cases"]]
    missing = [name for name in names if not folder.report(name).exists()]
    if missing and not folder.answers.exists():
        raise BadInput(
            f"{len(missing)} cases are not solved yet, {missing[0]} the first: expected all of"
            " them, since a set is opened once",
            folder.seal,
        )
    check_truths(folder.vault, sealed)
    if folder.answers.exists():
        check_answers(root)  # what was answered is fixed: the opening goes on
    else:
        answers = {name: sha256(folder.report(name)) for name in names}
        write_json(folder.answers, {"opened_utc": _now(), "reports_sha256": answers})
    for name in names:
        for file in (f"{name}.truth.json", f"{name}.nonce"):
            copy_whole(folder.vault / file, folder.opened / file)
    return len(names)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def check_truths(place: Path, sealed: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the truths in a folder by case, each held to its commitment."""
    truths = {}
    for one in sealed["cases"]:
        path = place / f"{one['case']}.truth.json"
        try:
            text = path.read_bytes().decode("utf-8")
            nonce = (place / f"{one['case']}.nonce").read_text(encoding="utf-8").strip()
            same = files.commitment(nonce, text) == one["truth_commitment"]
        except (OSError, ValueError):
            same = False
        if not same:
            raise BadInput("this truth is not the one that was sealed", path)
        truths[one["case"]] = json.loads(text)
    return truths


def check_untouched(root: Path) -> None:
    """Raise `BadInput` unless recordings, solver, examiner and thresholds are those sealed."""
    folder = Folder(root)
    sealed = read_seal(folder.seal)
    for one in sealed["cases"]:
        path = folder.recordings(one["case"])
        if not path.exists() or sha256(path) != one["recordings_sha256"]:
            raise BadInput("these recordings are not the ones that were sealed", path)
    for who, now in (("solver", files.solver()), ("examiner", files.examiner())):
        then = sealed[f"{who}_sha256"]
        if then != now:
            raise BadInput(
                f"the {who} has changed since the set was sealed ({moved_on(sealed, who)}):"
                " expected the same, or a new set",
                folder.seal,
            )
    if sealed["thresholds"] != THRESHOLDS:
        raise BadInput("the thresholds are not those of this examiner", folder.seal)


_SHOWN = 8


def moved_on(sealed: dict[str, Any], who: str) -> str:
    """Return what has changed of the solver or the examiner since a seal, in words; "" if nothing.

    `who`: "solver" or "examiner".
    """
    unit = code.SOLVER if who == "solver" else code.EXAMINER
    now = files.parts(unit)
    then, whole = sealed[f"{who}_sha256"], code.whole(now)
    if then == whole:
        return ""
    changed = code.changes(sealed.get(f"{who}_parts") or {}, now)
    more = f" and {len(changed) - _SHOWN} more" if len(changed) > _SHOWN else ""
    return f"{then[:12]} then, {whole[:12]} now; {', '.join(changed[:_SHOWN])}{more}"


def check_answers(root: Path) -> None:
    """Raise `BadInput` unless the reports are those that stood when the set was opened."""
    folder = Folder(root)
    for name, expected in read_answers(folder.answers).items():
        path = folder.report(name)
        if not path.exists() or sha256(path) != expected:
            raise BadInput("this report is not the one that stood when the set was opened", path)
        rows, left_out = folder.rows(name), read_report(path).get("left_out")
        said = rows_of(left_out) if left_out else ""
        if rows.exists() and rows.read_text(encoding="utf-8") != said:
            raise BadInput("these residuals are not those of the report", rows)
