"""The public record is made of what was published, and says of which program it speaks."""

import json
import re
from dataclasses import asdict
from pathlib import Path

import pytest

from pyport.cli.dev.listed import put_between
from pyport.examiner.sealed import seal
from pyport.examiner.sealed.examine import examine
from pyport.examiner.sealed.prove import read_lines, write_lines
from pyport.examiner.sealed.scoring import page

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"


def publish(root, docs):
    """Open a set, score it, and publish it as a proof is; the baselines got the same score."""
    folder = seal.Folder(root)
    seal.reveal(root)
    whole = examine(root)
    place = docs / "proof" / "sets" / root.name
    place.mkdir(parents=True)
    (place / "sealed.json").write_bytes(folder.seal.read_bytes())
    opened = [
        {"case": path.name.partition(".")[0], "nonce": path.with_name(
            f"{path.name.partition('.')[0]}.nonce").read_text(), "truth": path.read_text()}
        for path in sorted(folder.opened.glob("*.truth.json"))
    ]  # fmt: skip
    scored = json.loads((root / "score.json").read_text())
    rows = [asdict(row) for row in whole.rows]
    write_lines(place / "answers.jsonl.xz", [{}])
    write_lines(place / "opened.jsonl.xz", [{}, *opened])
    write_lines(place / "verdicts.jsonl.xz", scored["verdicts"])
    kept = {key: scored[key] for key in ("name", "passed", "table")}
    (place / "score.json").write_text(json.dumps({**kept, "beside": {"bic": rows, "lasso": []}}))
    return place


@pytest.fixture
def record(answered, tmp_path):
    """Return the folder of the manual with a set whose answers are all right, and the page."""
    docs = tmp_path / "docs"
    publish(answered, docs)
    return docs, page.proof(page.published(docs / "proof" / "sets"), docs)


@pytest.mark.slow
def test_the_page_holds_the_table_and_its_pictures(record):
    """The baselines stand beside the program; every picture is there, and is a picture."""
    docs, text = record
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", text)
    perfect = "100.0 % (1 of 1; 20.7 to 100.0)"

    assert "## a-set: passed" in text
    assert f"| two causes: both found | at least 70 % | {perfect} | {perfect} | - | yes |" in text
    assert len(pictures) >= 2
    for picture in pictures:
        assert (docs / picture).read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_form_without_a_name_stands_beside_what_is_most_like_it(record):
    """How it was answered, and how much of it a name could take, as a cosine."""
    _, text = record
    found = re.findall(r"^\| \w+ \| 1 \| 1 \| 0 \| - \| (\S+) \(", text, re.MULTILINE)

    assert found
    assert all(0 < float(cosine) <= 1 for cosine in found)


@pytest.mark.slow
def test_every_truth_can_be_checked_by_hand(record, tmp_path, monkeypatch):
    """The lines of Python on the page hold as they stand, and not after a truth was changed."""
    docs, text = record
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL).group(1)
    monkeypatch.chdir(tmp_path)
    exec(code, {})  # noqa: S102 - the page's

    path = docs / "proof" / "sets" / "a-set" / "opened.jsonl.xz"
    head, first, *rest = read_lines(path.read_bytes())
    write_lines(path, [head, {**first, "truth": rest[0]["truth"]}, *rest])
    with pytest.raises(AssertionError):
        exec(code, {})  # noqa: S102 - the page's


@pytest.mark.slow
def test_wrong_answers_are_shown(answered, tmp_path):
    """A confident wrong name stands on the page with what was hidden, or that nothing was."""
    folder = seal.Folder(answered)
    for one in json.loads(folder.seal.read_text())["cases"]:
        report = {"effect": "drift", "class": ["drift"], "verdict": "named", "where": {}}
        content = {"mismatch": True, "p_value": 0.0, "findings": [report], "examined": {}}
        folder.report(one["case"]).write_text(json.dumps(content))
    publish(answered, tmp_path)
    text = page.proof(page.published(tmp_path / "proof" / "sets"), tmp_path)

    assert "## a-set: not passed" in text
    assert "hidden azimuth_harmonics at rho 1, said drift" in text
    assert "(null): nothing hidden, said drift" in text
    assert "(zero): nothing hidden, said drift" in text


@pytest.mark.slow
def test_the_ledger_has_every_set_and_how_far_it_came(record):
    """Sealed and opened; sealed alone."""
    docs, _ = record
    place = docs / "proof" / "sets"
    (place / "later").mkdir()
    sealed = json.loads((place / "a-set" / "sealed.json").read_text())
    later = {**sealed, "name": "later", "sealed_utc": "2999-01-01T00:00:00+00:00"}
    (place / "later" / "sealed.json").write_text(json.dumps(later))
    sets = page.published(place)
    text = page.ledger(sets)

    assert [one.sealed["name"] for one in sets] == ["a-set", "later"]
    assert text.index("### Score of a-set: passed") < text.index("## later")
    assert text.rstrip().endswith("Not opened yet.")
    assert page.last(sets) is sets[0]


@pytest.mark.slow
def test_a_program_that_has_moved_on_is_said_to_have(record):
    """The words change with the program's hash, and what changed is printed."""
    docs, _ = record
    (now,) = page.published(docs / "proof" / "sets")
    parts = {**now.sealed["solver_parts"], "pipeline.py": "0" * 64}
    then = page.Published(
        now.folder, {**now.sealed, "solver_sha256": "1" * 64, "solver_parts": parts}, now.score
    )

    assert "which is this version" in page.program(now)
    assert page.program(then) == "program `1111111111111111`, which has changed since"
    assert "changed: pipeline.py" in seal.moved_on(then.sealed, "solver")


def test_readme_and_proof_say_of_which_program_they_speak():
    """When the program has moved on they say so: `pyport dev trials page` writes them anew."""
    sets = page.published(DOCS / "proof" / "sets")
    one = page.last(sets)
    changed = seal.moved_on(one.sealed, "solver") if one else ""
    readme, proof = (path.read_text("utf-8") for path in (ROOT / "README.md", DOCS / "proof.md"))

    assert put_between(readme, "proof", page.readme(sets)) == readme, changed
    assert page.program(one) in proof, changed


def test_the_manual_s_page_is_that_of_the_last_set():
    """Nobody writes into it by hand."""
    sets = page.published(DOCS / "proof" / "sets")
    text = (DOCS / "proof.md").read_text("utf-8")
    book = (DOCS / "proof" / "ledger.md").read_text("utf-8")

    assert text.startswith(page.proof([], DOCS).partition("\n## No set")[0])
    assert put_between(book, "sets", page.ledger(sets)) == book
