"""Least squares of measured offsets: stacked, weighted, as sums that add up over pieces."""
