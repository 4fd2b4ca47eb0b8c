"""The manual's table of signs is what the program prints."""

from pathlib import Path

from click.testing import CliRunner

from pyport.cli.convert import command

PAGE = Path(__file__).parents[2] / "docs" / "formats.md"


def test_the_table_of_signs_is_what_the_command_prints():
    """Between its two marks stands `pyport convert --signs`, character for character."""
    _, _, rest = PAGE.read_text(encoding="utf-8").partition("<!-- signs -->\n")
    shown, _, _ = rest.partition("<!-- /signs -->")

    printed = CliRunner().invoke(command, ["--signs"])

    assert printed.exit_code == 0
    assert shown == printed.output
