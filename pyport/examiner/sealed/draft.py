"""What is drawn by chance for a set, all of it before the first case is made.

It lies in the vault until the set is sealed: sealing that was killed goes on
with the same seeds and nonces, and makes what it would have made.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.examiner.sealed import hashes
from pyport.examiner.sealed.protocol import Spec, shuffled
from pyport.examiner.sealed.published import read_json
from pyport.files import write_whole

LIBRARIES = ("numpy", "scipy", "astropy", "pyerfa")


def draft(
    path: Path, name: str, specs: Sequence[Spec], solver: str | None = None
) -> dict[str, Any]:
    """Draw the order, seeds and nonces of a set, or return those that were drawn for it before.

    `path`: where it is kept.
    `name`, `specs`: the set and its cases.
    `solver`: tree hash of the solver; that of this program when not given.
    Raises `BadInput`: what was drawn before is for another set, or for another program.
    """
    asked = {
        "name": name,
        "specs": sorted(json.dumps(one.as_json(), sort_keys=True) for one in specs),
        "solver_sha256": solver or hashes.solver(),
        "examiner_sha256": hashes.examiner(),
        "libraries": {library: version(library) for library in LIBRARIES},
    }
    if path.exists():
        return _as_asked(path, asked)
    order = shuffled(list(specs), np.random.default_rng(secrets.randbits(128)))
    cases = [
        {
            "case": f"case-{number:04d}",
            "seed": secrets.randbits(64),
            "nonce": secrets.token_hex(32),
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
