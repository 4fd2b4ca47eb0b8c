"""What the RT32 does: its pointing models in float64, over arrays of any shape."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyport.pointing.approximate import approximate_columns, approximate_offsets
    from pyport.pointing.exact import exact_offsets
    from pyport.pointing.jump import has_jumped, jump_altitude
    from pyport.pointing.model import Rt32Model
    from pyport.pointing.parameters import PARAMETERS, printed, printed_sigmas, recovered

# A table of the exact form does not need the catalogue of effects, the printed one not even numpy.
_HOMES = {
    "PARAMETERS": "parameters",
    "Rt32Model": "model",
    "approximate_columns": "approximate",
    "approximate_offsets": "approximate",
    "exact_offsets": "exact",
    "has_jumped": "jump",
    "jump_altitude": "jump",
    "printed": "parameters",
    "printed_sigmas": "parameters",
    "recovered": "parameters",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


__all__ = [
    "PARAMETERS",
    "Rt32Model",
    "approximate_columns",
    "approximate_offsets",
    "exact_offsets",
    "has_jumped",
    "jump_altitude",
    "printed",
    "printed_sigmas",
    "recovered",
]
