"""The command `pyport dev effects` and the document on the physics."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from pyport.cli.dev.listed import effects as command
from pyport.effects import CATALOGUE, describe
from pyport.errors import BadInput

DOCUMENT = Path(__file__).parents[2] / "docs" / "physics.md"


def run(*arguments):
    """Return what the command prints."""
    return CliRunner().invoke(command, arguments, catch_exceptions=False)


def test_every_effect_is_listed_with_its_sentence():
    """The list has each id and says in a sentence what it is."""
    text = " ".join(run().output.split())

    for effect in CATALOGUE.values():
        assert f"{effect.id}: {effect.sentence}" in text


def test_entry_says_what_an_observer_asks():
    """An entry tells columns, coefficients, known values and what looks alike."""
    text = " ".join(run("annual_aberration", "scan_timing").output.split())

    assert "needs: time_utc, latitude_deg, longitude_deg" in text
    assert "kappa, expected 20.4955" in text
    assert "time_tag [s]" in text
    assert "looks exactly like: scan_direction, with scans at one rate" in text
    assert "half the rate" in text


def test_wrong_name_is_bad_input():
    """A name that is none is refused, with the nearest one."""
    with pytest.raises(BadInput, match="no effect is called 'clok'; did you mean clock"):
        run("clok")


def test_document_is_of_the_whole_catalogue(tmp_path):
    """The document goes to a file whole, and is not made of a part."""
    path = tmp_path / "physics.md"

    assert run("--markdown", "-o", str(path)).output == ""
    assert path.read_text() == describe.markdown()
    assert run("--markdown", "tilt").exit_code == 2


def test_document_is_not_stale():
    """The document in the repository is what the catalogue says now: `make physics` writes it."""
    assert DOCUMENT.read_text(encoding="utf-8") == describe.markdown()
