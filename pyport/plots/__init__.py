"""Panels for print: the page's pictures as PNG, SVG or PDF."""

from __future__ import annotations

from pyport.plots.files import FORMATS, write
from pyport.plots.panels import panels

__all__ = ["FORMATS", "panels", "write"]
