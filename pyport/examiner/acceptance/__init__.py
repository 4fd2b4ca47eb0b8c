"""Acceptance: every figure that is promised of a diagnosis, measured anew."""
