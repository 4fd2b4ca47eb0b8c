"""The search for what is missing: turn by turn, confirmed, and settled as a whole."""
