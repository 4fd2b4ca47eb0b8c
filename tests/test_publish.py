"""What is published: metadata, the long description, licence files, the check of the site."""

import re
import runpy
import tomllib
from pathlib import Path

import pytest

import pyport

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def faults():
    """Return the function that finds what is wrong with a built site."""
    return runpy.run_path(str(ROOT / "docs" / "check_site.py"))["faults"]


def described():
    """Return the README as the build makes the long description of it."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    hook = PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]
    for one in hook["substitutions"]:
        text = re.sub(one["pattern"], one["replacement"], text)
    return text


def test_the_long_description_has_no_picture_and_no_link_that_leads_nowhere():
    """The package index shows no file of the archive: what names one is text."""
    text = described()
    links = re.findall(r"\]\(([^)]*)\)", text)

    assert all(link.startswith("https://") for link in links), links
    assert "![" not in text
    assert "<!-- pictures -->" not in text
    assert "method (`docs/method.md`)" in text


def test_every_other_word_of_the_readme_is_in_the_long_description():
    """Leaving out the pictures leaves out no text beside them."""
    text = described()

    assert text.startswith("# pyport\n")
    for heading in re.findall(
        r"^## .*$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE
    ):
        assert heading in text


def test_the_versions_agree():
    """The package, its metadata, the citation and the changelog name one version."""
    version = PROJECT["project"]["version"]

    assert pyport.__version__ == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## {version}\n" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_extra_all_is_all_that_a_user_may_want():
    """It holds the other extras of a user by their names."""
    project = PROJECT["project"]

    assert project["optional-dependencies"]["all"] == [f"{project['name']}[notebook,dask,serve]"]


def test_the_notice_names_every_file_that_is_not_ours():
    """The routines in print, one by one, and whose they are."""
    notice = (ROOT / "NOTICE").read_text(encoding="utf-8")

    assert "K. M. Borkowski" in notice
    for routine in (ROOT / "legacy_fortran" / "published").iterdir():
        assert routine.name in notice
    assert PROJECT["project"]["license-files"] == ["LICENSE", "NOTICE"]


def test_the_wheel_holds_what_links_in_the_source_tree_lead_to():
    """A build follows no link: each is named, with the folder that it leads to."""
    links = [one for one in (ROOT / "pyport").rglob("*") if one.is_symlink()]
    named = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]

    assert {
        one.resolve().relative_to(ROOT).as_posix(): one.relative_to(ROOT).as_posix()
        for one in links
    } == named


def test_a_sound_site_has_no_fault(tmp_path, faults):
    """Links to files and anchors of the site, links to other sites, pictures in the page itself."""
    (tmp_path / "other.html").write_text('<h1 id="there">x</h1>', encoding="utf-8")
    (tmp_path / "index.html").write_text(
        '<a href="other.html#there">x</a><a href="https://example.org">x</a>'
        '<img src="data:image/png;base64,AAAA">',
        encoding="utf-8",
    )

    assert faults(tmp_path) == []


@pytest.mark.parametrize(
    ("html", "fault"),
    [
        ('<a href="gone.html">x</a>', "leads to no file"),
        ('<a href="#gone">x</a>', "leads to no such place"),
        ('<img src="gone.png">', "leads to no file"),
        ('<script src="https://example.org/a.js"></script>', "from elsewhere"),
        ('<link rel="stylesheet" href="//example.org/a.css">', "from elsewhere"),
    ],
)
def test_a_fault_of_the_site_is_found(tmp_path, faults, html, fault):
    """A link that leads nowhere, and what a browser would fetch from another site."""
    (tmp_path / "index.html").write_text(html, encoding="utf-8")

    (line,) = faults(tmp_path)

    assert fault in line


def test_a_font_from_elsewhere_is_found(tmp_path, faults):
    """A style sheet that fetches a font."""
    (tmp_path / "a.css").write_text("@font-face {src: url('https://example.org/a')}")

    assert faults(tmp_path) == ["a.css: loads from elsewhere"]
