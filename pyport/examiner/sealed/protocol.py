"""What is on trial: the cases of each set, and what they must show. Frozen before sealing.

It lies in the vault until the set is sealed: sealing that was killed goes on
with the same seeds and nonces, and makes what it would have made.
"""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.examiner.sealed import files
from pyport.examiner.sealed.published import read_json
from pyport.examiner.worlds.campaign import NOISES
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.faults import UNCATALOGUED
from pyport.examiner.worlds.kinds import HIDEABLE, TWINS, make_case
from pyport.files import write_whole

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


LIBRARIES = ("numpy", "scipy", "astropy", "pyerfa")


def draft(path: Path, name: str, specs: Sequence[Spec], chance: random.Random) -> dict[str, Any]:
    """Draw the order, seeds and nonces of a set, or return those that were drawn for it before.

    `path`: where it is kept.
    `name`, `specs`: the set and its cases.
    `chance`: what is drawn from.
    Raises `BadInput`: what was drawn before is for another set, or for another program.
    """
    asked = {
        "name": name,
        "specs": sorted(json.dumps(one.as_json(), sort_keys=True) for one in specs),
        "solver_sha256": files.solver(),
        "examiner_sha256": files.examiner(),
        "libraries": {library: version(library) for library in LIBRARIES},
    }
    if path.exists():
        return _as_asked(path, asked)
    order = shuffled(list(specs), np.random.default_rng(chance.getrandbits(128)))
    cases = [
        {
            "case": f"case-{number:04d}",
            "seed": chance.getrandbits(64),
            "nonce": f"{chance.getrandbits(256):064x}",
            "spec": spec.as_json(),
        }
        for number, spec in enumerate(order, start=1)
    ]
    drawn = {**asked, "cases": cases}
    with write_whole(path) as file:
        json.dump(drawn, file)
    return drawn


def _as_asked(path: Path, asked: dict[str, Any]) -> dict[str, Any]:
    drawn: dict[str, Any] = read_json(path)
    for key, now in asked.items():
        if drawn.get(key) != now:
            what = "list of cases" if key == "specs" else key.removesuffix("_sha256")
            raise BadInput(
                f"sealing was begun with another {what}: expected the same, or a new folder", path
            )
    return drawn
