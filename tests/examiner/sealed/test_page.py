"""The public record shows what was scored, and lets a reader check one case from seal to answer."""

import hashlib
import json
import re
import shlex

import pytest
from click.testing import CliRunner

from pyport.cli.dev.trials import command
from pyport.examiner.sealed import page, seal
from pyport.examiner.sealed.examine import examine
from pyport.examiner.sealed.published import read_json
from pyport.files import sha256


@pytest.fixture
def record(answered, tmp_path):
    """Return the page of a set whose answers are all right."""
    seal.reveal(answered)
    examine(answered)
    out = tmp_path / "docs" / "proof.md"
    page.write([answered], out)
    return out


def test_the_page_holds_the_table_and_its_pictures(record):
    """Every picture that the page shows is there, and is a picture."""
    text = record.read_text(encoding="utf-8")
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", text)

    assert "## a-set: passed" in text
    assert "| two causes: both found | 100.0 % (1 of 1; 20.7 to 100.0) |" in text
    assert len(pictures) >= 2
    for picture in pictures:
        assert (record.parent / picture).read_bytes().startswith(b"\x89PNG")


def test_one_case_can_be_checked_by_hand(record, tmp_path, monkeypatch):
    """The five commands give the hashes that the page says they give."""
    text = record.read_text(encoding="utf-8")
    seal_line, truth_line, make_line, made_line, solve_line = (
        re.search(r"```\n(.*?)```", text, re.DOTALL).group(1).strip().splitlines()
    )
    promised = re.findall(r"`([0-9a-f]{64})`", text)
    monkeypatch.chdir(tmp_path)
    nonce, truth = re.search(r"-p (\S+); cat (\S+)\)", truth_line).groups()
    done = CliRunner().invoke(command, shlex.split(make_line)[3:])
    bare = bytes.fromhex((tmp_path / nonce).read_text()) + (tmp_path / truth).read_bytes()

    assert done.exit_code == 0, done.output
    assert sha256(seal_line.split()[1]) == promised[0]
    assert hashlib.sha256(bare).hexdigest() == promised[1]
    assert sha256(made_line.split()[1]) == promised[2]
    assert made_line.split()[1] in solve_line


def test_wrong_answers_are_shown(answered, tmp_path):
    """A confident wrong name stands on the page with what was hidden."""
    folder = seal.Folder(answered)
    for one in read_json(folder.seal)["cases"]:
        report = {"effect": "drift", "class": ["drift"], "verdict": "named", "where": {}}
        content = {"mismatch": True, "p_value": 0.0, "findings": [report], "examined": {}}
        folder.report(one["case"]).write_text(json.dumps(content))
    seal.reveal(answered)
    examine(answered)
    page.write([answered], tmp_path / "proof.md")
    text = (tmp_path / "proof.md").read_text(encoding="utf-8")

    assert "## a-set: not passed" in text
    assert "hidden azimuth_harmonics at rho 1, said drift" in text
