"""Stated gains: the fall of the held-out rms in a report beside the fall on fresh recordings.

Half of the recordings of a drawn case, chosen at random, are diagnosed. The model that comes of it
is then held to the others, which it never saw: same world, same hours, other noise.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.examiner.acceptance.drawn import Line
from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import count, write_recordings
from pyport.examiner.worlds.faults import UNCATALOGUED
from pyport.runs.stages import track

if TYPE_CHECKING:
    from pyport.correction.use import PointingModel

#: Edges, steps, and what no catalogue holds, which becomes a field; rho and rows of each case.
_CAUSES = ("subreflector_jump", "epoch_offset", "epoch_tilt", *UNCATALOGUED)
_RHO, _ROWS, CASES = 1.0, 600, 100
#: Share of differences within two errors that is asked for.
_WITHIN = 0.9


@dataclass(frozen=True)
class Gain:
    """A fall of the rms [arcsec] as the report states it, on fresh recordings, and their errors."""

    effect: str
    stated: float
    stated_sigma: float
    fresh: float
    fresh_sigma: float

    @property
    def off(self) -> float:
        """Difference over its error."""
        return (self.stated - self.fresh) / np.hypot(self.stated_sigma, self.fresh_sigma)


def lines(jobs: int, seed: int, cases: int = CASES) -> Iterator[Line]:
    """Yield how far stated gains are from fresh ones; `seed` is that of the first case."""
    tasks = [(name, seed + n) for n, name in enumerate(islice(cycle(_CAUSES), cases))]
    with ProcessPoolExecutor(jobs) as pool:
        found = track(pool.map(_gain, tasks, chunksize=2), "holding gains", total=len(tasks))
        gains = [one for one in found if one is not None]
    off = np.array([one.off for one in gains])
    ratio = sum(one.fresh for one in gains) / max(sum(one.stated for one in gains), 1e-300)
    within = count(list(np.abs(off) <= 2))
    yield Line("stated gains: drawn cases with a finding", f"{len(gains)} of {cases}", "all", None)
    yield Line("stated gains: fresh over stated, in all", f"{ratio:.3f}", "1", None)
    yield Line("stated gains: mean difference in errors", f"{off.mean():+.2f}", "0", None)
    yield Line(
        "stated gains: within two errors of the fresh gain",
        str(within),
        f"at least {100 * _WITHIN:.0f} %",
        bool(within.value >= _WITHIN),
    )


def _gain(task: tuple[str, int]) -> Gain | None:
    """Return the gain of a case, None where nothing was found."""
    from pyport import api

    effect, seed = task
    kind = "unknown" if effect in UNCATALOGUED else "one"
    made = Spec(kind, kind, effect, _RHO, _ROWS, "white").make(seed)
    with tempfile.TemporaryDirectory() as name:
        whole, seen, fresh = (Path(name) / f"{one}.csv" for one in ("whole", "seen", "fresh"))
        write_recordings(made, whole)
        text = whole.read_text(encoding="utf-8").splitlines(keepends=True)
        head = sum(one.startswith("#") for one in text) + 1
        rows = np.array(text[head:])
        half = np.random.default_rng(seed).permutation(len(rows)) % 2 == 0
        for path, mine in ((seen, rows[half]), (fresh, rows[~half])):
            path.write_text("".join([*text[:head], *mine]), encoding="utf-8")
        diagnosis = api.diagnose(seen, "altaz")
        held = diagnosis.report["fit"]["heldout"]
        if not diagnosis.report["findings"]:
            return None
        before = _misses(api.fit(seen, "altaz").model, fresh)
        after = _misses(diagnosis.model, fresh)
    fall = np.sqrt(np.mean(before**2)) - np.sqrt(np.mean(after**2))
    share = before**2 / np.sqrt(np.mean(before**2)) - after**2 / np.sqrt(np.mean(after**2))
    sigma = float(np.std(share) / 2 / np.sqrt(len(share)))
    stated = held["rms_before_arcsec"] - held["rms_after_arcsec"]
    return Gain(effect, stated, held["rms_fall_sigma_arcsec"], float(fall), sigma)


def _misses(model: PointingModel, path: Path) -> Array:
    """Return what a model leaves of the readings of a file [arcsec], both axes, shape (2n,)."""
    from pyport.recordings import read

    recordings = read(path)
    x, y = model.at(recordings.at)
    left = np.concatenate([recordings.x - x, recordings.y - y]) / ARCSEC
    return left[np.isfinite(left)]
