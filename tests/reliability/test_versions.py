"""What pyproject.toml promises, what is locked, and what is tested as the lowest."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

HOUSE = Path(__file__).parents[2]
PROJECT = tomllib.loads((HOUSE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCKED = (HOUSE / ".ci" / "requirements.lock").read_text(encoding="utf-8")
LOWEST = (HOUSE / ".ci" / "lowest.txt").read_text(encoding="utf-8")


def requirements(*groups):
    """Return what the program needs, and what some of its extras do."""
    extras = [one for group in groups for one in PROJECT["optional-dependencies"][group]]
    return [Requirement(one) for one in [*PROJECT["dependencies"], *extras]]


def pinned(text):
    """Return the versions that stand in a file of `name==version`, by name."""
    found = {}
    for name, version in re.findall(r"^([\w.-]+)==(\S+)", text, re.MULTILINE):
        found.setdefault(canonicalize_name(name), []).append(Version(version))
    return found


@pytest.mark.parametrize("wanted", requirements("test", "lint"), ids=str)
def test_what_is_needed_is_locked(wanted):
    """Every requirement has a locked version that fulfils it; after a change: make lock."""
    versions = pinned(LOCKED).get(canonicalize_name(wanted.name), [])

    assert versions
    assert all(wanted.specifier.contains(one) for one in versions)


def test_everything_locked_has_a_hash():
    """No line of the lock trusts a name and a version alone."""
    entries = re.split(r"^(?=[\w.-]+==)", LOCKED, flags=re.MULTILINE)[1:]

    assert len(entries) > 50
    assert all("--hash=sha256:" in one for one in entries)


@pytest.mark.parametrize("wanted", requirements(), ids=str)
def test_the_lowest_version_that_is_promised_is_the_one_tested(wanted):
    """`name>=version` in pyproject.toml is `name==version` where tox tests the lowest."""
    (floor,) = wanted.specifier
    (tested,) = pinned(LOWEST)[canonicalize_name(wanted.name)]

    assert floor.operator == ">="
    # of date-like versions the file has a day's data, the promise its first part
    assert tested.release[: len(Version(floor.version).release)] == Version(floor.version).release
