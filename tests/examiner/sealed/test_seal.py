"""Truths are fixed before they are solved; what is changed afterwards is refused."""

import hashlib
import json

import pytest

from pyport.errors import BadInput
from pyport.examiner.sealed import seal
from pyport.examiner.sealed.examine import examine
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.published import read_json


def flip(path):
    """Change one byte of a file."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def test_a_seal_is_sha256_of_nonce_and_truth(sealed):
    """Anyone can check an opened truth by hand: SHA-256 over 32 bytes of nonce and the text."""
    vault = seal.Folder(sealed).vault
    for one in read_json(seal.Folder(sealed).seal)["cases"]:
        nonce = (vault / f"{one['case']}.nonce").read_text()
        truth = (vault / f"{one['case']}.truth.json").read_bytes()

        assert len(bytes.fromhex(nonce)) == 32
        assert hashlib.sha256(bytes.fromhex(nonce) + truth).hexdigest() == one["truth_commitment"]


def test_nothing_that_is_public_tells_the_truth(sealed):
    """Neither names nor headers nor the seal hold the name of what is hidden, or a seed."""
    folder = seal.Folder(sealed)
    public = [folder.seal.read_text(), *(p.read_text() for p in sealed.rglob("*.csv"))]
    for path in folder.vault.glob("*.truth.json"):
        truth = json.loads(path.read_text())
        words = [str(truth["seed"]), *(one["effect"] for one in truth["truth"]["effects"])]

        assert not [word for word in words if word != "unknown" and any(word in p for p in public)]


def test_a_set_is_sealed_once(sealed):
    """Sealing into a folder that holds a set, or whose vault does, is refused."""
    with pytest.raises(BadInput, match="not empty"):
        seal.seal(sealed, "again", [Spec("null", "null", rows=50)])


def test_an_unsolved_set_is_not_opened(sealed):
    """Truths stay in the vault until every case has its answer."""
    with pytest.raises(BadInput, match="13 cases are not solved yet"):
        seal.reveal(sealed)
    assert not seal.Folder(sealed).opened.exists()


def test_a_sealed_set_is_not_scored(answered):
    """There is no score before the opening."""
    with pytest.raises(BadInput, match="still sealed"):
        examine(answered)


def test_one_byte_of_a_truth_is_noticed_at_the_opening(answered):
    """A vault that was touched cannot be opened."""
    flip(seal.Folder(answered).vault / "case-0003.truth.json")

    with pytest.raises(BadInput, match="not the one that was sealed"):
        seal.reveal(answered)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("opened/case-0002.truth.json", "this truth is not the one"),
        ("opened/case-0002.nonce", "this truth is not the one"),
        ("recordings/case-0002.csv", "recordings are not the ones"),
        ("reports/case-0002/report.json", "this report is not the one"),
    ],
)
def test_one_byte_changed_after_the_opening_is_refused(answered, path, message):
    """Truths, nonces, recordings and reports are what they were, or there is no score."""
    seal.reveal(answered)
    flip(answered / path)

    with pytest.raises(BadInput, match=message):
        examine(answered)


def test_another_solver_is_refused(answered):
    """A solver that changed since the sealing gets no score for what the old one said."""
    seal.reveal(answered)
    path = seal.Folder(answered).seal
    path.write_text(json.dumps({**read_json(path), "solver_sha256": "0" * 64}))

    with pytest.raises(BadInput, match="the solver has changed since"):
        examine(answered)


def test_other_thresholds_are_refused(answered):
    """The bar is not moved after the jump."""
    seal.reveal(answered)
    path = seal.Folder(answered).seal
    sealed = json.loads(path.read_text())
    path.write_text(json.dumps({**sealed, "thresholds": {"null_claims_most": 0.5}}))

    with pytest.raises(BadInput, match="thresholds"):
        examine(answered)
