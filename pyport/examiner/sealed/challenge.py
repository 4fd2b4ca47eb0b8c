"""A challenge for any program: recordings of hidden causes, and what answers to them are worth.

Everything is drawn from one seed, so that two who know it hold the same recordings and the same
key; who is to answer gets the folder without the seed and without the vault beside it.
"""

from __future__ import annotations

import csv
import json
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner.baselines import METHODS
from pyport.examiner.sealed import prove, solve
from pyport.examiner.sealed.examine import judged
from pyport.examiner.sealed.protocol import SETS
from pyport.examiner.sealed.record.published import check_report, read_json, read_seal
from pyport.examiner.sealed.scoring import score
from pyport.examiner.sealed.scoring.overall import Row
from pyport.examiner.sealed.seal import Folder, check_truths, seal
from pyport.files import write_file

#: The program as one who answers.
PROGRAM = "pyport"
_COLUMNS = ("case", "names", "sizes", "since", "region")
_README = """# {count} sets of pointing offsets

Each file in `recordings/` holds pointing offsets that a telescope's pointing model leaves, as
comma-separated values: a direction, offsets as encoder minus true, and what was logged. Units are
in the names of the columns. In some of them nothing is hidden beside noise, in others one cause,
or several. Which, how large, where, and since when?

The model that was fitted, or is to be fitted, is the classical one of an alt-azimuth mount: zeros
of both axes, collimation, skew of the axes, tilt to north and east, flexure as cos E. Where
another holds, the arguments of `pyport diagnose` say which:

{others}

## Answers

One file, `answers.csv`, with a row for every cause found, the surest of a case first:

```
case,names,sizes,since,region
case-0001,refraction elevation_scale,refraction=6.4+-0.5,,
case-0002,epoch_offset,,2004-01-05T21:10:00Z,
case-0003,unknown,,,az_deg 100 140; el_deg 20 35
```

`names`: ids of `pyport dev effects`; several where the recordings cannot distinguish them, six at
most; `unknown` for a cause that has no such name. `sizes`: coefficients by name, in the units that
`pyport dev effects` gives, with their standard errors. `since`: the moment from which it acts.
`region`: where it acts, columns with their limits. What is not known is left blank; a case in
which nothing was found has no row. The same as JSON, `answers.json`, with `curve` for a curve in
the sky, pairs of azimuth and elevation in degrees:

```
{{"case-0001": [{{"names": ["refraction"], "sizes": {{"refraction": [6.4, 0.5]}}}}],
 "case-0003": [{{"names": ["unknown"], "region": {{"az_deg": [100, 140]}}}}]}}
```

`pyport dev challenge --score FOLDER answers.csv` is called by who has the key.
"""


def challenge(root: Path, seed: int, count: int) -> dict[str, Any]:
    """Write recordings, what is asked of them, and a key in a vault beside; return the seal.

    `root`: a new folder.
    `seed`: what everything is drawn from.
    `count`: how many cases, drawn from those of a full proof.
    Raises `BadInput`: there are fewer cases than that, or the folder is not empty.
    """
    specs = SETS["full"]()
    if not 0 < count <= len(specs):
        raise BadInput(f"{count} cases, expected 1 to {len(specs)}")
    chance = random.Random(seed)  # noqa: S311 - the seed is what both sides know
    sealed = seal(root, root.resolve().name, chance.sample(specs, count), chance)
    others = [
        f"- {one['case']}: `{' '.join(one['arguments'])}`"
        for one in sealed["cases"]
        if one["arguments"]
    ]
    text = _README.format(count=count, others="\n".join(others) or "(none here)")
    write_file(root / "README.md", text)
    return sealed


def scores(root: Path, answers: Sequence[str], jobs: int = 1) -> dict[str, list[Row]]:
    """Return the rows of the score by whose answers they are.

    `answers`: files, and `bic`, `lasso` or `pyport`, who answer now.
    Raises `BadInput`: the key is not here, or a file is no answer to this challenge.
    """
    folder = Folder(root)
    sealed = read_seal(folder.seal)
    truths = check_truths(folder.vault, sealed)
    found = {}
    for one in dict.fromkeys(answers):
        whose = Path(one).stem
        given = folder
        if one == PROGRAM:
            solve.run(root, jobs)
        elif one in METHODS:
            given = Folder(root, one)
            prove.answer_beside(root, jobs, (one,))
        else:
            given = Folder(root, f"answers-{whose}")
            _keep(given, read(Path(one)), [*truths])
        found[whose] = score.table(judged(given, truths, jobs))
    return found


