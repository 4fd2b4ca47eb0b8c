"""Misfits of no particular form, edges, boxes and waves: what has no name or is a curve."""
