"""Diagnosis: noise, detect, locate, identify, check, and what cannot be named."""
