"""Finds, names and models what a radio telescope's pointing model leaves out."""

__version__ = "0.1.0"
