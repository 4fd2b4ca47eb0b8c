"""Nights put to the watch: without any change, in every kind of noise, and with a step."""
