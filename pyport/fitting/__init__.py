"""Least squares: models as lists of effects, sufficient statistics, robust weights."""