def _keep(folder: Folder, reports: dict[str, dict[str, Any]], cases: list[str]) -> None:
    if other := sorted(reports.keys() - {*cases}):
        raise BadInput(f"no case is called {other[0][:40]!r}", folder.seal)
    nothing: dict[str, Any] = {"mismatch": False, "findings": [], "examined": {}}
    for case in cases:
        solve.keep(folder, case, reports.get(case, nothing))


def beside(scored: dict[str, list[Row]]) -> list[tuple[str, str, dict[str, Row]]]:
    """Return (what, needed, row by whose answers) for each row that anyone has, in order."""
    rows: dict[str, dict[str, Row]] = {}
    for by, some in scored.items():
        for row in some:
            rows.setdefault(row.what, {})[by] = row
    return [(what, next(iter(by.values())).needed, by) for what, by in rows.items()]


def read(path: Path) -> dict[str, dict[str, Any]]:
    """Read answers, CSV or JSON, as reports by case.

    Raises `BadInput`: the file is no answer, with the line where one is at fault.
    """
    if path.suffix == ".json":
        cases = read_json(path)
        lists = isinstance(cases, dict) and all(isinstance(one, list) for one in cases.values())
        if not lists:
            raise BadInput("no lists of answers by case, expected those", path)
        return {
            case: _report([_json(one, path) for one in some], path) for case, some in cases.items()
        }
    found: dict[str, list[dict[str, Any]]] = {}
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.DictReader(file)
        if not {*_COLUMNS[:2]} <= {*(lines.fieldnames or ())}:
            raise BadInput(f"no columns {', '.join(_COLUMNS)} in this file", path, 1)
        for row in lines:
            case = (row["case"] or "").strip()
            try:
                answer = _csv({name: (row.get(name) or "").strip() for name in _COLUMNS})
            except ValueError as error:
                raise BadInput(str(error), path, lines.line_num) from None
            found.setdefault(case, []).extend(answer)
    return {case: _report(some, path) for case, some in found.items()}


def _csv(row: dict[str, str]) -> list[dict[str, Any]]:
    """Return the finding of a row of text, none for one without names."""
    sizes, region = [], []
    for part in filter(None, map(str.strip, row["sizes"].split(";"))):
        name, _, number = part.partition("=")
        value, _, sigma = number.partition("+-")
        sizes.append((name.strip(), float(value), float(sigma) if sigma else None))
    for part in filter(None, map(str.strip, row["region"].split(";"))):
        column, low, high = part.split()
        region.append((column, float(low), float(high)))
    names = row["names"].split()
    return [_finding(names, sizes, row["since"] or None, region, None)] if names else []


def _json(one: Any, path: Path) -> dict[str, Any]:  # noqa: ANN401 - whatever JSON holds
    try:
        sizes = [
            (name, *([size, None] if isinstance(size, int | float) else size))
            for name, size in (one.get("sizes") or {}).items()
        ]
        region = [(column, low, high) for column, (low, high) in (one.get("region") or {}).items()]
        curve = one.get("curve")
        points = curve and [{"az_deg": az, "el_deg": el} for az, el in curve]
        return _finding(list(one["names"]), sizes, one.get("since"), region, points)
    except (AttributeError, KeyError, TypeError, ValueError, IndexError) as error:
        said = f"{type(error).__name__} {error}: expected names, sizes, since, region, curve"
        raise BadInput(said, path) from None


def _finding(
    names: list[str],
    sizes: Sequence[tuple[Any, ...]],
    since: str | None,
    region: Sequence[tuple[Any, ...]],
    curve: list[dict[str, float]] | None,
) -> dict[str, Any]:
    """Return an answer as a report has it."""
    unknown = names[0] == "unknown"
    intervals = [dict(zip(("column", "low", "high"), one, strict=True)) for one in region]
    return {
        "effect": names[0],
        "class": names,
        "verdict": "unknown" if unknown else "ambiguous" if len(names) > 1 else "named",
        "where": {"region": intervals, "curve": curve, "since": since},
        "parameters": [dict(zip(("name", "value", "sigma"), one, strict=True)) for one in sizes],
    }


def _report(findings: list[dict[str, Any]], path: Path) -> dict[str, Any]:
    report = {"mismatch": bool(findings), "findings": findings, "examined": {}}
    return check_report(json.loads(json.dumps(report)), path)
