"""Panels for print: the page's pictures as PNG, SVG or PDF."""

from __future__ import annotations

from pyport.plots.panels import panels
from pyport.report.pictures import FORMATS, write

__all__ = ["FORMATS", "panels", "write"]
