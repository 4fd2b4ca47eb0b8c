"""The manual's guides: their Python runs, their commands exist with the options that they show."""

import re
from pathlib import Path

import click
import pytest

from pyport import pipeline
from pyport.cli import pyport
from pyport.steering.published import write_recordings

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


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """Return what the diagnoses print that README and manual quote."""
    extracts = tmp_path_factory.mktemp("quoted") / "published.csv"
    write_recordings(extracts)
    asked = [
        ("gmrt-cyg-a", "gmrt-paper", "all"),
        ("gmrt-2003-06-01", "gmrt-paper", "all"),
        (str(extracts), "rt32-3model", "none"),
    ]
    return "".join(
        pipeline.run_one(one).summary + "\n"
        for name, model, refit in asked
        for one in pipeline.requests([name], model=model, refit=refit, seed=0, out=None)
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    ["README.md", "docs/steering-table.md", "docs/proof/gmrt.md", "docs/proof/published-table.md"],
)
def test_findings_that_are_quoted_are_those_that_the_program_prints(page, printed):
    """Every line of a quoted diagnosis, commands and omissions apart, is printed today."""
    text = (DOCS.parent / page).read_text(encoding="utf-8")
    blocks = [one for one in re.findall(r"```\n(.*?)```", text, re.DOTALL) if "\n   " in one]
    found = [one for one in blocks if re.search(r"^\d\. \w", one, re.MULTILINE)]
    lines = {one for block in found for one in block.splitlines() if one[:2] not in ("$ ", "..")}

    assert lines
    assert lines <= set(printed.splitlines())


@pytest.mark.slow
def test_the_figures_below_the_picture_of_the_readme_are_printed(printed):
    """How many antennas play, and what the held-out rms falls from and to."""
    text = " ".join((DOCS.parent / "README.md").read_text(encoding="utf-8").split())
    antennas, after, before = re.search(
        r"finds it in (\d+ of \d+) antennas, .* to (\d+) arcsec rms instead of (\d+),", text
    ).groups()

    assert f"({antennas} beyond three sigmas)" in printed
    assert f"rms per axis {before} -> {after}." in printed
