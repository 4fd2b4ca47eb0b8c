"""Pictures as PNG, SVG or PDF: panels for print, and one of each finding."""

from __future__ import annotations

from pyport.plots.panels import panels
from pyport.plots.pictures import FORMATS, write

__all__ = ["FORMATS", "panels", "write"]
