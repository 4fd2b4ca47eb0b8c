"""The command `pyport parity`."""

import json

import pytest
from click.testing import CliRunner

from pyport.cli.parity import command
from pyport.errors import BadInput
from pyport.parity import answers, run
from pyport.parity.progress import kept_beside


@pytest.mark.oracle
def test_live_run_covers_table_edges_and_random_points(oracle):
    """With the oracle the ports are asked at the whole table, the edges and the random points."""
    assert oracle

    result = CliRunner().invoke(command, ["--points", "6000", "--json"], catch_exceptions=False)
    content = json.loads(result.output)

    assert content["source"] == "live"
    assert content["points"]["table"] == 51395
    assert content["points"]["random"] == 6000
    assert {c["points"] for c in content["legacy"]} == {sum(content["points"].values())}
    assert content["bit_for_bit"]
    assert content["promise_kept"]


@pytest.mark.usefixtures("same_library")
def test_without_the_oracle_stored_answers_serve(monkeypatch, tmp_path):
    """Without a compiler the stored answers hold the port; the report is a page of Markdown.

    What a run kept that was killed before it is removed.
    """
    monkeypatch.setattr(run, "find_oracle", lambda: None)
    path = tmp_path / "parity.md"
    kept_beside(str(path), 20_000, 0).write_bytes(b"half")

    result = CliRunner().invoke(command, ["--report", str(path)], catch_exceptions=False)

    assert "Against the oracle's stored answers" in result.output
    assert "equals the published program bit for bit" in result.output
    assert path.read_text().startswith("# Is the port the program that was published?")
    assert [one.name for one in tmp_path.iterdir()] == ["parity.md"]


def test_missing_oracle_is_an_error_where_it_is_required(monkeypatch):
    """PYPORT_ORACLE=required turns a missing oracle into bad input, never into a skip."""

    def missing(name):
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(answers.importlib, "import_module", missing)
    monkeypatch.delenv("PYPORT_ORACLE", raising=False)
    assert answers.find_oracle() is None
    monkeypatch.setenv("PYPORT_ORACLE", "required")

    with pytest.raises(BadInput, match="PYPORT_ORACLE"):
        answers.find_oracle()
