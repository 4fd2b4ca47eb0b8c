"""The table that a telescope is steered by: made, written, read and held to the published one."""

from pyport.steering.ascii import read_ascii, write_ascii
from pyport.steering.binary import map_binary, read_binary, write_binary
from pyport.steering.check import BlockCheck, check
from pyport.steering.grid import RT32_GRID, Difference, Grid, Table, compare
from pyport.steering.lookup import offsets_at, read_table
from pyport.steering.tabulate import DEFAULT_REFRACTION, READINGS, tabulate

__all__ = [
    "DEFAULT_REFRACTION",
    "READINGS",
    "RT32_GRID",
    "BlockCheck",
    "Difference",
    "Grid",
    "Table",
    "check",
    "compare",
    "map_binary",
    "offsets_at",
    "read_ascii",
    "read_binary",
    "read_table",
    "tabulate",
    "write_ascii",
    "write_binary",
]
