"""The table that a telescope is steered by: made, written, read and held to the published one."""

from pyport.steering.ascii import read_ascii, write_ascii
from pyport.steering.check import BlockCheck, check
from pyport.steering.grid import RT32_GRID, Grid, Table
from pyport.steering.tabulate import DEFAULT_REFRACTION, tabulate

__all__ = [
    "DEFAULT_REFRACTION",
    "RT32_GRID",
    "BlockCheck",
    "Grid",
    "Table",
    "check",
    "read_ascii",
    "tabulate",
    "write_ascii",
]
