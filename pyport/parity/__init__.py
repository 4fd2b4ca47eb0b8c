"""Is the port the program that was published? Both ports held to the compiled Fortran."""

from pyport.parity.report import summary

__all__ = ["summary"]
