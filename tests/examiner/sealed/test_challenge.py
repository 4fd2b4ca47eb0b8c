"""A challenge is drawn from its seed, answered in a simple format, and scored like the program."""

import csv
import json

import pytest
from click.testing import CliRunner

from pyport.cli.dev.proof import challenge as command
from pyport.errors import BadInput
from pyport.examiner.sealed import challenge as challenges
from pyport.examiner.sealed import seal
from pyport.examiner.sealed.protocol import SETS, Spec

SPECS = [
    Spec("null", "null", rows=80, noise="white"),
    Spec("one", "one", "sag_sine", 1.0, 80),
    Spec("one", "held", "ut1", 1.0, 80),
    Spec("degenerate", "degenerate", "latitude", 1.0, 80),
    Spec("region", "unknown", "region", 1.0, 80),
    Spec("curve", "one", "subreflector_jump", 1.0, 80),
    Spec("moment", "one", "epoch_offset", 1.0, 80),
]


@pytest.fixture(scope="module")
def posed(tmp_path_factory):
    """Return a challenge of seven small cases."""
    root = tmp_path_factory.mktemp("challenge") / "posed"
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(SETS, "full", lambda: SPECS)
        challenges.challenge(root, 7, len(SPECS))
    return root


def causes(root):
    """Yield each case and what the key says of its causes."""
    folder = seal.Folder(root)
    for path in sorted(folder.vault.glob("*.truth.json")):
        told = json.loads(path.read_text(encoding="utf-8"))
        yield told["case"], told["truth"]["effects"]


def results(root, *answers):
    """Return the table, by what is asked and who answers."""
    return {
        what.split(" (")[0]: {by: row.result.split(" (")[0] for by, row in rows.items()}
        for what, _, rows in challenges.beside(challenges.scores(root, answers))
    }


@pytest.mark.slow
def test_the_same_seed_is_the_same_challenge(posed, tmp_path, monkeypatch):
    """To the last byte of recordings and key; another seed is another one."""
    monkeypatch.setitem(SETS, "full", lambda: SPECS)
    first = seal.Folder(posed)
    again = challenges.challenge(tmp_path / "posed", 7, len(SPECS))["cases"]
    other = challenges.challenge(tmp_path / "other", 8, 2)["cases"]

    assert again == json.loads(first.seal.read_text())["cases"]
    assert not {one["recordings_sha256"] for one in other} & {
        one["recordings_sha256"] for one in again
    }


def test_the_folder_says_what_is_asked_and_no_answer(posed):
    """Cases with another model have their arguments; no cause and no seed is in it."""
    text = (posed / "README.md").read_text(encoding="utf-8")
    given = [path for path in posed.rglob("*") if path.is_file()]

    assert "# 7 sets" in text
    assert text.count("`--model none --refit none`") == 2
    assert {path.parent.name for path in given} == {"posed", "recordings"}
    assert "sag_sine" not in "".join(path.read_text() for path in given)


@pytest.mark.slow
def test_right_answers_get_full_marks_in_either_format(posed, tmp_path):
    """Classes, a moment, a region, and in JSON a curve."""
    lines, told = [], {}
    for case, effects in causes(posed):
        for one in effects:
            region = one["where"].get("region") or []
            since, curve = (one["where"].get(key) for key in ("since", "curve"))
            limits = "; ".join(f"{part['column']} {part['low']} {part['high']}" for part in region)
            lines.append([case, " ".join(one["class"]), "", since or "", limits])
            told.setdefault(case, []).append(
                {
                    "names": one["class"],
                    "since": since,
                    "region": {part["column"]: [part["low"], part["high"]] for part in region},
                    "curve": curve and [[part["az_deg"], part["el_deg"]] for part in curve],
                }
            )
    with (tmp_path / "table.csv").open("w", newline="") as file:
        csv.writer(file).writerows([["case", "names", "sizes", "since", "region"], *lines])
    (tmp_path / "list.json").write_text(json.dumps(told))
    found = results(posed, str(tmp_path / "table.csv"), str(tmp_path / "list.json"))

    assert found["one cause: class right first"] == {"table": "100.0 %", "list": "100.0 %"}
    assert found["nothing hidden: claims anything"] == {"table": "0.0 %", "list": "0.0 %"}
    assert found["twins: the whole class returned"] == {"table": "100.0 %", "list": "100.0 %"}
    assert found["a region: overlap of rows"] == {"table": "median 1.00", "list": "median 1.00"}
    assert found["a moment: rows between"] == {"table": "median 0.00", "list": "median 0.00"}
    assert found["a curve: distance [deg]"]["list"] == "median 0.00"


def test_sizes_are_held_to_the_truth(tmp_path):
    """Value and standard error by name, with or without the error."""
    path = tmp_path / "answers.csv"
    path.write_text("case,names,sizes\nc,sag_sine,sag_sine=6.5+-0.5; other=2\nd,\n")
    found = challenges.read(path)

    assert found["c"]["findings"][0]["parameters"] == [
        {"name": "sag_sine", "value": 6.5, "sigma": 0.5},
        {"name": "other", "value": 2.0, "sigma": None},
    ]
    assert not found["d"]["mismatch"]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "case,effect\n", "a.csv:1: no columns case, names"),
        ("a.csv", "case,names,sizes\nc,x,x=y\n", "a.csv:2: could not convert"),
        ("a.csv", "case,names,region\nc,unknown,az_deg 3\n", "a.csv:2: not enough values"),
        ("a.csv", "case,names,since\nc,drift,yesterday\n", "expected an ISO 8601 time"),
        ("a.json", "[]", "no lists of answers"),
        ("a.json", '{"c": [{"names": []}]}', "expected names, sizes"),
        ("a.json", '{"c": ["drift"]}', "expected names, sizes"),
    ],
)
def test_what_is_no_answer_is_refused_in_one_line(tmp_path, name, text, message):
    """With the line, where there are lines."""
    path = tmp_path / name
    path.write_text(text)

    with pytest.raises(BadInput, match=message):
        challenges.read(path)


def test_an_answer_to_another_challenge_is_refused(posed, tmp_path):
    """A case that this one has not."""
    path = tmp_path / "answers.csv"
    path.write_text("case,names\ncase-0099,drift\n")

    with pytest.raises(BadInput, match="no case is called 'case-0099'"):
        challenges.scores(posed, [str(path)])


@pytest.mark.slow
def test_the_command_shows_all_who_answered_beside_each_other(posed, tmp_path):
    """A file and a baseline, a column each."""
    path = tmp_path / "mine.csv"
    path.write_text("case,names\n")
    done = CliRunner().invoke(command, ["--score", str(posed), str(path), "bic"])

    assert done.exit_code == 0, done.output
    assert "| what | needed | mine | bic |" in done.output
    assert "| one cause: class right first | at least 90 % | 0.0 % (0 of" in done.output
