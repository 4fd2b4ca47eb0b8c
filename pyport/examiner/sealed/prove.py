"""A proof in three commits: the seal alone; the answers; all truths, their nonces and the score.

What is published of a set lies in one folder of the repository:

    sealed.json         hashes of program, examiner, recordings and truths
    answers.jsonl.xz    what was answered, by the program and by the baselines
    opened.jsonl.xz     every truth and its nonce
    score.json          the table, the baselines' beside it
    verdicts.jsonl.xz   what each of the program's answers was worth

Each names the SHA-256 of the one before it. Recordings, which are large, are made again from the
opened seeds.
"""

from __future__ import annotations

import json
import lzma
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner import baselines
from pyport.examiner.sealed import solve
from pyport.examiner.sealed.examine import examine, judged
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.history import History
from pyport.examiner.sealed.record.published import read_json, read_seal
from pyport.examiner.sealed.scoring import score
from pyport.examiner.sealed.seal import Folder, check_truths, reveal, seal, write_json
from pyport.files import copy_whole, sha256, write_file
from pyport.runs.stages import track

SEALED, ANSWERS, OPENED = "sealed.json", "answers.jsonl.xz", "opened.jsonl.xz"
SCORE, VERDICTS = "score.json", "verdicts.jsonl.xz"
#: The program, by the name of its folder of reports, and who else answers.
PROGRAM = "reports"
WHO = (PROGRAM, *baselines.METHODS)


@dataclass(frozen=True)
class Plan:
    """A proof that is under way.

    `name`: what the set is called.
    `place`: where it is published, in a repository.
    `work`: where recordings, reports and, beside it, the vault are.
    `specs`: gives its cases.
    `jobs`: cases at the same time.
    """

    name: str
    place: Path
    work: Path
    specs: Callable[[], Sequence[Spec]]
    jobs: int = 1

    @property
    def folder(self) -> Folder:
        """Return the set."""
        return Folder(self.work)


def _seal(plan: Plan) -> None:
    if find_spec("sklearn") is None:
        raise BadInput("a baseline needs scikit-learn: pip install 'pyport-pointing[challenge]'")
    if not plan.folder.seal.exists():
        seal(plan.work, plan.name, plan.specs())
    copy_whole(plan.folder.seal, plan.place / SEALED)


def _answer(plan: Plan) -> None:
    """Let the program and the baselines answer, and publish what they said."""
    sealed = _sealed(plan)
    solve.run(plan.work, plan.jobs)
    answer_beside(plan.work, plan.jobs)
    write_lines(plan.place / ANSWERS, [_head("seal", plan.folder.seal), *_answers(plan, sealed)])


def _answers(plan: Plan, sealed: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        {
            "by": by,
            "case": one["case"],
            "report": read_json(Folder(plan.work, by).report(one["case"])),
        }
        for by in WHO
        for one in sealed["cases"]
    ]


def answer_beside(root: Path, jobs: int, who: Iterable[str] = baselines.METHODS) -> None:
    """Let the baselines, or some of them, answer what they have not answered yet."""
    tasks = [
        (Folder(root, by), one["case"], one["arguments"])
        for by in who
        for one in read_seal(Folder(root).seal)["cases"]
        if not Folder(root, by).report(one["case"]).exists()
    ]
    with ProcessPoolExecutor(jobs) as pool:
        for _ in track(pool.map(_answer_one, tasks, chunksize=4), "baselines", total=len(tasks)):
            pass


def _answer_one(task: tuple[Folder, str, list[str]]) -> None:
    folder, case, arguments = task
    solve.keep(folder, case, baselines.answer(folder.by, folder.recordings(case), arguments))


def _open(plan: Plan) -> None:
    """Open every truth, score all answers and publish both."""
    sealed = _sealed(plan)
    _, *said = read_lines((plan.place / ANSWERS).read_bytes())
    if said != json.loads(json.dumps(_answers(plan, sealed))):
        raise BadInput("these answers are not those of the set", plan.place / ANSWERS)
    if plan.folder.answers.exists():
        plan.folder.answers.unlink()  # of a run that was stopped before it was scored
    reveal(plan.work)
    truths = check_truths(plan.folder.opened, sealed)
    opened = [
        {
            "case": case,
            "nonce": (plan.folder.opened / f"{case}.nonce").read_text(encoding="utf-8"),
            "truth": (plan.folder.opened / f"{case}.truth.json").read_text(encoding="utf-8"),
        }
        for case in truths
    ]
    examine(plan.work, plan.jobs)
    scored = read_json(plan.work / "score.json")
    beside = scored_beside(plan.work, truths, plan.jobs)
    head = _head("answers", plan.place / ANSWERS)
    write_lines(plan.place / VERDICTS, scored["verdicts"])
    table = {key: scored[key] for key in ("name", "passed", "table")}
    write_json(plan.place / SCORE, {**head, **table, "beside": beside})
    write_lines(plan.place / OPENED, [head, *opened])


def scored_beside(
    root: Path, truths: dict[str, dict[str, Any]], jobs: int
) -> dict[str, list[dict[str, Any]]]:
    """Return the baselines' rows of the score."""
    return {
        by: [asdict(row) for row in score.table(judged(Folder(root, by), truths, jobs))]
        for by in baselines.METHODS
    }


def _sealed(plan: Plan) -> dict[str, Any]:
    """Return the seal that was published; `BadInput` where the set at work is another."""
    published = plan.place / SEALED
    if not plan.folder.seal.exists() or sha256(plan.folder.seal) != sha256(published):
        raise BadInput(f"{plan.work} holds no set of this seal, expected the one sealed", published)
    return read_seal(published)


def _head(of: str, path: Path) -> dict[str, str]:
    return {f"{of}_sha256": sha256(path), "utc": datetime.now(UTC).isoformat(timespec="seconds")}


def write_lines(path: Path, lines: Iterable[Any]) -> None:
    """Write JSON, one value a line, compressed."""
    text = "".join(
        json.dumps(one, separators=(",", ":"), ensure_ascii=False) + "\n" for one in lines
    )
    write_file(path, lzma.compress(text.encode("utf-8")))


def read_lines(data: bytes) -> list[Any]:
    """Read what `write_lines` wrote.

    Raises `BadInput`: it did not.
    """
    try:
        lines = lzma.decompress(data).decode("utf-8").splitlines()
        return [json.loads(line) for line in lines]
    except (lzma.LZMAError, ValueError, RecursionError) as error:
        raise BadInput(f"these are no compressed lines of JSON ({error})") from None


#: What each commit holds, how it is made, and how one speaks of it.
STAGES: tuple[tuple[tuple[str, ...], Callable[[Plan], None], str], ...] = (
    ((SEALED,), _seal, "Seal"),
    ((ANSWERS,), _answer, "Answer"),
    ((OPENED, SCORE, VERDICTS), _open, "Open"),
)


@dataclass(frozen=True)
class Step:
    """How far a proof has come: the stage, from 1; what is to be committed, if anything."""

    stage: int
    what: str
    commit: tuple[Path, ...]


def advance(plan: Plan) -> Step:
    """Go on with a proof as far as the next commit, from wherever it was interrupted.

    Raises `BadInput`: the program, the examiner or the set is not what was sealed.
    """
    history = History.of(plan.place)
    for number, (names, make, what) in enumerate(STAGES, start=1):
        paths = tuple(plan.place / name for name in names)
        if not all(path.exists() for path in paths):
            make(plan)
        if not all(history.holds(path) for path in paths):
            return Step(number, what, paths)
    return Step(len(STAGES), what, ())
