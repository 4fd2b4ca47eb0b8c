"""Noise: everything that scatters readings about a model, one estimator for every command."""
