"""The GMRT paper's analysis done again: its curves, what they mean, what repeats, what mirrors."""

from __future__ import annotations
