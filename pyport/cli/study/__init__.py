"""`pyport study`: the analyses of two documents, repeated on their data."""

from __future__ import annotations

from pyport.cli.groups import Lazy

command = Lazy(
    "study",
    "pyport.cli.study",
    {
        "gmrt": "Repeat the GMRT paper's analysis on its own tables.",
        "gmrt-array": "Analyse the GMRT's recordings as those of one array; compare with a survey.",
        "rt32": "Repeat the RT32 document's fit and figures, on a simulated campaign or your own.",
    },
    help="Repeat the analyses of the two documents that the program began with.",
)
