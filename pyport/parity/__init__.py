"""Is a port the program that was written? Python held to the compiled Fortran, to the last bit.

A description, `parity.toml`, says which Fortran files and routines, which ports and what they
promise; nothing here knows any program.
"""
