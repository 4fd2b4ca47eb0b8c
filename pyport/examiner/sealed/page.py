"""The public record: one page with the whole case, numbers and pictures taken from the scores."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner.sealed import figures
from pyport.examiner.sealed.examine import Score
from pyport.examiner.sealed.judge import Verdict
from pyport.examiner.sealed.published import read_json, read_seal
from pyport.examiner.sealed.seal import Folder
from pyport.files import sha256, write_whole

_HEAD = """# Does it find what was hidden?

The claim: given recordings that differ from the simulation, `pyport diagnose` finds where, says
which physics was left out, models it, and the fit improves on data that it did not see.

The proof: causes are drawn at random and put into recordings by an examiner that shares no
formula with the program. Its telescope is made of rotations, its sky is ERFA's, with catalogue
sources, real dates and the Earth's real orientation. Truths are sealed by SHA-256 of a 256-bit
nonce and the text, together with the hashes of the recordings, the solver, the examiner and the
thresholds. Each case is solved in a process that sees the recordings alone and cannot open the
truth. Then the set is opened, once, and scored. Every set that was ever sealed stands in the
[ledger](proof/ledger.md); [why some rows did not pass](proof/reasons.md) stands beside it.

Beside the drawn cases stand real recordings, each with a fact that was never in them:
[the GMRT](proof/gmrt.md), whose antennas were surveyed; [the RT32's published
table](proof/published-table.md), which holds what its routines do not; [the LMT](proof/lmt.md)
and [AuxTel](proof/auxtel.md), whose models others fitted. `pyport dev acceptance` prints what
else is promised.

rho is what the altaz base leaves of a cause, rms, over the noise, on the axis where it is
greater. Brackets hold counts and Wilson's 95 % interval.
"""

_CAPTIONS = {
    "detection.png": "How often a single cause is detected, and named right first, against rho.",
    "length.png": "The same against the number of recordings.",
    "calibration.png": "Stated p-values where nothing is hidden: on the line they are honest.",
    "skill.png": "How much of what a refit of the true form gains on unseen data was gained.",
    "confusion.png": "What was said first of what was hidden, in per cent of its cases.",
}

_WORST = 12


def write(sets: Sequence[Path], out: Path) -> None:
    """Write the page and, in a folder of its name beside it, pictures, seals and one case each.

    `sets`: folders of sets that were scored.
    `out`: the page, Markdown.
    """
    sections = [
        _section(root, out.with_suffix("") / root.resolve().name, out.parent) for root in sets
    ]
    with write_whole(out) as file:
        file.write("\n".join([_HEAD, *sections]))


def _section(root: Path, folder: Path, base: Path) -> str:
    """Write the files of one set and return its part of the page."""
    folder.mkdir(parents=True, exist_ok=True)
    scored, sealed = read_json(root / "score.json"), read_seal(Folder(root).seal)
    try:
        verdicts = [Verdict(**one) for one in scored["verdicts"]]
    except (KeyError, TypeError) as error:
        raise BadInput(f"this is no score ({error})", root / "score.json") from None
    if not {one.case for one in verdicts} <= {one["case"] for one in sealed["cases"]}:
        raise BadInput("a case that the seal has not, expected its own", root / "score.json")
    _copy(Folder(root).seal, folder / "sealed.json")
    place = folder.relative_to(base).as_posix()
    pictures = [
        f"![{_CAPTIONS[name]}]({place}/{name})\n\n{_CAPTIONS[name]}\n"
        for name in figures.write(folder, verdicts)
    ]
    lines = [
        f"## {scored['name']}: {'passed' if scored['passed'] else 'not passed'}\n",
        f"{len(verdicts)} cases, sealed {sealed['sealed_utc']}.\n",
        _table(scored["table"]),
        *pictures,
        _left_out(verdicts),
        _wrong(verdicts),
        _by_hand(root, folder, base, verdicts),
    ]
    return "\n".join(lines)


def _table(rows: list[dict[str, Any]]) -> str:
    marks = {True: "yes", False: "**no**", None: "shown"}
    lines = [
        f"| {row['what']} | {row['result']} | {row['needed']} | {marks[row['passed']]} |"
        for row in rows
    ]
    return "\n".join(["| what | result | needed | passed |", "|---|---|---|---|", *lines, ""])


def _left_out(verdicts: Sequence[Verdict]) -> str:
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


def _wrong(verdicts: Sequence[Verdict]) -> str:
    """Return the confident wrong answers, by case."""
    wrong = [
        one
        for one in verdicts
        if one.verdict == "named" and not one.first and one.group in {"one", "unknown", "two"}
    ]
    failed = [one for one in verdicts if one.failed]
    lines = [
        f"- {one.case}: hidden {one.spec['effect'] or 'two at random'} at rho {one.spec['rho']:g},"
        f" said {one.said}"
        for one in wrong[:_WORST]
    ]
    more = f" The first {_WORST}:" if len(wrong) > _WORST else ""
    return "\n".join(
        [
            "### Wrong answers\n",
            f"{len(wrong)} cases got one confident wrong name, {len(failed)} no report.{more}\n",
            *lines,
            "",
        ]
    )


def _by_hand(root: Path, folder: Path, base: Path, verdicts: Sequence[Verdict]) -> str:
    """Put one opened case beside the page and return how to check it from seal to answer."""
    shown = next((one for one in verdicts if one.group == "one" and one.first), verdicts[0])
    opened = Folder(root).opened
    for suffix in ("truth.json", "nonce"):
        _copy(opened / f"{shown.case}.{suffix}", folder / f"{shown.case}.{suffix}")
    truth = read_json(folder / f"{shown.case}.truth.json")
    sealed = read_seal(folder / "sealed.json")
    entry = next(one for one in sealed["cases"] if one["case"] == shown.case)
    here = (Path(base.name) / folder.relative_to(base)).as_posix()
    kind = truth["spec"]["kind"]
    options = {"effect": "--effect", "rho": "--rho", "rows": "--rows", "noise": "--noise"}
    asked = [
        f"{option} {truth['spec'][key]}"
        for key, option in options.items()
        if truth["spec"][key] is not None
    ]
    stem = "-".join(filter(None, [kind, truth["spec"]["effect"]]))
    made = f"try/recordings/{stem}-{truth['seed']:05d}.csv"
    return f"""### One case by hand

