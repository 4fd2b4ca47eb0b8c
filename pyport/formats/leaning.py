"""Models of mounts whose first axis leans: the Field System's files do not say of which kind."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path

from pyport.effects.mounts import MOUNT, MOUNTS, declared
from pyport.errors import BadInput
from pyport.files import is_file
from pyport.formats import models
from pyport.mounts import ALTAZ, KINDS, Mount
from pyport.recordings.mounted import ALSO


def leans(model: str | Path) -> bool:
    """Tell whether a file has a model of a first axis that leans, and not of which mount.

    The Field System and DISCOS give phi, the elevation of that axis, and nothing else.
    """
    path, _ = models.split(model)
    if not is_file(path) or (path.suffix.lower() == ".toml" and not models.names_terms(path)):
        return False
    return models.read(model).phi_deg != Decimal(90)


def refuse_leaning(model: str | Path) -> None:
    """Refuse a model of a first axis that leans where no mount can be stated.

    Raises `BadInput`: it is one.
    """
    if leans(model):
        raise BadInput("phi is not 90 deg, expected a model of azimuth and elevation", Path(model))


def stated(keys: Mapping[str, str]) -> Mount:
    """Return the kind of mount that header keys state, the alt-azimuth where they state none.

    Raises `BadInput`: they state a mount that is not known.
    """
    words = [ALSO.get(word, word) for word in declared(keys)]
    if wrong := [word for word in words if word not in MOUNTS and word not in KINDS]:
        known = ", ".join((*KINDS, *MOUNTS))
        raise BadInput(f"{MOUNT} is {wrong[0]!r}, expected one or more of {known}")
    return next((KINDS[word] for word in words if word in KINDS), ALTAZ)
