"""What the RT32 does: its pointing models in float64, over arrays of any shape."""

from pyport.pointing.approximate import approximate_columns, approximate_offsets
from pyport.pointing.exact import exact_offsets
from pyport.pointing.jump import has_jumped, jump_altitude
from pyport.pointing.model import Rt32Model
from pyport.pointing.parameters import PARAMETERS, printed, printed_sigmas, recovered

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
