"""A proof is three commits, and every way to forge one is noticed from the history alone."""

import json
import shutil
import subprocess
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from click.testing import CliRunner

from pyport.cli.dev.proof import prove as command
from pyport.errors import BadInput
from pyport.examiner.sealed import solve
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.prove import Plan, advance, read_lines, write_lines
from pyport.examiner.sealed.record import code
from pyport.examiner.sealed.verify import alike, verify

# a proof in a repository, and copies of it that are forged: some seconds
pytestmark = pytest.mark.slow

SPECS = [Spec("null", "null", rows=60, noise="white"), Spec("one", "one", "sag_sine", 1.0, 60)]


def git(root, *words):
    """Call git in a repository, as somebody."""
    somebody = ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]
    done = subprocess.run(
        [shutil.which("git"), "-C", str(root), *somebody, *words],
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def commit(root, *paths):
    """Commit some files alone."""
    git(root, "add", *map(str, paths))
    git(root, "commit", "-qm", "next")


def plan(root):
    """Return a small proof in a repository."""
    return Plan("a-set", root / "docs" / "sets" / "a-set", root / "out" / "a-set", lambda: SPECS)


@pytest.fixture(scope="module", autouse=True)
def units():
    """Let two files stand for the program, and one for its examiner: quick to unpack and read."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(code, "SOLVER", code.Unit(("thresholds", "angles")))
        patch.setattr(code, "EXAMINER", code.Unit(("examiner.scores",)))
        yield


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """Return a repository with the examiner and a proof in its history, made once."""
    root = tmp_path_factory.mktemp("proof") / "repository"
    skipped = shutil.ignore_patterns("__pycache__")
    shutil.copytree(code.PACKAGE / "examiner", root / "pyport" / "examiner", ignore=skipped)
    (root / "pyport" / "runs").mkdir()
    for name in (
        "__init__",
        "angles",
        "errors",
        "files",
        "runs/__init__",
        "runs/stages",
        "thresholds",
    ):
        shutil.copy(code.PACKAGE / f"{name}.py", root / "pyport" / f"{name}.py")
    (root / ".gitignore").write_text("out/\n")
    git(root.parent, "init", "-q", str(root))
    commit(root, ".gitignore", "pyport")
    git(root, "tag", "before")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent))
        patch.setattr(solve, "run", partial(solve.run, solver=("fake_solver", "parrot")))
        for stage in (1, 2, 3):
            step = advance(plan(root))
            assert step.stage == stage
            assert advance(plan(root)) == step, "it waits for the commit"
            commit(root, *step.commit)
    assert advance(plan(root)).commit == ()
    return root


@pytest.fixture
def copy(proved, tmp_path):
    """Return a copy of it, to be forged."""
    shutil.copytree(proved, tmp_path / "copy")
    return tmp_path / "copy"


def failed(root, again=0):
    """Return what of a proof does not hold."""
    return [one.what for one in verify(plan(root).place, again) if not one.passed]


def rewrite(root, name, change):
    """Change the lines of a compressed file."""
    path = plan(root).place / name
    lines = read_lines(path.read_bytes())
    change(lines)
    write_lines(path, lines)
    return path


SEAL, ANSWERS = ["sealed.json"], ["answers.jsonl.xz"]
OPEN = ["opened.jsonl.xz", "score.json", "verdicts.jsonl.xz"]


def recommit(root, *stages):
    """Write the history anew: commit the files as they lie there now, stage by stage."""
    git(root, "reset", "-q", "before")
    for names in stages:
        commit(root, *(root / name if "/" in name else plan(root).place / name for name in names))


def test_a_proof_holds(proved):
    """Every check passes, with every recording made and every answer judged again."""
    checks = [*verify(plan(proved).place, None)]

    assert [one.what for one in checks if not one.passed] == []
    assert {"recordings made again are those sealed", "score computed again: table"} <= {
        one.what for one in checks
    }


def test_the_command_says_yes_to_each_check_and_no_by_its_status(proved, copy):
    """Exit status 1 for a forged one."""
    words = ["--verify", "a-set", "--again", "0", "--sets"]
    good = CliRunner().invoke(command, [*words, str(plan(proved).place.parent)])
    commit(copy, rewrite(copy, "opened.jsonl.xz", lambda lines: lines[1].update(nonce="00")))
    bad = CliRunner().invoke(command, [*words, str(plan(copy).place.parent)])

    assert (good.exit_code, bad.exit_code) == (0, 1)
    assert "NO" not in good.output
    assert "NO   opened.jsonl.xz was never changed" in bad.output


def test_a_truth_changed_in_a_later_commit_is_noticed(copy):
    """Each file has one commit."""
    path = rewrite(copy, "opened.jsonl.xz", lambda lines: lines[1].update(truth="{}"))
    commit(copy, path)

    assert failed(copy) == ["opened.jsonl.xz was never changed"]


def test_a_truth_changed_before_its_commit_is_noticed(copy):
    """It is not the one that was sealed, though the history is in order."""
    rewrite(copy, "opened.jsonl.xz", lambda lines: lines[1].update(truth=lines[2]["truth"]))
    recommit(copy, SEAL, ANSWERS, OPEN)

    assert failed(copy) == ["truths are those sealed"]


def test_an_answer_changed_after_the_opening_is_noticed(copy):
    """In a commit of its own, and in a history that was written anew."""

    def better(lines):
        lines[1]["report"]["findings"] = []

    commit(copy, rewrite(copy, "answers.jsonl.xz", better))
    assert failed(copy) == ["answers.jsonl.xz was never changed"]

    recommit(copy, SEAL, ANSWERS, OPEN)
    assert failed(copy) == ["the opening names the answers"]


def test_a_seal_amended_after_the_answers_is_noticed(copy):
    """In a commit of its own, and in a history that was written anew."""
    path = plan(copy).place / "sealed.json"
    sealed = json.loads(path.read_text())
    sealed["thresholds"]["null_claims_most"] = 0.5
    path.write_text(json.dumps(sealed))
    commit(copy, path)
    assert failed(copy) == ["sealed.json was never changed"]

    recommit(copy, SEAL, ANSWERS, OPEN)
    assert failed(copy) == ["the answers name the seal"]


@pytest.mark.parametrize(
    ("stages", "what"),
    [
        ((ANSWERS, SEAL, OPEN), "sealed, then answered, then opened"),
        ((SEAL, OPEN, ANSWERS), "sealed, then answered, then opened"),
        (([*SEAL, *ANSWERS], OPEN), "sealed, then answered, then opened"),
        (([*SEAL, *OPEN], ANSWERS), "seal: the set holds no more by then"),
        (([*SEAL, "pyport/new.py"], ANSWERS, OPEN), "seal: a commit of its own"),
        ((["pyport/thresholds.py"], SEAL, ANSWERS, OPEN),
         "the solver is that of the sealing commit"),
        ((["pyport/examiner/scores.py"], SEAL, ANSWERS, OPEN),
         "the examiner is that of the sealing commit"),
    ],
)  # fmt: skip
def test_commits_in_another_order_or_with_more_in_them_are_noticed(copy, stages, what):
    """Answers before the seal or with it, truths with it, another program beside it or before."""
    for name in ("new.py", "thresholds.py", "examiner/scores.py"):
        with (copy / "pyport" / name).open("a") as file:
            file.write("\nMORE = 1\n")
    recommit(copy, *stages)

    assert what in failed(copy)


def test_a_score_that_the_answers_do_not_give_is_noticed(copy):
    """A verdict, and whether it passed, changed before their commit."""
    rewrite(copy, "verdicts.jsonl.xz", lambda lines: lines[0].update(said="right"))
    path = plan(copy).place / "score.json"
    path.write_text(path.read_text().replace('"passed": false', '"passed": true', 1))
    recommit(copy, SEAL, ANSWERS, OPEN)

    assert failed(copy, None) == [
        "verdicts judged again are those published",
        "score computed again: passed",
    ]


def test_answers_are_committed_before_anything_is_open(copy):
    """Going on without the commit only says again what to commit."""
    shutil.rmtree(plan(copy).place)
    git(copy, "reset", "-q", "--hard", "before")
    again = replace(plan(copy), work=copy / "out" / "another")
    step = advance(again)

    assert (step.stage, [one.name for one in step.commit]) == (1, ["sealed.json"])
    assert advance(again) == step
    assert {one.name for one in again.place.iterdir()} == {"sealed.json"}


def test_a_set_that_was_never_published_is_no_proof(copy):
    """It is said what is missing."""
    with pytest.raises(BadInput, match=r"the history has no sealed\.json"):
        next(verify(plan(copy).place.with_name("other"), 0))


def test_numbers_of_verdicts_agree_to_a_millionth():
    """Other machines have other last digits; words and counts have none."""
    one = {"said": "drift", "skill": [1.0, 2.0], "place": {"curve_deg": None}}

    assert alike(one, {**one, "skill": [1.0 + 1e-9, 2]})
    assert not alike(one, {**one, "skill": [1.1, 2.0]})
    assert not alike(one, {**one, "said": "sag"})
    assert not alike(one, None)
