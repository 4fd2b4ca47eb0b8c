"""The published text is kept as printed, and the patches change only what they say."""

import hashlib
from pathlib import Path

import pytest

from pyport.parity.compiled.build import PatchDoesNotApply, patched

FORTRAN = Path(__file__).parents[2] / "legacy_fortran"
PATCHES = sorted((FORTRAN / "patches").glob("*.patch"))


def test_published_text_has_its_checksums():
    """Each published file has the recorded SHA-256."""
    recorded = dict(reversed(row.split()) for row in (FORTRAN / "SHA256SUMS").open())
    actual = {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in (FORTRAN / "published").iterdir()
    }

    assert recorded == actual


def test_restored_lines_of_hjump_join_to_the_printed_one():
    """Hjump's restored lines, joined with blanks, are the line that the page shows."""
    source = FORTRAN / "published" / "hjump.f"
    lines = patched(source, PATCHES).splitlines()

    assert " ".join(line.strip("\t") for line in lines) == source.read_text().strip()


def test_types_patches_only_convert_arguments():
    """Without the conversions that the patches add, Model is the published text again."""
    source = FORTRAN / "published" / "model.f"
    text = patched(source, PATCHES)

    assert text != source.read_text()
    for name in ("Alt", "dAz"):
        text = text.replace(f"dble({name})", name)
    assert text == source.read_text()


def test_modela_needs_no_patch():
    """ModelA compiles as it was printed."""
    source = FORTRAN / "published" / "modela.f"

    assert patched(source, PATCHES) == source.read_text()


@pytest.mark.parametrize("wrong", [" one\n", "one\n\n", "two\n", ""])
def test_patch_with_other_context_does_not_apply(tmp_path, wrong):
    """A patch whose context differs by a blank or a line is refused, with its line."""
    source = tmp_path / "a.f"
    source.write_text(wrong + "tail\n")
    patch = tmp_path / "1.patch"
    patch.write_text("--- a.f\n+++ a.f\n@@ -1,2 +1,2 @@\n-one\n+1\n tail\n")

    with pytest.raises(PatchDoesNotApply, match=r"1\.patch: line [46]"):
        patched(source, [patch])
