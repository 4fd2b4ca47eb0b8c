"""The manual's table of signs is what the program prints, and its commands do what it says."""

import re
from pathlib import Path

from click.testing import CliRunner
from samples import sample

from pyport.cli.correct import convert
from pyport.cli.dev.recorded import field_system
from pyport.formats.convert import FORMATS

PAGE = Path(__file__).parents[2] / "docs" / "formats.md"


def test_the_table_of_signs_is_what_the_command_prints():
    """Between its two marks stands `pyport convert --signs`, character for character."""
    _, _, rest = PAGE.read_text(encoding="utf-8").partition("<!-- signs -->\n")
    shown, _, _ = rest.partition("<!-- /signs -->")

    printed = CliRunner().invoke(convert, ["--signs"])

    assert printed.exit_code == 0
    assert shown == printed.output


def test_the_help_names_every_format():
    """What --from and --to take."""
    printed = CliRunner().invoke(convert, ["--help"]).output
    # a line of help may end within a name, behind its hyphen
    shown = re.sub(r"-\n *", "-", printed).split("--to: ")[1].split(".")[0]

    assert shown.replace(",", "").split() == list(FORMATS)


def test_an_unknown_format_is_refused_with_the_known_ones():
    """A mistyped name is answered with what there is."""
    done = CliRunner().invoke(convert, ["a.csv", "b.csv", "--to", "tpiont"])

    assert done.exit_code == 2
    assert "tpoint-dat" in done.output


def test_signs_conversions_and_agreement_are_printed(tmp_path):
    """The commands of the manual, on files made here."""
    (tmp_path / "a.mod").write_text("mine\nT 1 1 0 0\n  IA  +36.0\n  HSCE3  1.0\nEND\n")
    target = str(tmp_path / "a.ctl")

    refused = CliRunner().invoke(convert, [str(tmp_path / "a.mod"), target])
    done = CliRunner().invoke(convert, [str(tmp_path / "a.mod"), target, "--leave-out"])

    assert "no counterpart of HSCE3" in str(refused.exception)
    assert "1 terms as fs-ctl" in done.output
    assert "HSCE3" in done.output


def test_the_agreement_is_one_command():
    """`pyport dev field-system`: every parameter at both angles, and both fits."""
    folder = sample("field_system/mdlpo.ctl").parent

    printed = CliRunner().invoke(field_system, [str(folder)], catch_exceptions=False).output

    assert "phi = 90 deg" in printed
    assert "phi = 35 deg" in printed
    assert printed.count("correlations: largest difference") == 2
    worst = float(printed.split("worst of all: ")[1].split()[0])
    assert worst < 1e-10


def test_a_folder_without_outputs_is_refused(tmp_path):
    """With what was expected."""
    done = CliRunner().invoke(field_system, [str(tmp_path)])

    assert "neither fs_fln_flt_grid.csv nor a pair" in str(done.exception)
