"""What is on trial: the cases of each set, and what they must show. Frozen before sealing.

It lies in the vault until the set is sealed: sealing that was killed goes on
with the same seeds and nonces, and makes what it would have made.
"""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.examiner.real.injected import causes_of, names
from pyport.examiner.sealed.record import files
from pyport.examiner.sealed.record.published import read_json
from pyport.examiner.worlds.campaign import NOISES, SKIES
from pyport.examiner.worlds.case import LITTLE
from pyport.examiner.worlds.faults import UNKNOWN
from pyport.examiner.worlds.kinds import HIDEABLE, MODELS, STANDS, Spec
from pyport.examiner.worlds.twins import TWINS
from pyport.files import write_file

#: What each row of the score must reach, as the proof's table has it.
THRESHOLDS: dict[str, float] = {
    "null_claims_most": 0.05,
    "one_first_least": 0.90,
    "one_three_least": 0.97,
    "one_clean_least": 0.85,
    "beside_most": 0.05,
    "one_rho_least": 0.25,
    "efficiency_least": 0.9,
    "efficiency_rows_least": 100,
    "ablation_class_least": 1.0,
    "ablation_sigmas_most": 2.0,
    "degenerate_class_least": 0.95,
    "two_both_least": 0.70,
    "three_all_least": 0.50,
    "unknown_least": 0.80,
    "driven_epochs_most": 0.05,
    "mounts_behind_most": 0.03,
    "real_claims_most": 0.05,
    "real_first_least": 0.85,
    "region_iou_least": 0.5,
    "curve_deg_most": 2.0,
    "moment_rows_most": 2.0,
    "skill_least": 0.9,
    "skill_rho_least": 0.5,
    "worse_most": 0.0,
    "zero_claims_most": 0.05,
    "one_sigma_least": 0.64,
    "one_sigma_most": 0.72,
    "two_sigma_least": 0.93,
    "two_sigma_most": 0.97,
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
#: Causes of which files with little in them show enough, and those that have to do with time.
_BY_PLACE = (
    *("sag_sine", "azimuth_eccentricity", "azimuth_harmonics", "elevation_harmonics"),
    *("elevation_encoder_harmonics", "azimuth_track", "refraction"),
)
_BY_TIME = ("epoch_offset", "epoch_tilt", "epoch_sag", "oscillation")
#: Causes behind other models than the classical one, and those of every mount.
_BEHIND = ("refraction", "azimuth_track", "epoch_offset", "temperature", "scan_direction")
_ROWS = (60, 100, 150, 300, 600, 1200, 2400)
_RHOS = (0.25, 0.5, 1.0)
#: Causes that have to do with a moment or a condition, one group of the score each.
_OCCASIONS = ("rotator_circle", "quarter_day", "slew_hysteresis")


def _each(some: Sequence[str], count: int, start: int = 0) -> list[str]:
    """Return `count` of some names, in turn."""
    return [some[(start + n) % len(some)] for n in range(count)]


def _nulls(each: int, others: int) -> list[Spec]:
    """Return cases with nothing in them: every noise by every sky, other mounts, models, files."""
    by_noise = [
        Spec("null", "null", noise=noise, sky=SKIES[n % len(SKIES)], rows=(300, 100, 600)[n % 3])
        for noise in NOISES
        for n in range(each)
    ]
    return [
        *by_noise,
        *(Spec("null", "null", mount=one, rows=300) for one in STANDS for _ in range(others)),
        *(Spec("null", "null", model=one, rows=400) for one in MODELS for _ in range(others)),
        *(Spec("null", "null", little=one, rows=300) for one in LITTLE for _ in range(others)),
    ]


def _cells(each: int) -> list[Spec]:
    """Return single causes in every cell of rows and loudness, other ones in each."""
    cells = [(rows, rho) for rho in _RHOS for rows in _ROWS]
    return [
        Spec("rows", "one", effect, rho, rows)
        for n, (rows, rho) in enumerate(cells)
        for effect in _each(HIDEABLE, each, n * each)
    ]


def _circumstances(each: int) -> list[Spec]:
    """Return causes on other mounts, in little files, behind other models, at times, in arrays.

    Each cause on another mount has its like on an alt-azimuth one, where that can have it.
    """
    mounts = [
        Spec("mounts", "one", effect, 0.5, 400, mount=mount)
        for mount, some in STANDS.items()
        for effect in _each(some, 2 * each)
    ]
    altaz = [replace(one, mount=None) for one in mounts if one.effect in HIDEABLE]
    little = [
        Spec("little", "one", effect, 0.5, 400, little=what)
        for what, some in (("place", _BY_PLACE), ("time", (*_BY_TIME, *_BY_PLACE)))
        for effect in _each(some, 2 * each)
    ]
    return [
        *mounts,
        *altaz,
        *little,
        *(
            Spec("models", "one", effect, 0.5, 600, model=model)
            for model in MODELS
            for effect in _each(_BEHIND, each)
        ),
        *(
            Spec("when", "one", effect, 0.7, 600)
            for effect in ("starting", "stopping", "growing")
            for _ in range(2 * each)
        ),
        *(Spec("array", "array", rho=0.7, rows=900) for _ in range(3 * each)),
        *(
            Spec("oscillation", "one", effect, 0.5, 1200)
            for effect in ("oscillation", "wandering_oscillation")
            for _ in range(each)
        ),
        *(Spec("driven", "one", "driven", 0.7, 600) for _ in range(2 * each)),
        *(Spec(one, "one", one, 0.7, 600) for one in _OCCASIONS for _ in range(each)),
    ]


def _real(data: str | None, nulls: int, each: int) -> list[Spec]:
    """Return cases in the noise of real sets; those of a folder of data, or the shipped ones."""
    return [
        *(
            Spec("real null", "real", rho=0.0, real=name, data=data)
            for name in names(data)
            for _ in range(nulls)
        ),
        *(
            Spec("real", "real", effect, 0.5, real=name, data=data)
            for n, name in enumerate(names(data))
            if (some := causes_of(name, data))
            for effect in _each(some, each if len(some) > 1 else 2, n)
        ),
    ]


def small(data: str | None = None) -> list[Spec]:
    """Return about a hundred and fifty cases that touch every row of the table."""
    return [
        *_nulls(1, 1),
        *(Spec("one", "one", effect, rows=600) for effect in HIDEABLE[::3]),
        *_cells(1),
        *(Spec("degenerate", "degenerate", twin) for twin in TWINS),
        *(Spec("two", "two", rho=0.7) for _ in range(2)),
        *(Spec("three", "three", rho=0.7) for _ in range(2)),
        *(Spec("unknown", "unknown", name, 1.0, 600) for name in UNKNOWN),
        Spec("region", "unknown", "region", 1.0),
        Spec("curve", "one", "subreflector_jump", 1.0),
        Spec("moment", "one", "epoch_offset", 1.0),
        Spec("ablation", "ablation", "nutation"),
        Spec("zero", "one", "refraction", 0.0),
        *_circumstances(1),
        *_real(data, 0, 1)[:4],
        *_real(data, 1, 0)[:4],
    ]


def full(data: str | None = None) -> list[Spec]:
    """Return the sets of the proof's table, about sixteen hundred cases."""
    by_rho = ((0.05, 1), (0.1, 1), (0.25, 2), (0.5, 2), (1.0, 1))
    return [
        *_nulls(15, 12),
        *(
            Spec("one", "one", effect, rho)
            for effect in HIDEABLE
            for rho, times in by_rho
            for _ in range(times)
        ),
        *_cells(12),
        *(Spec("degenerate", "degenerate", twin) for twin in TWINS for _ in range(6)),
        *(Spec("two", "two", rho=rho) for rho in (0.5, 0.7, 1.0) for _ in range(12)),
        *(Spec("three", "three", rho=0.7) for _ in range(24)),
        *(Spec("unknown", "unknown", name, 1.0, 600) for name in UNKNOWN for _ in range(6)),
        *(Spec("region", "unknown", "region", 1.0) for _ in range(15)),
        *(Spec("curve", "one", "subreflector_jump", 1.0) for _ in range(12)),
        *(
            Spec("moment", "one", effect, 1.0)
            for effect in ("epoch_offset", "epoch_tilt")
            for _ in range(8)
        ),
        *(Spec("ablation", "ablation", steps) for steps in _ABLATIONS),
        *(Spec("ablation", "held", "ut1", 0.3, 5615) for _ in range(3)),
        *(Spec("weeks", "ablation", "nutation", weeks=weeks) for weeks in (1, 2, 4, 8, 16, 32, 64)),
        *(Spec("zero", "one", effect, 0.0) for effect in HIDEABLE),
        *_circumstances(9),
        *_real(data, 4, 7),
    ]


def there(data: Path) -> str | None:
    """Return a folder of public recordings as a case names it, if it is there."""
    return str(data) if data.is_dir() else None


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
    write_file(path, json.dumps(drawn))
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
