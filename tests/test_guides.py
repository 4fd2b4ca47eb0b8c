"""The manual's guides: their Python runs, their commands exist with the options that they show."""

import re
from pathlib import Path

import click
import pytest

from pyport.cli import pyport

DOCS = Path(__file__).parent.parent / "docs"
GUIDES = (
    "how-to.md",
    "page.md",
    "models.md",
    "from-fortran.md",
    "from-tpoint.md",
    "from-field-system.md",
)
#: A command in a fence or between backticks, up to its end.
_COMMAND = re.compile(r"(?:^|`)(pyport [a-z][^`\n]*)", re.MULTILINE)


def commands():
    """Return every command that a guide shows."""
    found = []
    for guide in GUIDES:
        text = (DOCS / guide).read_text(encoding="utf-8").replace(" \\\n", " ")
        found += [(guide, " ".join(one.split())) for one in _COMMAND.findall(text)]
    return found


@pytest.mark.parametrize(("guide", "line"), commands(), ids=lambda one: one[:60])
def test_commands_of_the_guides_exist_with_their_options(guide, line):
    """Each is a command of pyport's, and every option in it is one that the command has."""
    words = line.split()[1:]
    command = pyport
    for word in words:
        if isinstance(command, click.Group) and not word.startswith("-"):
            command = command.get_command(click.Context(command), word)
            assert command is not None, (guide, line)
    options = {flag for one in command.params for flag in one.opts} | {"--help"}
    used = {word.split("=")[0] for word in words if re.match(r"--?[a-z]", word)}

    assert used <= options, (guide, line)


@pytest.mark.slow
@pytest.mark.parametrize("guide", GUIDES)
def test_python_of_the_guides_runs(guide):
    """The blocks of a guide run one after the other, as a reader would type them."""
    text = (DOCS / guide).read_text(encoding="utf-8")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(compile(block, guide, "exec"), names)  # noqa: S102 - our own manual


@pytest.mark.parametrize("guide", GUIDES)
def test_links_of_the_guides_lead_somewhere(guide):
    """Every relative link is to a file that is there."""
    text = (DOCS / guide).read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text)

    assert all((DOCS / link).is_file() for link in links if "://" not in link)


def test_the_routines_of_the_guide_and_the_arrays_agree():
    """What the guide calls by both ways is the same offset to a step of a REAL*4 near a turn."""
    text = (DOCS / "from-fortran.md").read_text(encoding="utf-8")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(compile(block, "from-fortran.md", "exec"), names)  # noqa: S102 - our own manual
    np, real = names["np"], names["real"]
    old = names["model"](real(-1.75), real(0.52), names["p"])
    new = names["exact_offsets"](
        np.array([float(real(-1.75))]), np.array([float(real(0.52))]), names["printed"]()
    )

    np.testing.assert_allclose(np.degrees(new).ravel(), old, atol=2**-15)
