"""What the RT32 does: its pointing models in float64, over arrays of any shape."""

from typing import TYPE_CHECKING

from pyport import lazy
from pyport.pointing.exact import exact_offsets
from pyport.pointing.jump import has_jumped, jump_altitude
from pyport.pointing.parameters import PARAMETERS, printed, printed_sigmas, recovered

if TYPE_CHECKING:
    from pyport.pointing.approximate import approximate_columns, approximate_offsets
    from pyport.pointing.model import Rt32Model

# These know the catalogue of effects, which a table of the exact form does not need.
__getattr__ = lazy.loader(
    __name__,
    {
        "Rt32Model": "model",
        "approximate_columns": "approximate",
        "approximate_offsets": "approximate",
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
