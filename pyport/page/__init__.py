"""The page: what was found, drawn so that it can be looked at, in one file without a network."""

from __future__ import annotations

from pyport.page.document import html, write
from pyport.page.of_diagnosis import of_diagnosis
from pyport.page.of_fit import of_fit

__all__ = ["html", "of_diagnosis", "of_fit", "write"]
