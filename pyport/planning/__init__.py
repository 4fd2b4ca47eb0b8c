"""A look at recordings before anything is fitted: what they could show, what to observe next."""

from __future__ import annotations

from pyport.planning.look import Look, look

__all__ = ["Look", "look"]
