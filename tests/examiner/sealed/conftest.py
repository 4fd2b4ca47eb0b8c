"""A sealed set to play with, and answers to it."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from machines import INPUTS

from pyport.examiner.sealed import seal
from pyport.examiner.sealed.protocol import Spec

ROWS = 150

SPECS = [
    *(replace(one, rows=ROWS) for one in INPUTS),
    Spec("ablation", "ablation", "nutation", 1.0, ROWS),
    Spec("zero", "one", "refraction", 0.0, ROWS),
]


@pytest.fixture
def solvers(monkeypatch):
    """Let the fake solvers be found."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))


@pytest.fixture(scope="session")
def once_sealed(tmp_path_factory):
    """Seal a set, once for all tests; return the folder that holds it and its vault."""
    place = tmp_path_factory.mktemp("sealed")
    seal.seal(place / "a-set", "a-set", SPECS)
    return place


@pytest.fixture
def sealed(tmp_path, once_sealed):
    """Return the folder of a set that has just been sealed."""
    shutil.copytree(once_sealed, tmp_path, dirs_exist_ok=True)
    return tmp_path / "a-set"


def perfect(truth):
    """Return the report of a solver that knows the truth."""
    findings = []
    # of three honest sigmas one is too small
    value = 1.03 if int(truth["case"][-1]) % 3 == 0 else 1.01
    for cause in truth["truth"]["effects"] if truth["spec"]["rho"] else []:
        unknown, twin = cause["effect"] == "unknown", len(cause["class"]) > 1
        findings.append(
            {
                "effect": cause["effect"],
                "class": cause["class"],
                "verdict": "unknown" if unknown else "ambiguous" if twin else "named",
                "where": {"region": [], "curve": None, "since": None, **cause["where"]},
                "parameters": [
                    {"name": "of_nature", "value": value, "sigma": 0.02, "expected": 1.0},
                ],
            }
        )
    return {"mismatch": bool(findings), "p_value": 0.5, "findings": findings, "examined": {}}


@pytest.fixture
def answered(sealed):
    """Return a set to which every answer is right."""
    folder = seal.Folder(sealed)
    for path in folder.vault.glob("*.truth.json"):
        truth = json.loads(path.read_text(encoding="utf-8"))
        report = folder.report(truth["case"])
        report.parent.mkdir(parents=True)
        report.write_text(json.dumps(perfect(truth)))
    return sealed
