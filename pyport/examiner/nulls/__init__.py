"""Recordings in which nothing is hidden, or one cause, in every kind of noise."""
