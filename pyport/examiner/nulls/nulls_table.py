"""The table of `pyport dev nulls`: claims and coverage of each kind beside their targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pyport.examiner import scores
from pyport.examiner.nulls.nulls import CAUSE, NULL
from pyport.examiner.scores import Share, clustered, counted

#: Claims where nothing is hidden, and coefficients within one and two sigma: least, most.
CLAIMS, ONE_SIGMA, TWO_SIGMA = (0.0, 0.03), (0.64, 0.72), (0.93, 0.97)

_WIDTHS = (20, 7, 22, 22, 22, 9, 7, 22, 22)
_HEAD = (
    *("kind", "claims", "% (95 %)", "fit within 1 sigma", "fit within 2 sigma"),
    *("found", "beside", "cause within 1 sigma", "cause within 2 sigma"),
)


@dataclass(frozen=True)
class Line:
    """What the cases of one kind came to.

    `claims`: cases with nothing hidden in which something was claimed.
    `said`: what was claimed in them, and how often.
    `fit`, `cause`: coefficients within one and two sigma of the truth: of `fit` where nothing is
      hidden, of the finding with the right name where one cause is.
    `found`: cases with one cause whose name is among the findings.
    `beside`: cases with one cause in which something else was claimed.
    `refused`: cases that the program could not use.
    """

    kind: str
    claims: Share
    said: Counter[str]
    fit: tuple[Share, Share]
    found: Share
    beside: Share
    cause: tuple[Share, Share]
    refused: int

    def verdicts(self) -> dict[str, str]:
        """Return each target and whether it is met, missed, or open."""
        return {
            "claims": self.claims.judged(*CLAIMS),
            "fit within 1 sigma": self.fit[0].judged(*ONE_SIGMA),
            "fit within 2 sigma": self.fit[1].judged(*TWO_SIGMA),
            "cause within 1 sigma": self.cause[0].judged(*ONE_SIGMA),
            "cause within 2 sigma": self.cause[1].judged(*TWO_SIGMA),
        }


def line(kind: str, outcomes: Iterable[dict[str, Any]]) -> Line:
    """Return what the outcomes of a kind come to."""
    outcomes = list(outcomes)
    used = [one for one in outcomes if "refused" not in one]
    empty = [one for one in used if one["part"] == NULL]
    hidden = [one for one in used if one["part"] == CAUSE]
    names = [{found["effect"] for found in one["findings"]} for one in hidden]
    right = [one["cause"] in some for one, some in zip(hidden, names, strict=True)]
    beside = [bool(some - {one["cause"]}) for one, some in zip(hidden, names, strict=True)]
    return Line(
        kind,
        counted([one["claimed"] for one in empty]),
        Counter(found["effect"] for one in empty if one["claimed"] for found in one["findings"]),
        _within(empty),
        counted(right),
        counted(beside),
        _within(hidden),
        len(outcomes) - len(used),
    )


def _within(outcomes: list[dict[str, Any]]) -> tuple[Share, Share]:
    one, two = (
        clustered([[abs(z) <= reach for z in case["z"].values()] for case in outcomes])
        for reach in (1.0, 2.0)
    )
    return one, two


def text(lines: list[Line]) -> str:
    """Return the table, what was claimed, and which targets are missed."""
    rows = [_row(*_HEAD)]
    for one in lines:
        counts = [f"{share.hits}/{share.of}" for share in (one.claims, one.found, one.beside)]
        shares = [str(share) for share in (one.claims, *one.fit, *one.cause)]
        rows.append(_row(one.kind, counts[0], *shares[:3], *counts[1:], *shares[3:]))
    rows.append("")
    for one in lines:
        if one.said:
            names = ", ".join(f"{name} {n}" for name, n in one.said.most_common())
            rows.append(f"claimed in {one.kind}: {names}")
        if one.refused:
            rows.append(f"refused in {one.kind}: {one.refused}")
    rows += ["", *(_verdict(lines, which) for which in (scores.OPEN, scores.MISSED))]
    return "\n".join(rows)


def _row(*cells: str) -> str:
    return "  ".join(
        f"{cell:{width}s}" for cell, width in zip(cells, _WIDTHS, strict=True)
    ).rstrip()


def _verdict(lines: list[Line], which: str) -> str:
    found = []
    for one in lines:
        targets = [name for name, verdict in one.verdicts().items() if verdict == which]
        if targets:
            found.append(f"{one.kind} ({', '.join(targets)})")
    words = {
        scores.OPEN: "outside the target, but not with 95 % confidence",
        scores.MISSED: "targets missed",
    }
    return f"{words[which]}: {'; '.join(found) or 'none'}"
