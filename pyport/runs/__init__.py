"""Runs: who does the work, how long each stage takes, and how far a long one has come."""
