"""`python -m pyport` is the `pyport` command."""

from pyport.cli import main

main()
