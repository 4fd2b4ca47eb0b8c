"""The published routines, statement by statement: same names, same order, same roundings.

``model``, ``modela`` and ``hjump`` equal the compiled Fortran bit for bit. They answer one
question, whether the port is the published program; :mod:`pyport.pointing` says what the telescope
does.

Azimuth is counted from South through West, angles are in radians, offsets and parameters in
degrees. Arguments and results are REAL*4, ``numpy.float32``.
"""

from pathlib import Path

from pyport.legacy.hjump import hjump
from pyport.legacy.model import model
from pyport.legacy.modela import modela

#: The description that holds the ports to the published text; `legacy_fortran` in the source tree.
PARITY = Path(__file__).parent / "fortran" / "parity.toml"

__all__ = ["PARITY", "hjump", "model", "modela"]
