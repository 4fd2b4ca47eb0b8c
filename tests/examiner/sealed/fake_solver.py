"""Solvers that know nothing, to examine the examination with: python -m fake_solver HOW FILE ..."""

import json
import os
import signal
import sys
from pathlib import Path


def main(how: str, file: str, _: str, out: str, *arguments: str) -> None:
    """Answer in one of several useless ways."""
    folder = Path(out) / Path(file).stem
    findings = []
    if how == "crash":
        sys.exit("I have no idea")
    if how == "mute":
        return
    if how.startswith("SIG"):
        os.kill(os.getpid(), signal.Signals[how])
    if how == "spy":
        Path(arguments[-1]).read_text()
    if how == "babble":
        findings = [{"effect": ["refraction"], "class": 3}]
    if how == "parrot":
        findings = [{"effect": "refraction", "class": ["refraction"], "verdict": "named",
                     "where": {}, "parameters": []}]  # fmt: skip
    beside = sorted(path.name for path in Path.cwd().iterdir())
    folder.mkdir(parents=True)
    # what is said under a key of a report is kept
    seen = {"beside": beside, "arguments": arguments}
    report = {"mismatch": bool(findings), "p_value": 0.5, "findings": findings, "two_axes": seen}
    (folder / "report.json").write_text(json.dumps(report))


main(*sys.argv[1:])