{shown.case}, with the solver `{sealed["solver_sha256"][:16]}`:

```
sha256sum {here}/sealed.json
(xxd -r -p {here}/{shown.case}.nonce; cat {here}/{shown.case}.truth.json) | sha256sum
pyport dev trials make --kind {kind} {" ".join(asked)} --seed {truth["seed"]} -o try
sha256sum {made}
pyport diagnose {made} {" ".join(entry["arguments"])} --out try
```

The first prints the seal that the ledger holds, `{sha256(folder / "sealed.json")}`; the
second what the seal holds of the truth, `{entry["truth_commitment"]}`;
the fourth what it holds of the recordings, `{entry["recordings_sha256"]}`
(with the same libraries; with others the last digit of a number may differ);
the fifth what was answered: {shown.said}.
"""


def _copy(source: Path, target: Path) -> None:
    with write_whole(target, "wb") as file:
        file.write(source.read_bytes())


_LEDGER_HEAD = """# Ledger of sealed sets

Every set that was ever sealed, in order, with its score, good or bad. A set is
solved once and opened once. `pyport dev trials seal` and `pyport dev trials score` write here.
"""


def enter_seal(ledger: Path, root: Path, sealed: dict[str, Any]) -> None:
    """Write down that a set was sealed."""
    _append(
        ledger,
        f"""
## {sealed["name"]}

Sealed {sealed["sealed_utc"]}, {len(sealed["cases"])} cases.

- seal `{sha256(Folder(root).seal)}`
- solver `{sealed["solver_sha256"]}`
- examiner `{sealed["examiner_sha256"]}`
""",
    )


def enter_score(ledger: Path, root: Path, score: Score) -> None:
    """Write down what a set scored; its seal says which one it is."""
    failed = [one for one in score.verdicts if one.failed]
    lines = "\n".join(map(str, score.rows))
    _append(
        ledger,
        f"""
### Score of {score.name}: {"passed" if score.passed else "not passed"}

Seal `{sha256(Folder(root).seal)}`; {len(failed)} cases without a report.

| what | result | needed | passed |
|---|---|---|---|
{lines}
""",
    )


def _append(ledger: Path, text: str) -> None:
    """Add an entry, once: a run that was killed after it did so says it again when called again."""
    before = ledger.read_text(encoding="utf-8") if ledger.exists() else _LEDGER_HEAD
    if text in before:
        return
    with write_whole(ledger) as file:
        file.write(before + text)
