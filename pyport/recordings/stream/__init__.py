"""Data sets too big for memory: folders of Parquet, reduced to normal points chunk by chunk.

A normal point is what the readings of one antenna, session, ... that were taken
close together in the sky and in time have in common: their mean, robustly
weighted, and their scatter. For an effect that changes little within a point the
points tell all that the rows do. Every row goes into one of them, or is counted
among the excluded, or as an outlier.
"""

from pyport.recordings.stream.reduce import is_data_set, pass_files, read_data_set

__all__ = ["is_data_set", "pass_files", "read_data_set"]
