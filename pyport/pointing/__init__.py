"""What the RT32 does: its pointing models in float64, over arrays of any shape."""

from typing import TYPE_CHECKING

from pyport import lazy

if TYPE_CHECKING:
    from pyport.pointing.approximate import approximate_columns, approximate_offsets
    from pyport.pointing.exact import exact_offsets
    from pyport.pointing.jump import has_jumped, jump_altitude
    from pyport.pointing.model import Rt32Model
    from pyport.pointing.parameters import PARAMETERS, printed, printed_sigmas, recovered

# A table of the exact form does not need the catalogue of effects, the printed one not even numpy.
__getattr__ = lazy.loader(
    __name__,
    {
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
    },
)

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
