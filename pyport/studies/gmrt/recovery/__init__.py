"""The GMRT's elevation offsets of 2003, recovered from the paper's tables as printed.

`printed/` holds the tables as printed; `python -m pyport.studies.gmrt.recovery` makes the shipped
recordings of them; README.md says how.
"""
