"""The command `pyport parity` on the RT32's routines."""

import json
import shutil

import pytest
import rt32
from click.testing import CliRunner

from pyport.cli.parity import command
from pyport.parity.run import kept_beside


def call(*words):
    """Call the command."""
    return CliRunner().invoke(command, [str(word) for word in words], catch_exceptions=False)


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
def test_live_run_covers_table_edges_and_random_points():
    """With a compiler the ports are asked at the whole table, the edges and the random points."""
    config = rt32.DESCRIPTION.path
    done = call("--config", config, "--points", 6000, "--json", "--jobs", 2)
    content = json.loads(done.output)
    answers = content["ports"]["legacy"]["answers"]

    assert done.exit_code == 0
    assert content["source"] == "live"
    assert content["points"]["table"] == 51395
    assert content["points"]["random"] == 6000
    assert {c["points"] for c in answers} == {sum(content["points"].values())}
    assert all(port["kept"] for port in content["ports"].values())


@pytest.mark.slow
@pytest.mark.usefixtures("same_library")
def test_without_a_compiler_stored_answers_serve(monkeypatch, tmp_path):
    """Without a compiler the stored answers hold the port; the report is a page of Markdown.

    What a run kept that was killed before it is removed.
    """
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))
    monkeypatch.delenv("PYPORT_ORACLE", raising=False)
    monkeypatch.setattr("pyport.parity.compiled.build.command_of", lambda _: None)
    path = tmp_path / "parity.md"
    kept_beside(str(path), rt32.DESCRIPTION, 20_000, 0).write_bytes(b"half")
    done = call("--report", path, "--summary", tmp_path / "summary.md")

    assert done.exit_code == 0
    assert "Against the oracle's stored answers" in done.output
    assert "equals the published program bit for bit" in done.output
    assert path.read_text().startswith("# Is the port the program that was published?")
    assert "✅ The legacy port equals" in (tmp_path / "summary.md").read_text()
    assert sorted(one.name for one in tmp_path.iterdir()) == ["parity.md", "summary.md"]


@pytest.mark.slow
@pytest.mark.parametrize("live", [pytest.param(True, marks=pytest.mark.oracle), False])
def test_flipped_sign_ends_with_status_1(tmp_path, request, live):
    """A port with one sign turned is not the program: exit status 1, live and on paper."""
    if live:
        request.getfixturevalue("oracle")
    copy = tmp_path / "rt32"
    shutil.copytree(rt32.FORTRAN, copy)
    text = (copy / "parity.toml").read_text()
    (copy / "parity.toml").write_text(text.replace("pyport.legacy:modela", "wrong:modela"))
    (copy / "wrong.py").write_text(
        "from pyport import legacy\n\n\n"
        "def modela(az, alt, p):\n"
        "    daz, dalt = legacy.modela(az, alt, p)\n"
        "    return -daz, dalt\n"
    )
    words = ["--config", copy / "parity.toml", "--points", 100, "--jobs", 1]
    done = call(*words, *([] if live else ["--stored"]))

    assert done.exit_code == 1
    assert "The legacy port is NOT the published program" in done.output
    assert "Minimal inputs:" in done.output
    assert "legacy: ModelA(Az=" in done.output
    if live:  # asked anew, the input is made as simple as it can be
        assert "ModelA(Az=0x0p+0, Alt=0x0p+0, p=[0x0p+0, 0x0p+0, " in done.output
