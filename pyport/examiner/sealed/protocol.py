"""What is on trial: the cases of each set, and what they must show. Frozen before sealing."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pyport.examiner.worlds.campaign import NOISES
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.faults import UNCATALOGUED
from pyport.examiner.worlds.kinds import HIDEABLE, TWINS, make_case

#: What each row of the score must reach, as the proof's table has it.
THRESHOLDS: dict[str, float] = {
    "null_claims_most": 0.05,
    "one_first_least": 0.90,
    "one_three_least": 0.97,
    "one_rho_least": 0.25,
    "ablation_class_least": 1.0,
    "ablation_sigmas_most": 2.0,
    "degenerate_class_least": 0.95,
    "two_both_least": 0.70,
    "unknown_least": 0.80,
    "region_iou_least": 0.5,
    "curve_deg_most": 2.0,
    "moment_rows_most": 2.0,
    "skill_least": 0.9,
    "skill_rho_least": 0.5,
    "zero_claims_most": 0.05,
}

#: Steps that a steering leaves out, one after the other, in pairs, all at once.
_ABLATIONS = (
    "refraction",
    "annual_aberration",
    "nutation",
    "precession",
    "annual_aberration+nutation",
    "nutation+refraction",
    "annual_aberration+nutation+ut1+polar_motion+refraction",
)


@dataclass(frozen=True)
class Spec:
    """One case before its seed is drawn: which row of the table it is for, and what to make."""

    group: str
    kind: str
    effect: str | None = None
    rho: float = 0.5
    rows: int | None = None
    noise: str | None = None
    weeks: float | None = None

    def make(self, seed: int) -> Case:
        """Make the case."""
        return make_case(
            self.kind,
            seed,
            effect=self.effect,
            rho=self.rho,
            rows=self.rows,
            noise=self.noise,
            weeks=self.weeks,
        )

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self)


def small() -> list[Spec]:
    """Return about a hundred cases that touch every row of the table."""
    return [
        *(Spec("null", "null", noise=noise) for noise in NOISES for _ in range(6)),
        *(Spec("one", "one", effect) for effect in HIDEABLE),
        *(Spec("degenerate", "degenerate", twin) for twin in TWINS),
        *(Spec("two", "two", rho=0.7) for _ in range(6)),
        *(Spec("unknown", "unknown", name, 1.0) for name in UNCATALOGUED),
        *(Spec("region", "unknown", "region", 1.0) for _ in range(3)),
        *(Spec("curve", "one", "subreflector_jump", 1.0) for _ in range(3)),
        *(Spec("moment", "one", "epoch_offset", 1.0) for _ in range(3)),
        *(Spec("ablation", "ablation", steps) for steps in ("annual_aberration", "nutation")),
        *(Spec("zero", "one", effect, 0.0) for effect in ("refraction", "epoch_tilt", "drift")),
    ]


def full() -> list[Spec]:
    """Return the sets of the proof's table, near a thousand cases."""
    by_rho = ((0.05, 1), (0.1, 1), (0.25, 2), (0.5, 2), (1.0, 1))
    return [
        *(Spec("null", "null", noise=noise) for noise in NOISES for _ in range(60)),
        *(
            Spec("one", "one", effect, rho)
            for effect in HIDEABLE
            for rho, times in by_rho
            for _ in range(times)
        ),
        *(
            Spec("rows", "one", effect, 0.25, rows)
            for effect in ("azimuth_harmonics", "refraction", "thermal_tilt", "epoch_offset")
            for rows in (150, 300, 600, 2400)
            for _ in range(3)
        ),
        *(Spec("degenerate", "degenerate", twin) for twin in TWINS for _ in range(9)),
        *(Spec("two", "two", rho=rho) for rho in (0.5, 0.7, 1.0) for _ in range(20)),
        *(Spec("unknown", "unknown", name, 1.0) for name in UNCATALOGUED for _ in range(10)),
        *(Spec("region", "unknown", "region", 1.0) for _ in range(15)),
        *(Spec("curve", "one", "subreflector_jump", 1.0) for _ in range(15)),
        *(
            Spec("moment", "one", effect, 1.0)
            for effect in ("epoch_offset", "epoch_tilt")
            for _ in range(10)
        ),
        *(Spec("ablation", "ablation", steps) for steps in _ABLATIONS),
        *(Spec("ablation", "held", "ut1", 0.3, 5615) for _ in range(3)),
        *(
            Spec("weeks", "ablation", "nutation", weeks=weeks)
            for weeks in (1, 2, 4, 8, 16, 32, 64)
            for _ in range(3)
        ),
        *(Spec("zero", "one", effect, 0.0) for effect in HIDEABLE),
    ]


#: Sets by name.
SETS = {"small": small, "full": full}


def shuffled(specs: list[Spec], rng: np.random.Generator) -> list[Spec]:
    """Return the cases in an order that tells nothing."""
    return [specs[i] for i in rng.permutation(len(specs))]
