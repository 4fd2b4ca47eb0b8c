"""Sections of the page of the proof that go through a set's verdicts: what they hide and say."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.prove import OPENED, read_lines
from pyport.examiner.sealed.record.published import read_json
from pyport.examiner.sealed.scoring.judge import Verdict
from pyport.examiner.sealed.seal import write_json
from pyport.runs.stages import track

COSINES = "cosines.json"


def left_out(verdicts: Sequence[Verdict]) -> str:
    """Return what was found where the real sky, not a drawn cause, was left out of the steering."""
    cases = [one for one in verdicts if one.group == "ablation"]
    if not cases:
        return ""
    lines = []
    for one in sorted(cases, key=lambda each: str(each.spec["effect"])):
        pulls = ", ".join(f"{name} {pull:+.1f} sigma" for _, name, pull in one.pulls) or "none"
        steps = str(one.spec["effect"]).replace("_", " ").replace("+", ", ")
        lines.append(f"| {steps} | {sum(one.found)} of {len(one.found)} | {one.said} | {pulls} |")
    return "\n".join(
        [
            "### Steps of the reduction left out\n",
            "Catalogue sources on the real dates of two campaigns, the Earth turned as it did; a",
            "coefficient is compared with nature's own. What is too small to be seen is missed.\n",
            "| left out | found | said first | known coefficients off by |",
            "|---|---|---|---|",
            *lines,
            "",
        ]
    )


def cosines_of(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the largest cosine of each form that no name has with what the program has one for.

    They are measured when the page is first written, and kept: they are the sealed program's.
    """
    path = folder / COSINES
    if not path.exists():
        from pyport.examiner.acceptance.cosines import of_made

        _, *opened = read_lines((folder / OPENED).read_bytes())
        truths = {one["case"]: json.loads(one["truth"]) for one in opened}
        forms = {case: one for case, one in truths.items() if one["spec"]["group"] == "unknown"}
        write_json(
            path,
            {
                case: of_made(Spec(**one["spec"]).make(one["seed"]))
                for case, one in track(forms.items(), "measuring cosines")
            },
        )
    return read_json(path)


def unknown(verdicts: Sequence[Verdict], cosines: dict[str, dict[str, Any]]) -> str:
    """Return how each form without a name was answered, beside the name that comes nearest."""
    forms: dict[str, list[Verdict]] = {}
    for one in sorted(verdicts, key=lambda each: str(each.spec["effect"])):
        if one.case in cosines:
            forms.setdefault(str(one.spec["effect"]), []).append(one)
    if not forms:
        return ""
    lines = []
    for form, own in forms.items():
        said = [one.said for one in own]
        named = sorted({one for one in said if one not in {"unknown", "nothing"}})
        nearest = max((cosines[one.case] for one in own), key=lambda each: each["named_cosine"])
        alike = f"{nearest['named_cosine']:.2f} ({nearest['named']})"
        counts = f"{said.count('unknown')} | {said.count('nothing')} | {', '.join(named) or '-'}"
        lines.append(f"| {form.replace('_', ' ')} | {len(own)} | {counts} | {alike} |")
    return "\n".join(
        [
            "### Forms that no name has\n",
            "The largest cosine of each, beside the model, with what the program has a name for.\n",
            "| form | cases | unknown | nothing | named | cosine with a name |",
            "|---|---|---|---|---|---|",
            *lines,
            "",
        ]
    )


def wrong(verdicts: Iterable[Verdict]) -> str:
    """Return every case with a finding that is wrong, and how many had no report."""
    verdicts = list(verdicts)
    lines = []
    for one in verdicts:
        hidden = one.found and one.spec["rho"] != 0
        if not hidden and one.claimed:
            lines.append(f"- {one.case} ({one.group}): nothing hidden, said {one.said}")
        elif hidden and one.wrong:
            said = ", ".join(one.wrong)
            beside = "beside what is right " if any(one.found) else ""
            what = f"{one.spec['effect'] or 'causes drawn at random'} at rho {one.spec['rho']:g}"
            lines.append(f"- {one.case} ({one.group}): hidden {what}, {beside}said {said}")
    failed = sum(1 for one in verdicts if one.failed)
    return "\n".join(
        [
            "### Wrong answers\n",
            f"{len(lines)} cases of {len(verdicts):,} got a wrong finding, first or later;",
            f"{failed} got no report.\n",
            *lines,
            "",
        ]
    )
