"""Sealing and opening a set, killed and called again."""

from __future__ import annotations

import json
import random
import shutil
import signal
import subprocess
import sys
import time

import pytest

from pyport.errors import BadInput
from pyport.examiner.sealed import seal
from pyport.examiner.sealed.protocol import Spec

SPECS = [
    Spec("null", "null", rows=400, noise="white"),
    *(Spec("one", "one", one, 1.0, 400) for one in ("refraction", "tilt", "drift", "sag_sine")),
]
#: Seals a set by itself, so that it can be killed.
SEALING = """
import sys
from pathlib import Path
sys.path[:0] = [sys.argv[2]]
from test_resume_trials import SPECS
from pyport.examiner.sealed.seal import seal
seal(Path(sys.argv[1]), "a-set", SPECS)
"""


def sealing(root):
    """Start to seal a set in a process of its own."""
    here = str(__file__).rpartition("/")[0]
    return subprocess.Popen([sys.executable, "-c", SEALING, str(root), here])


def made(folder):
    """Return what has been made of a set: the bytes of each file by its name."""
    return {
        str(path.relative_to(place)): path.read_bytes()
        for place in (folder.root, folder.vault)
        for path in place.rglob("*")
        if path.is_file() and path.name[0] != "."
    }


def test_sealing_killed_and_called_again_seals_the_set_that_it_began(tmp_path):
    """Whenever it is killed: each file that was there is there, and all are as one run makes them.

    One run from the same draft, undisturbed, says what is to come out.
    """
    loud, quiet = seal.Folder(tmp_path / "loud" / "set"), seal.Folder(tmp_path / "quiet" / "set")
    kills = 0
    for cases in (0, 1, 3):
        process = sealing(loud.root)
        while process.poll() is None:
            there = len(list(loud.vault.glob("*.nonce"))) if loud.draft.exists() else -1
            if there >= cases:
                process.send_signal(signal.SIGKILL)
                break
            time.sleep(0.002)
        kills += process.wait() == -signal.SIGKILL
        if not quiet.vault.exists():
            quiet.vault.mkdir(parents=True)
            shutil.copyfile(loud.draft, quiet.draft)
    before = made(loud)
    assert sealing(loud.root).wait() == 0
    after = made(loud)
    seal.seal(quiet.root, "a-set", SPECS)
    alone = made(quiet)

    assert kills == 3
    for folder in (before, after, alone):
        folder.pop("draft.json", None)
    assert before.items() <= after.items()
    seals = [json.loads(one.pop("sealed.json")) for one in (after, alone)]
    for one in seals:
        one.pop("sealed_utc")
    assert seals[0] == seals[1]
    assert after == alone
    assert len(after) == 3 * len(SPECS)
    seal.check_untouched(loud.root)


def test_what_was_begun_is_not_sealed_as_another(tmp_path):
    """Other cases, or another program, cannot go on with what was drawn."""
    root = tmp_path / "set"
    seal.seal(root, "a-set", SPECS[:1])
    folder = seal.Folder(root)
    with pytest.raises(BadInput, match="not empty"):
        seal.seal(root, "a-set", SPECS[:1])
    shutil.rmtree(root)
    shutil.rmtree(folder.vault)
    seal.draft(folder.draft, "a-set", SPECS[:1], random.SystemRandom())

    with pytest.raises(BadInput, match="begun with another list of cases"):
        seal.seal(root, "a-set", SPECS[:2])
    drawn = json.loads(folder.draft.read_text())
    folder.draft.write_text(json.dumps({**drawn, "solver_sha256": "0" * 64}))
    with pytest.raises(BadInput, match="begun with another solver"):
        seal.seal(root, "a-set", SPECS[:1])


def test_an_opening_that_was_cut_short_goes_on_with_the_answers_it_fixed(tmp_path):
    """Once answers are fixed nobody changes them; opened again, the same truths come out."""
    root = tmp_path / "set"
    seal.seal(root, "a-set", SPECS[:2])
    folder = seal.Folder(root)
    for case in ("case-0001", "case-0002"):
        seal.write_json(folder.report(case), {"findings": [], "examined": {}})
    seal.reveal(root)
    fixed, truth = folder.answers.read_bytes(), folder.opened / "case-0002.truth.json"
    opened = truth.read_bytes()
    truth.unlink()

    assert seal.reveal(root) == 2
    assert (folder.answers.read_bytes(), truth.read_bytes()) == (fixed, opened)
    seal.write_json(folder.report("case-0001"), {"findings": [], "examined": {"seconds": 1}})
    with pytest.raises(BadInput, match="not the one that stood when the set was opened"):
        seal.reveal(root)
