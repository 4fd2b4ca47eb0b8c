"""A fault of the program: one line, a report to send, exit status 70."""

import sys

import click
import pytest

from pyport import cli


def end(monkeypatch, raises, *words):
    """Run a command line whose work raises; return the status that it ends with."""

    def fail(*_, **__):
        raise raises

    monkeypatch.setattr(cli.pyport, "invoke", fail)
    monkeypatch.setattr(sys, "argv", ["pyport", *words])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    return ended.value.code


@pytest.mark.parametrize(
    "error",
    [ZeroDivisionError("by\nzero"), MemoryError(), RecursionError("deep"), EOFError(), KeyError(1)],
    ids=lambda error: type(error).__name__,
)
def test_fault_is_one_line_and_a_report(monkeypatch, tmp_path, capsys, error):
    """Whatever is raised: one line that names the report, which has command and traceback."""
    monkeypatch.chdir(tmp_path)

    assert end(monkeypatch, error, "fit", "a night.csv") == 70
    (report,) = tmp_path.iterdir()
    text, said = report.read_text(), capsys.readouterr().err.strip()
    assert said.splitlines() == [said]
    assert report.name in said
    assert type(error).__name__ in said
    for part in ("pyport fit 'a night.csv'", "Traceback", "numpy", "Python 3"):
        assert part in text


def test_report_goes_elsewhere_from_a_folder_that_cannot_be_written(monkeypatch, tmp_path, capsys):
    """In a folder that is gone the report goes to the temporary one."""
    gone, temporary = tmp_path / "gone", tmp_path / "temporary"
    gone.mkdir()
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    monkeypatch.chdir(gone)
    gone.rmdir()

    assert end(monkeypatch, RuntimeError("?"), "look", "x") == 70
    assert str(next(temporary.iterdir())) in capsys.readouterr().err


@pytest.mark.parametrize(("error", "status"), [(KeyboardInterrupt(), 130), (click.Abort(), 130)])
def test_interruption_is_no_fault(monkeypatch, tmp_path, error, status):
    """A key that interrupts leaves no report."""
    monkeypatch.chdir(tmp_path)

    assert end(monkeypatch, error, "look", "x") == status
    assert not list(tmp_path.iterdir())
