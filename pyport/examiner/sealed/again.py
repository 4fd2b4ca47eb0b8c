"""Recordings made again from opened seeds, and what the answers to them are worth.

    python -m pyport.examiner.sealed.again FOLDER JOBS CASE...

is run with the code that was sealed, on a folder that was filled from a history: `sealed.json`,
`opened/` and the answers. It writes `again.json` there.
"""

from __future__ import annotations

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from pyport.examiner.sealed.examine import Score, as_json, judged, scored
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.prove import scored_beside
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.sealed.record.published import read_seal
from pyport.examiner.sealed.seal import Folder, write_json
from pyport.files import sha256


def again(root: Path, jobs: int, cases: list[str]) -> dict[str, Any]:
    """Return hashes of recordings made again, verdicts, and of all cases the whole score."""
    folder = Folder(root)
    sealed = read_seal(folder.seal)
    truths = {
        case: json.loads((folder.opened / f"{case}.truth.json").read_text(encoding="utf-8"))
        for case in cases
    }
    with ProcessPoolExecutor(jobs) as pool:
        made = list(pool.map(_make, [(folder, *one) for one in truths.items()], chunksize=4))
    found: dict[str, Any] = {"recordings": dict(zip(truths, made, strict=True))}
    if len(cases) < len(sealed["cases"]):
        verdicts = judged(folder, truths, jobs)
        return {**found, **as_json(Score(sealed["name"], sealed, verdicts, []))}
    whole = as_json(scored(folder, truths, jobs))
    return {**found, **whole, "beside": scored_beside(root, truths, jobs)}


def _make(task: tuple[Folder, str, dict[str, Any]]) -> str:
    folder, case, truth = task
    path = folder.recordings(case)
    write_recordings(Spec(**truth["spec"]).make(truth["seed"]), path)
    return sha256(path)


if __name__ == "__main__":
    _, place, number, *names = sys.argv
    write_json(Path(place) / "again.json", again(Path(place), int(number), names))
