"""Observation files of TPOINT."""
