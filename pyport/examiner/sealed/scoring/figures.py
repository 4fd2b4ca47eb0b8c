"""Pictures of a score: what was detected, what was confused with what, what was gained."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pyport.examiner.sealed.record.files import Rate, count
from pyport.examiner.sealed.scoring import overall
from pyport.examiner.sealed.scoring.judge import Verdict
from pyport.files import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_INK = "#1f3b57"
_ACCENT = "#c2571a"
_QUIET = "#8a97a3"
_DETECTED = (_INK, "detected")
_NAMED = (_ACCENT, "right class first")


def write(folder: Path, verdicts: Sequence[Verdict]) -> list[str]:
    """Write the pictures that these verdicts can fill; return their file names."""
    from matplotlib.figure import Figure

    written = []
    for name, (draw, size) in _PICTURES.items():
        figure = Figure(figsize=size, layout="constrained")
        if draw(figure.add_subplot(), verdicts):
            with write_whole(folder / f"{name}.png", "wb") as file:
                figure.savefig(file, dpi=130, metadata={"Software": None})
            written.append(f"{name}.png")
    return written


def _curve(
    axes: Axes,
    verdicts: Sequence[Verdict],
    by: str,
    outcome: Callable[[Verdict], bool],
    look: tuple[str, str],
) -> None:
    """Draw the rate of an outcome against something of the spec, with Wilson's intervals."""
    values = sorted({one.spec[by] for one in verdicts})
    rates: list[Rate] = [
        count([outcome(one) for one in verdicts if one.spec[by] == value]) for value in values
    ]
    low = [100 * (rate.value - rate.interval[0]) for rate in rates]
    high = [100 * (rate.interval[1] - rate.value) for rate in rates]
    percent = [100 * rate.value for rate in rates]
    colour, label = look
    axes.errorbar(values, percent, yerr=[low, high], fmt="o-", capsize=3, color=colour, label=label)
    axes.set_xscale("log")
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.minorticks_off()


def _detection(axes: Axes, verdicts: Sequence[Verdict]) -> bool:
    """Draw detection and the right class against rho."""
    those = [one for one in verdicts if one.group == "one"]
    if len({one.spec["rho"] for one in those}) < 2:
        return False
    _curve(axes, those, "rho", lambda one: one.claimed, _DETECTED)
    _curve(axes, those, "rho", lambda one: one.first, _NAMED)
    _frame(axes, "rho: what the base leaves of the cause, over the noise")
    return True


def _length(axes: Axes, verdicts: Sequence[Verdict]) -> bool:
    """Draw detection against the number of recordings."""
    those = [one for one in verdicts if one.group == "rows"]
    if not those:
        return False
    _curve(axes, those, "rows", lambda one: one.claimed, _DETECTED)
    _curve(axes, those, "rows", lambda one: one.first, _NAMED)
    _frame(axes, "recordings, at rho 0.25")
    return True


def _frame(axes: Axes, across: str) -> None:
    axes.set_ylim(-3, 103)
    axes.set_xlabel(across)
    axes.set_ylabel("cases [%]")
    axes.legend(loc="lower right")
    axes.grid(alpha=0.3)


def _calibration(axes: Axes, verdicts: Sequence[Verdict]) -> bool:
    """Draw the p-values of cases that hide nothing against what they should be."""
    values = np.sort([p for one in verdicts if (p := overall.silent_p_value(one)) is not None])
    if not len(values):
        return False
    axes.plot([0, 1], [0, 1], color=_QUIET, lw=1, label="honest")
    axes.step(values, np.arange(1, len(values) + 1) / len(values), color=_INK, where="post",
              label=f"{len(values)} cases with nothing in them")  # fmt: skip
    axes.set_xlabel("stated p-value")
    axes.set_ylabel("cases with a smaller one")
    axes.legend(loc="lower right")
    axes.grid(alpha=0.3)
    return True


def _skill(axes: Axes, verdicts: Sequence[Verdict]) -> bool:
    """Draw how much of what could be gained on unseen data was gained, case by case."""
    gained = [one.skill[0] / one.skill[1] for one in verdicts if one.skill and one.skill[1] > 0]
    if not gained:
        return False
    axes.hist(np.clip(gained, -0.5, 1.2), bins=np.linspace(-0.5, 1.2, 35).tolist(), color=_INK)
    axes.axvline(0.9, color=_ACCENT, label="needed in the median")
    axes.set_xlabel("skill on data left out")
    axes.set_ylabel("cases")
    axes.legend(loc="upper left")
    return True


def _confusion(axes: Axes, verdicts: Sequence[Verdict]) -> bool:
    """Draw what was said first of what was hidden."""
    counted = overall.confusion(verdicts)
    if not counted:
        return False
    hidden = sorted({one for one, _, _ in counted}, reverse=True)
    said = ["right", "nothing", "unknown"]
    said += sorted({one for _, one, _ in counted} - set(said))
    share = np.zeros((len(hidden), len(said)))
    for cause, answer, n in counted:
        share[hidden.index(cause), said.index(answer)] = n
    share /= share.sum(axis=1, keepdims=True)
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    axes.set_xticks(range(len(said)), said, rotation=90, fontsize=7)
    axes.set_yticks(range(len(hidden)), hidden, fontsize=7)
    axes.set_xlabel("said first")
    axes.set_ylabel("hidden")
    for row, column in zip(*np.nonzero(share), strict=True):
        dark = share[row, column] > 0.5
        text = f"{100 * share[row, column]:.0f}"
        axes.text(
            column, row, text, ha="center", va="center", fontsize=6,
            color="white" if dark else "black",
        )  # fmt: skip
    return True


_PICTURES: dict[str, tuple[Callable[[Axes, Sequence[Verdict]], bool], tuple[float, float]]] = {
    "detection": (_detection, (6.4, 4.0)),
    "length": (_length, (6.4, 4.0)),
    "calibration": (_calibration, (4.8, 4.2)),
    "skill": (_skill, (6.4, 3.4)),
    "confusion": (_confusion, (9.0, 9.0)),
}
