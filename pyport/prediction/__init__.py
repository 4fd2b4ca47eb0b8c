"""Predictions: how well models point where they were not fitted, and the best that can be done."""
